"""An annotated controller of two steps, and an editor on it."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("pygls")

from tests.editor.client import Editor

NAME = "cell.py"


@pytest.fixture(scope="session")
def annotated(tmp_path_factory: pytest.TempPathFactory, example_in, quick) -> Path:
    """A folder with a controller that was run once; tests take copies."""
    folder = tmp_path_factory.mktemp("annotated")
    example = example_in(folder)
    source = quick().replace("    act(arm)", "    home(arm)\n    act(arm)")
    source = source.replace(
        "def main", "def never(arm):\n    arm.stop_here()\n    arm.go()\n\ndef main"
    )
    example.write(NAME, source)
    done = example.run("run", NAME)
    assert done.code == 0, done.err
    return folder


@pytest.fixture
def cell(annotated: Path, tmp_path: Path) -> Path:
    """The path of an annotated controller of one's own."""
    folder = tmp_path / "work"
    shutil.copytree(annotated, folder)
    return folder / NAME


@pytest.fixture(scope="module")
def editor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Editor]:
    found = Editor(tmp_path_factory.mktemp("workspace"))
    yield found
    found.end()
