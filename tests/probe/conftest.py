"""Run controllers under the probe, in a process of their own."""

import json
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import pytest

PROBE = Path(__file__).parents[2] / "probe"


def with_signals_as_from_a_terminal() -> None:
    """Undo what `nohup` and a shell's background do, who have children ignore these signals."""
    for number in (signal.SIGHUP, signal.SIGINT):
        signal.signal(number, signal.SIG_DFL)


class Probed:
    """A folder with controllers that run under the probe."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(self, name: str, text: str) -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text), encoding="utf-8")
        return path

    def command(self, *words: str, python: str = sys.executable) -> list[str]:
        return [python, "-m", "tracerisk_probe", "--out", "out.jsonl", *words]

    @property
    def environment(self) -> dict[str, str]:
        path = os.pathsep.join([str(PROBE), str(self.folder / "libraries")])
        return {**os.environ, "PYTHONPATH": path}

    def run(self, *words: str, **options: Any) -> subprocess.CompletedProcess[str]:
        return self.python(*self.command(*words), **options)

    def python(self, *command: str, **options: Any) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            command,
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
            preexec_fn=with_signals_as_from_a_terminal,
            **options,
        )

    @property
    def objects(self) -> list[dict[str, Any]]:
        text = (self.folder / "out.jsonl").read_text(encoding="utf-8")
        return [json.loads(line) for line in text.splitlines()]

    @property
    def commands(self) -> list[dict[str, Any]]:
        return [each for each in self.objects if "stack" in each]

    @property
    def names(self) -> list[list[str]]:
        return [[each.partition(":")[2] for each in found["stack"]] for found in self.commands]


@pytest.fixture
def probed(tmp_path: Path) -> Probed:
    return Probed(tmp_path)
