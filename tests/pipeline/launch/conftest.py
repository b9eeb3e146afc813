from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import LaunchChoice, choose_launch
from tracerisk.pipeline.workspace.controller import load_controller

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
