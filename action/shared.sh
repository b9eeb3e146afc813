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
