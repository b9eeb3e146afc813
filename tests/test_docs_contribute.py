"""`docs/contribute.md` is followed to the letter in a copy of the package."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs" / "contribute.md").read_text(encoding="utf-8")
FILES = re.findall(r'^```\w+ title="([^"]+)"\n(.*?)^```$', TEXT, re.MULTILINE | re.DOTALL)
COMMANDS = re.findall(r"^```sh\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
MOST_LINES = 60


def test_the_files_and_commands_of_each_section_work(tmp_path):
    leave = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "tracerisk", tmp_path / "tracerisk", ignore=leave)
    for name, text in FILES:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    script = 'tracerisk() { "$PYTHON" -m tracerisk "$@"; }\nset -eux\n' + "".join(COMMANDS)
    done = subprocess.run(
        ["/bin/sh", "-c", script],
        cwd=tmp_path,
        env={**os.environ, "PYTHON": sys.executable, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "My arm" in done.stdout
    assert "joint_encoder" in done.stdout
    assert "service pad/close (std_srvs/Trigger)" in done.stdout
    assert "complete, 1 of 1 function with commands ran" in done.stdout


def test_each_section_fits_a_screen_and_names_what_there_is():
    for section in TEXT.split("\n## ")[1:]:
        assert section.count("\n") <= MOST_LINES, section.splitlines()[0]
    named = re.findall(r"(?:tests|benchmarks)/[\w/.]*\w", TEXT)
    assert len(named) > 5
    assert [each for each in named if not (ROOT / each).exists()] == []
