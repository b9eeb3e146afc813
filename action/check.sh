#!/usr/bin/env bash
# Whether the blocks can be trusted as they stand, and the run behind them; never simulates.
source "${0%/*}/shared.sh"
limits=()
[ -z "${BASE:-}" ] || limits+=(--base "$BASE")
[ -z "${MIN_COVERAGE:-}" ] || limits+=("--min-coverage=$MIN_COVERAGE")
check() {
    [ -z "${BASE:-}" ] || fetch_base || return
    tracerisk check "${limits[@]}" --sarif "$folder/sarif/tracerisk.sarif" -- "${files[@]}"
}
keep_code check
