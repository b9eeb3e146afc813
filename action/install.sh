#!/usr/bin/env bash
# Install tracerisk into an environment of its own, so that it meets no package of the project.
set -euo pipefail
folder="$RUNNER_TEMP/tracerisk"
mkdir -p "$folder/sarif"
python -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check "$ACTION"
"$folder/venv/bin/tracerisk" --version
