# What the steps share; they are run one by one and hand on only files and outputs.
# A file of the checkout must never be run: neither by a shell, nor by Python, git or a runner.
set -euo pipefail
folder="$RUNNER_TEMP/tracerisk"

# What is looked up below the current folder, the checkout may provide.
clean=
while IFS= read -r -d : each; do
    case "$each" in /*) clean="${clean:+$clean:}$each" ;; esac
done <<<"$PATH:"
PATH=$clean
unset BASH_ENV ENV CDPATH PYTHONPATH PYTHONHOME PYTHONSTARTUP PYTHONUSERBASE

# Settings of git that name programs count only where they cannot be those of the checkout.
set_git() {
    local count=${GIT_CONFIG_COUNT:-0}
    export "GIT_CONFIG_KEY_$count=$1" "GIT_CONFIG_VALUE_$count=$2" GIT_CONFIG_COUNT=$((count + 1))
}
set_git safe.bareRepository explicit
set_git core.fsmonitor false
set_git core.hooksPath /dev/null
set_git fetch.recurseSubmodules false

# Isolated: neither the current folder nor the environment says what is imported.
tracerisk() { "$folder/venv/bin/python" -I -m tracerisk "$@"; }

files=()
while IFS= read -r each; do
    [ -z "${each//[[:space:]]/}" ] || files+=("$each")
done <<<"${FILES:-}"

# What is printed names files of the checkout: none of it is a command to the runner.
quoted() {
    local code=0 word
    word=$(od -An -N16 -tx1 /dev/urandom | tr -d ' \n')
    echo "::stop-commands::$word"
    "$@" || code=$?
    printf '\n::%s::\n' "$word"
    return "$code"
}

# Run a command, keep what it prints, and hand on its exit code, also as `code`, instead of stopping.
keep_code() {
    code=0
    quoted "$@" || code=$?
    echo "code=$code" >>"$GITHUB_OUTPUT"
}

# What begins a comment by which it is found again.
tag='<!-- tracerisk-diff -->'

# Print the comment of a comparison that ended with a code which says nothing of the risk.
undetermined() {
    printf '%s\n**The change of risk could not be determined** (exit code %s): %s.\n' \
        "$tag" "$1" 'the log says why'
}

# Have a commit here, which a checkout of depth 1 may lack: of this name, or what a name stands for.
fetch_commit() {
    if ! [[ "$1" =~ ^[0-9a-f]{40}([0-9a-f]{24})?$ ]]; then
        echo "what is to be compared is no commit: nothing is compared" >&2
        return 2
    fi
    git cat-file -e "$1^{commit}" 2>/dev/null ||
        git fetch --quiet --no-tags --no-recurse-submodules "${@:3}" origin "${2:-$1}" ||
        return
    git cat-file -e "$1^{commit}"
}

# Have the commit before the pull request here.
fetch_base() { fetch_commit "$BASE" "$BASE" --depth=1; }
