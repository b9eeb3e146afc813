"""`docs/settings.md` lists every setting with its default and its option."""

import argparse
import re
from dataclasses import fields
from pathlib import Path
from typing import Any

from tracerisk.cli.authors import check, run
from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.common.settings.settings_file import loads_toml
from tracerisk.config import Settings

TEXT = (Path(__file__).parents[1] / "docs" / "settings.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| `(\w+)` \| (\S+) \| (.*?) \|", TEXT, re.MULTILINE)


def test_every_setting_is_listed_with_its_default():
    defaults: dict[str, Any] = {}
    for name, default, _ in ROWS:
        value = None if default == "none" else loads_toml(f"x = {default.strip('`')}")["x"]
        defaults[name] = tuple(value) if isinstance(value, list) else value
    assert defaults == {each.name: getattr(Settings(), each.name) for each in fields(Settings)}


def test_every_option_that_is_named_exists():
    parser = argparse.ArgumentParser()
    run.add_options(parser)
    checking = argparse.ArgumentParser()
    check.add_options(checking)
    actions = (*parser._actions, *checking._actions)
    known = {each for action in actions for each in action.option_strings}
    named = {option for _, _, options in ROWS for option in re.findall(r"`(--[\w-]+)`", options)}
    assert len(named) > 10
    assert named <= known


def test_the_example_is_read(tmp_path):
    example = TEXT.split("```toml\n")[1].split("```")[0]
    (tmp_path / "pyproject.toml").write_text(example)
    (tmp_path / "src").mkdir()
    (tmp_path / "src/pick.py").touch()
    settings = ProjectSettings(tmp_path).of("src/pick.py")
    assert (settings.robot, settings.args, settings.max_failure_probability) == (
        "ur5e",
        ("--left",),
        1e-5,
    )
    assert ProjectSettings(tmp_path).of().args == ()
