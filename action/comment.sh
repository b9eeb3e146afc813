#!/usr/bin/env bash
# Keep one comment on the pull request up to date; keep still where there is nothing to say.
set -euo pipefail
body="$RUNNER_TEMP/tracerisk/comment.md"
tag='<!-- tracerisk-diff -->'
[ -f "$body" ] || exit 0

earlier=$(gh api --paginate "repos/$REPOSITORY/issues/$PULL_REQUEST/comments" \
    --jq ".[] | select(.body | startswith(\"$tag\")) | .id" | head -n 1)

if [ ! -s "$body" ]; then
    [ -n "$earlier" ] || exit 0
    printf '%s\n**No change of risk worth telling any more.**\n' "$tag" >"$body"
fi
if [ -n "$earlier" ]; then
    gh api --method PATCH "repos/$REPOSITORY/issues/comments/$earlier" --field "body=@$body" >/dev/null
else
    gh api --method POST "repos/$REPOSITORY/issues/$PULL_REQUEST/comments" --field "body=@$body" >/dev/null
fi
