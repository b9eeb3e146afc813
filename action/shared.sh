# What the steps share; they are run one by one and hand on only files and outputs.
set -euo pipefail
folder="$RUNNER_TEMP/tracerisk"
tracerisk="$folder/venv/bin/tracerisk"
mapfile -t files < <(printf '%s\n' "${FILES:-}" | sed '/^[[:space:]]*$/d')

# Run a command, keep what it prints, and hand on its exit code instead of stopping.
keep_code() {
    local code=0
    "$@" || code=$?
    echo "code=$code" >>"$GITHUB_OUTPUT"
}

# Have the commit before the pull request here: a checkout of depth 1 lacks it.
fetch_base() {
    git cat-file -e "$BASE^{commit}" 2>/dev/null ||
        git fetch --quiet --no-tags --depth=1 origin "$BASE"
}
