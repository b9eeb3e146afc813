"""The server in a real editor: a headless Neovim, where it is installed."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(shutil.which("nvim") is None, reason="needs Neovim")


def test_neovim_shows_figures_findings_and_fixes(cell, tmp_path):
    result = tmp_path / "found.json"
    home = tmp_path / "home"
    home.mkdir()
    done = subprocess.run(
        [
            "nvim",
            "--headless",
            "--clean",
            "-u",
            "NONE",
            "-S",
            Path(__file__).with_name("neovim.lua"),
        ],
        env={
            **os.environ,
            "HOME": str(home),
            "TRACERISK": str(Path(sys.executable).with_name("tracerisk")),
            "CONTROLLER": str(cell),
            "RESULT": str(result),
        },
        capture_output=True,
        text=True,
        timeout=120,
        stdin=subprocess.DEVNULL,
    )
    assert result.is_file(), done.stderr
    found = json.loads(result.read_text())
    assert found["hover"].startswith("**act**")
    assert any("% of the mission's failure probability" in each for each in found["lenses"])
    assert found["foldings"] > 4
    text = cell.read_text().split("\n")
    below = next(number for number, line in enumerate(text) if line.startswith("def act"))
    at = next(n for n, line in enumerate(text) if n > below and "quantity = 7" in line)
    assert found["diagnostics"] == [[at, "edited", 1]]
    assert found["is_back"]
