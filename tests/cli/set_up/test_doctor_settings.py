"""`tracerisk doctor FILE` says what each setting is and where it comes from."""

import dataclasses

from tracerisk.config import Settings

TABLES = """\
[tool.tracerisk]
seed = 3
max_failure_probability = 1e-6
helpers = ["go", "grip"]

[tool.tracerisk.controllers."src/left.py"]
seed = 5
robot = "panda"

[tool.tracerisk.controllers."src/right.py"]
duration_s = 7
"""


def settings_of(example, file: str, *more: str) -> dict[str, dict[str, object]]:
    outcome = example.run("doctor", file, "--json", *more)
    assert outcome.code == 0, outcome.err
    return outcome.json["settings"]


def test_each_setting_is_reported_with_its_value_and_its_place(example, quick):
    example.write("pyproject.toml", TABLES)
    for name in ("left", "right"):
        example.write(f"src/{name}.py", quick("go()", "grip()"))
    left = settings_of(example, "src/left.py")
    assert set(left) == {field.name for field in dataclasses.fields(Settings)}
    place = {"file": "pyproject.toml"}
    assert left["seed"] == {"value": 5, "from": "controller", "line": 7, **place}
    assert left["robot"] == {"value": "panda", "from": "controller", "line": 8, **place}
    assert left["helpers"] == {"value": ["go", "grip"], "from": "all", "line": 4, **place}
    default = {"from": "default", "file": None, "line": None}
    assert left["duration_s"] == {"value": None, **default}
    right = settings_of(example, "src/right.py", "--robot", "ur5e")
    assert right["seed"] == {"value": 3, "from": "all", "line": 2, **place}
    assert right["duration_s"]["value"] == 7.0
    reported = {"value": "ur5e", "from": "command line", "file": None, "line": None}
    assert right["robot"] == reported


def test_the_settings_stand_one_a_line(example, quick):
    example.write("pyproject.toml", TABLES)
    for name in ("left", "right"):
        example.write(f"src/{name}.py", quick())
    lines = example.run("doctor", "src/left.py").out.splitlines()
    start = lines.index("settings:")
    shown = lines[start + 1 : start + 1 + len(dataclasses.fields(Settings))]
    assert all(line.startswith("  ") for line in shown)
    assert "  seed = 5  (pyproject.toml:7, the controller's own table)" in shown
    assert "  max_failure_probability = 1e-06  (pyproject.toml:3, all controllers)" in shown
    assert "  helpers = go, grip  (pyproject.toml:4, all controllers)" in shown
    assert "  launch = true  (default)" in shown
    assert "  scenario = none  (default)" in shown
