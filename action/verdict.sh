#!/usr/bin/env bash
# Fail last, so that comment, alerts and report are there whatever was found.
set -euo pipefail
code=0
if [ "${CHECK:-0}" -ne 0 ]; then
    echo "::error title=tracerisk check::the risk blocks cannot be trusted as they stand, or their run went wrong (exit code $CHECK)"
    code=$CHECK
fi
if [ "${DIFF:-0}" -ne 0 ]; then
    what="a limit on the risk is exceeded, or the run went wrong"
    [ "$DIFF" -eq 1 ] || what="the change of risk could not be determined"
    echo "::error title=tracerisk diff::$what (exit code $DIFF)"
    [ "$code" -ne 0 ] || code=$DIFF
fi
exit "$code"
