#!/usr/bin/env bash
# Keep one comment on the pull request up to date; keep still where there is nothing to say.
# Nothing to say there is only where the comparison ended with 0 or 1: DIFF.
# A comment that cannot be written fails nothing: alerts, report and verdict come after it.
source "${0%/*}/shared.sh"
cd "$RUNNER_TEMP"
body="$folder/comment.md"
mkdir -p "$folder"
case "${DIFF:-}" in
    0 | 1) ;;
    *) undetermined "${DIFF:-unknown}" >"$body" ;;
esac

give_up() {
    echo "::warning title=tracerisk::no comment could be written: the token needs pull-requests: write, which a pull request from a fork has not"
    exit 0
}

# Whoever holds the token: the one account whose comments are ours. A workflow's own is a bot.
me=$(gh api user --jq .login 2>/dev/null) || me='github-actions[bot]'
case "$me" in '' | *[!A-Za-z0-9_\[\]-]*) me='github-actions[bot]' ;; esac
earlier=$(gh api --paginate "repos/$REPOSITORY/issues/$PULL_REQUEST/comments" --jq \
    ".[] | select(.user.login == \"$me\" and (.body | startswith(\"$tag\"))) | .id" 2>/dev/null) ||
    give_up
earlier=${earlier%%$'\n'*}

if [ ! -s "$body" ]; then
    [ -n "$earlier" ] || exit 0
    printf '%s\n**No change of risk worth a comment any more.**\n' "$tag" >"$body"
elif [[ "${REPORT_URL:-}" =~ ^https://[A-Za-z0-9./:_-]+$ ]]; then
    # GitHub shows no picture or page of an artefact in a comment: it is a download.
    what='The reports'
    [ -z "$(find "$folder/report" -name '*.gif' -print -quit 2>/dev/null)" ] ||
        what='The reports, and films of the runs before and after'
    printf '\n[%s, as a download](%s)\n' "$what" "$REPORT_URL" >>"$body"
fi
if [ -n "$earlier" ]; then
    gh api --method PATCH "repos/$REPOSITORY/issues/comments/$earlier" \
        --field "body=@$body" >/dev/null || give_up
else
    gh api --method POST "repos/$REPOSITORY/issues/$PULL_REQUEST/comments" \
        --field "body=@$body" >/dev/null || give_up
fi
