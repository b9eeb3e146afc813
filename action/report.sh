#!/usr/bin/env bash
# One report for each controller; a report that cannot be made fails nothing.
source "$(dirname "$0")/shared.sh"
against=()
[ -z "${BASE:-}" ] || against=(--against "$BASE")
mkdir -p "$folder/report"
"$folder/venv/bin/python" -c '
import sys
from pathlib import Path
from tracerisk.pipeline.check import controllers_in, controllers_of
print(*(controllers_of(sys.argv[1:]) if sys.argv[1:] else controllers_in(Path())), sep="\n")
' "${files[@]}" | while IFS= read -r controller; do
    page="$folder/report/$(printf '%s' "${controller%.py}" | tr '/' '-').html"
    if ! "$tracerisk" report "$controller" --output "$page" "${against[@]}"; then
        echo "::warning title=tracerisk::no report of $controller could be made"
    fi
done
