#!/usr/bin/env bash
# What the pull request does to the risk, as the text of a comment.
source "$(dirname "$0")/shared.sh"
# A checkout of depth 1 lacks the base.
if ! git cat-file -e "$BASE^{commit}" 2>/dev/null; then
    git fetch --quiet --no-tags --depth=1 origin "$BASE"
fi
limits=()
[ -z "${MAX_INCREASE:-}" ] || limits+=(--max-increase "$MAX_INCREASE")
[ -z "${MAX_RISK:-}" ] || limits+=(--max-risk "$MAX_RISK")
[ -z "${SILENT_BELOW:-}" ] || limits+=(--silent-below "$SILENT_BELOW")
compare() {
    "$tracerisk" diff --format markdown "${limits[@]}" "$BASE..HEAD" "${files[@]}" \
        >"$folder/comment.md"
}
keep_code compare
if [ -n "${GITHUB_STEP_SUMMARY:-}" ]; then cat "$folder/comment.md" >>"$GITHUB_STEP_SUMMARY"; fi
