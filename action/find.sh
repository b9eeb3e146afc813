#!/usr/bin/env bash
# Find the pull request that an untrusted workflow was started for, by what GitHub itself says.
source "${0%/*}/shared.sh"
cd "$RUNNER_TEMP"
mkdir -p "$folder"
# The branch may have any name: only its commit is compared.
export HEAD
found=$(gh api --paginate --method GET "repos/$REPOSITORY/pulls" \
    --field state=open --field "head=$OWNER:$BRANCH" --jq \
    '.[] | select(.head.sha == env.HEAD) | "\(.number) \(.base.sha)"')
found=${found%%$'\n'*}
if [[ "$found" =~ ^([0-9]+)\ ([0-9a-f]{40}([0-9a-f]{24})?)$ ]]; then
    echo "number=${BASH_REMATCH[1]}" >>"$GITHUB_OUTPUT"
    echo "base=${BASH_REMATCH[2]}" >>"$GITHUB_OUTPUT"
else
    echo "no open pull request has the commit of that workflow: nothing to comment on"
fi
