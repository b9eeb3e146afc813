"""The functions of the verbs give what the commands print."""

import pytest

import tracerisk
from tracerisk.errors import ControllerFailedError, InputError
from tracerisk.prm.formats.assessment_json import assessment_to_json
from tracerisk.trace import RunFailedError


def test_an_assessment_is_that_of_the_command_and_writes_nothing(example, quick):
    path = example.write("quick.py", quick())
    before = example.files()
    done = tracerisk.assess(path)
    assert example.files() == before
    reported = example.run("run", "quick.py", "--check", "--json").json
    assert reported["assessment"] == assessment_to_json(done.assessment)
    assert [each.name for each in done.annotated.computed.blocks] == [
        state["name"] for state in reported["model"]["states"]
    ]


def test_blocks_are_written_when_that_is_said(example, quick, monkeypatch):
    path = example.write("quick.py", quick())
    done = tracerisk.write_blocks(tracerisk.assess(path))
    assert example.read("quick.py") == done.annotated.source
    assert b"RiskAnnotation" in example.read("quick.py")
    monkeypatch.chdir(example.folder)
    (controller,), (checked,) = tracerisk.check()
    assert controller.name == "quick.py"
    assert checked.findings == ()
    assert tracerisk.refresh(path).how == "fresh"
    assert list(tracerisk.overrides()) == []


def test_settings_go_before_those_of_the_project(example, quick):
    path = example.write("quick.py", quick())
    example.write("pyproject.toml", "[tool.tracerisk]\nmission_cycles = 3\n")
    assert tracerisk.assess(path).settings.mission_cycles == 3
    assert tracerisk.assess(path, {"mission_cycles": 4}).settings.mission_cycles == 4


def test_a_run_that_ends_badly_is_an_error_with_its_trace(example, quick):
    path = example.write("quick.py", "import pymycobot\n" + quick())
    with pytest.raises(RunFailedError, match="pymycobot") as caught:
        tracerisk.assess(path)
    assert caught.value.trace.end.cause == "not_importable"
    assert caught.value.trace.verdict.kind == "stuck"


def test_a_run_without_a_command_is_an_error(example):
    path = example.write("idle.py", "import rospy\nrospy.init_node('idle')\n")
    with pytest.raises(ControllerFailedError, match="it commanded no hardware"):
        tracerisk.assess(path)


def test_a_folder_without_a_lock_knows_no_controller(example, monkeypatch):
    monkeypatch.chdir(example.folder)
    for function in (tracerisk.check, tracerisk.overrides):
        with pytest.raises(InputError, match=r"no tracerisk\.lock in or below"):
            function()
