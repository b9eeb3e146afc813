from collections.abc import Callable
from pathlib import Path

import pytest

from tracerisk.common import trace_json
from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import LaunchChoice, choose_launch
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.trace import Trace

OUTPUTS = ("--json", "--trace", "trace.json", "--model", "model.json")


def ran(example, source: bytes):
    example.write("pick_and_place.py", source)
    outcome = example.run("run", "pick_and_place.py", *OUTPUTS)
    assert outcome.code == 0, outcome.err
    return example, outcome


@pytest.fixture(scope="session")
def short_source(pick_and_place) -> bytes:
    """The sample with two tubes of ten."""
    return pick_and_place.replace(b"TUBES = 10\n", b"TUBES = 2\n")


@pytest.fixture(scope="session")
def short_run(tmp_path_factory, short_source, example_in):
    """One run of it: the folder with all its outputs, and the command's outcome."""
    return ran(example_in(tmp_path_factory.mktemp("short")), short_source)


@pytest.fixture(scope="session", params=[2, pytest.param(10, marks=pytest.mark.slow)])
def tubes(request) -> int:
    """How many tubes of the sample are moved: as few as show the law, and in a slow test all."""
    return request.param


@pytest.fixture(scope="session")
def sample_run(tubes, request, tmp_path_factory, pick_and_place, example_in):
    """One run of the sample, as `short_run`."""
    if tubes == 2:
        return request.getfixturevalue("short_run")
    return ran(example_in(tmp_path_factory.mktemp("sample")), pick_and_place)


@pytest.fixture(scope="session")
def short_trace(short_run) -> Trace:
    example, _ = short_run
    return trace_json.loads(example.read("trace.json").decode(), "trace.json")


@pytest.fixture(scope="session")
def sample_trace(sample_run) -> Trace:
    example, _ = sample_run
    return trace_json.loads(example.read("trace.json").decode(), "trace.json")


PACKAGE = "<package><name>{}</name></package>\n"


class LaunchWorkspace:
    """A workspace of one package, `arm_task`, with a controller and the launch files around it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.package = folder / "src/arm_task"
        self.write("package.xml", PACKAGE.format("arm_task"))

    def write(self, name: str, text: str) -> Path:
        path = self.package / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def choose(self, script: str, launch: str | bool = True) -> LaunchChoice:
        return choose_launch(load_controller(self.package / script), Settings(launch=launch))


@pytest.fixture
def workspace(tmp_path: Path) -> LaunchWorkspace:
    return LaunchWorkspace(tmp_path)


@pytest.fixture
def given() -> Callable[[LaunchChoice], dict[str, object]]:
    """The parameters of a choice by their names."""

    def names(choice: LaunchChoice) -> dict[str, object]:
        assert choice.setup is not None, choice.notes
        return {each.name: each.value for each in choice.setup.parameters}

    return names
