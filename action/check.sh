#!/usr/bin/env bash
# Whether the blocks can be trusted as they stand, and the run behind them; never simulates.
source "$(dirname "$0")/shared.sh"
keep_code "$tracerisk" check "${files[@]}" --sarif "$folder/sarif/tracerisk.sarif"
