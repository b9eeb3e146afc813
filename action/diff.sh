#!/usr/bin/env bash
# What the pull request does to the risk, as the text of a comment.
source "${0%/*}/shared.sh"
limits=()
[ -z "${MAX_INCREASE:-}" ] || limits+=("--max-increase=$MAX_INCREASE")
most=${MAX_FAILURE_PROBABILITY:-${MAX_RISK:-}}
[ -z "$most" ] || limits+=("--max-failure-probability=$most")
[ "${NO_NEW_ACCEPTS:-}" != true ] || limits+=(--no-new-accepts)
[ "${NO_WEAKER_CHECKS:-}" != true ] || limits+=(--no-weaker-checks)
[ "${NO_OUTCOME_CHANGE:-}" != true ] || limits+=(--no-outcome-change)
[ -z "${SILENT_BELOW:-}" ] || limits+=("--silent-below=$SILENT_BELOW")
compare() {
    fetch_base || return
    if [ -n "${HEAD:-}" ]; then
        # A pull request that is not checked out: its commits alone, as data.
        case "${PULL_REQUEST:-}" in '' | *[!0-9]*) return 2 ;; esac
        fetch_commit "$HEAD" "refs/pull/$PULL_REQUEST/head" || return
    fi
    tracerisk diff --format markdown "${limits[@]}" "$BASE..${HEAD:-HEAD}" -- "${files[@]}" \
        >"$folder/comment.md"
}
keep_code compare
# 1 is a limit; any other code comes with no comment, or with half of one.
[ "$code" -le 1 ] || undetermined "$code" >"$folder/comment.md"
if [ -n "${GITHUB_STEP_SUMMARY:-}" ]; then cat "$folder/comment.md" >>"$GITHUB_STEP_SUMMARY"; fi
