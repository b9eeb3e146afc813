"""A link to a device without an end, or a pipe, where a file is expected: nobody reads or waits on."""

import os
import time
from contextlib import suppress
from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.editor.session import Session, analyse, controllers_with
from tracerisk.errors import TraceRiskError

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs pipes, devices and links")

SETTINGS = {
    "hardware.yaml": 'hardware = "hardware.yaml"',
    "cell.scenario.yaml": 'scenario = "cell.scenario.yaml"',
    "scene.xml": 'scene = "scene.xml"',
    "arm.urdf": 'robot = "arm.urdf"',
    "driver.yaml": 'drivers = ["driver.yaml"]',
    "params.yaml": 'params = ["params.yaml"]',
    "start.launch": 'launch = "start.launch"',
}
FILES = (
    *("controller.py", "tracerisk.lock", "pyproject.toml", "tracerisk.evidence", "package.xml"),
    *("setup.py", "helper.py", "README.md", ".gitattributes"),
    *SETTINGS,
)
KINDS = ("pipe", "device")
LONGEST_S = 60.0


def endless(path, kind):
    path.unlink(missing_ok=True)
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero")


@pytest.mark.parametrize(
    ("name", "kind"),
    slow_but(
        [("controller.py", "device"), ("tracerisk.lock", "pipe"), ("hardware.yaml", "device")],
        [(name, kind) for name in FILES for kind in KINDS],
    ),
)
def test_no_verb_and_no_editor_reads_on(annotated, name, kind):
    folder = Path(annotated.folder)
    annotated.write("pyproject.toml", f"[tool.tracerisk]\n{SETTINGS.get(name, '')}\n")
    endless(folder / name, kind)
    began = time.monotonic()
    for words in (
        *(("check",), ("check", "controller.py"), ("solve", "controller.py")),
        *(("diff",), ("overrides",), ("refresh", "controller.py")),
    ):
        outcome = annotated.run(*words)
        assert outcome.code in (0, 1, 2, 4), (words, outcome.err)
    session = Session()
    text = "def turn():\n    pass\n"
    document = session.put((folder / "controller.py").as_uri(), 1, text)
    with suppress(TraceRiskError):  # the server shows it
        for path in controllers_with(document, session.projects):
            analyse(path, session.opened, session.projects)
    assert time.monotonic() - began < LONGEST_S


@pytest.mark.parametrize("name", ["tracerisk.lock", "controller.py"])
def test_what_stands_there_is_said(annotated, name):
    endless(Path(annotated.folder) / name, "device")
    outcome = annotated.run("solve" if name == "controller.py" else "check", "controller.py")
    assert outcome.code == 2
    assert f"{name}: cannot be read: it is a device; put a regular file there" in outcome.err
