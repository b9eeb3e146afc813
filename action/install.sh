#!/usr/bin/env bash
# Install tracerisk into an environment of its own, so that it meets no package of the project.
source "${0%/*}/shared.sh"
mkdir -p "$folder/sarif"
# Away from the checkout, and isolated: none of its files is a module of ours.
cd "$RUNNER_TEMP"
python -I -m venv "$folder/venv"
# A replay is unpacked with NumPy, which nothing else needs here.
extra=
[ "${REPLAYS:-}" != true ] || extra='[large]'
# A film is drawn with the simulator's renderer.
[ "${FILM:-}" != true ] || extra='[sim]'
"$folder/venv/bin/python" -I -m pip install --quiet --disable-pip-version-check "$ACTION$extra"
tracerisk --version
