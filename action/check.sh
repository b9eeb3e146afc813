#!/usr/bin/env bash
# Whether the blocks can be trusted as they stand, and the run behind them; never simulates.
source "${0%/*}/shared.sh"
limits=()
if [ -n "${BASE:-}" ]; then
    fetch_base
    limits+=(--base "$BASE")
fi
[ -z "${MIN_COVERAGE:-}" ] || limits+=("--min-coverage=$MIN_COVERAGE")
keep_code tracerisk check "${limits[@]}" --sarif "$folder/sarif/tracerisk.sarif" -- "${files[@]}"
