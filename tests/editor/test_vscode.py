"""The extension for VS Code: its names are the server's, and its own tests pass where npm is."""

import json
import os
import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from tracerisk.editor.fixes import ACCEPT, ASKED_ACCEPT, ASKED_PIN, PIN, REFRESH

FOLDER = Path(__file__).parents[2] / "editors/vscode"
EXTENSION = (FOLDER / "src/extension.js").read_text()


def test_the_extension_has_the_commands_that_the_server_gives():
    registered = set(re.findall(r'register\("([\w.]+)"', EXTENSION))
    assert {ASKED_PIN, ASKED_ACCEPT} <= registered
    assert set(re.findall(r'ask\("([\w.]+)"', EXTENSION)) == {REFRESH, PIN, ACCEPT}
    assert "asksForReasons: true" in EXTENSION


def test_the_names_of_the_server_stay_free():
    """The client itself registers what the server can execute."""
    manifest = json.loads((FOLDER / "package.json").read_text())
    own = {each["command"] for each in manifest["contributes"]["commands"]}
    own |= set(re.findall(r'register\("([\w.]+)"', EXTENSION))
    assert not own & {REFRESH, PIN, ACCEPT}


def test_the_extension_has_an_icon_that_is_packed():
    manifest = json.loads((FOLDER / "package.json").read_text())
    image = (FOLDER / manifest["icon"]).read_bytes()
    assert image[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">2I", image[16:24])
    assert width == height >= 128, "the marketplace takes no smaller one"
    assert f"!{manifest['icon']}" in (FOLDER / ".vscodeignore").read_text().split()
    assert manifest["icon"] in manifest["scripts"]["icon"]


@pytest.mark.skipif(
    shutil.which("npm") is None or not (FOLDER / "node_modules").is_dir(),
    reason="needs `npm ci` in editors/vscode",
)
def test_the_tests_of_the_extension_pass():
    program = Path(sys.executable).with_name("tracerisk")
    done = subprocess.run(
        ["npm", "test"],
        cwd=FOLDER,
        env={**os.environ, "TRACERISK": str(program)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
