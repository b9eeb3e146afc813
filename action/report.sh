#!/usr/bin/env bash
# One report for each controller, and a film if asked for; what cannot be made fails nothing.
source "${0%/*}/shared.sh"
against=()
[ -z "${BASE:-}" ] || against=(--against "$BASE")
mkdir -p "$folder/report"
names="$folder/controllers"
failed=0
films_missing=0

controllers() {
    "$folder/venv/bin/python" -I -c '
import os, sys
from tracerisk.pipeline.freshness.known_controllers import named_or_all
from tracerisk.pipeline.workspace.project import Projects
found = named_or_all(sys.argv[1:], Projects())
sys.stdout.buffer.write(b"".join(os.fsencode(str(each)) + b"\0" for each in found))
' "${files[@]}" >"$names"
}

reports() {
    local controller name
    while IFS= read -r -d '' controller; do
        name=$(printf '%s' "${controller%.py}" | tr -c 'A-Za-z0-9._\n-' '-' | tr '\n' '-')
        tracerisk report --output "$folder/report/$name.html" "${against[@]}" -- "$controller" ||
            failed=$((failed + 1))
        if [ "${FILM:-}" = true ] && [ -n "${BASE:-}" ]; then
            tracerisk report --gif "$folder/report/$name.gif" "${against[@]}" -- "$controller" ||
                films_missing=$((films_missing + 1))
        fi
    done <"$names"
}

if quoted controllers; then
    quoted reports
else
    failed=$((failed + 1))
fi
if [ "$failed" -gt 0 ]; then
    echo "::warning title=tracerisk::$failed of the reports could not be made; see the log"
fi
if [ "$films_missing" -gt 0 ]; then
    echo "::warning title=tracerisk::$films_missing films could not be made; the log names what each needs"
fi
