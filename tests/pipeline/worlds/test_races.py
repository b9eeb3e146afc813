"""Programs that a race or a lucky start decides are named by a world, sound ones by none."""

from pathlib import Path

import pytest

from tests.conftest import quick_controller
from tests.slow import slow_but
from tracerisk.common.worlds.world import WORLDS, world_named
from tracerisk.pipeline.evidence.cell_runs import nominal_of
from tracerisk.pipeline.worlds.world_runs import in_world, may_differ

ROOT = Path(__file__).parents[3]
RACES = ROOT / "benchmarks" / "races"
NAMED = [
    ("publish_at_once", "discovery", 18),
    ("joint_index", "joints-alphabetical", 16),
    ("sleep_for_motion", "planning", 16),
    ("callback_order", "order", None),
    ("gripper_assumed", "gripper-closed", 26),
    ("frame_at_once", "discovery", 22),
    ("goal_at_once", "discovery", 28),
    ("late_subscriber", "discovery", None),
    ("scene_not_there", "discovery", 26),
    ("service_not_there", "discovery", 23),
    ("state_not_there", "discovery", None),
    ("timeout_for_plan", "planning", None),
]


def nominal(path: Path):
    scenario = path.with_suffix(".scenario.yaml")
    return nominal_of(str(path), (("scenario", str(scenario)),) if scenario.exists() else ())


def test_every_program_is_tried():
    assert sorted(name for name, *_ in NAMED) == sorted(path.stem for path in RACES.glob("*.py"))


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(("program", "world", "line"), slow_but(NAMED[:2], NAMED))
def test_a_world_names_a_race(program, world, line):
    of_program = nominal(RACES / f"{program}.py")
    assert of_program.trace.verdict.kind in ("complete", "partial")
    run = in_world(of_program, world_named(world))
    assert run.depends
    if line is not None:
        assert (run.location.file, run.location.line) == (f"{program}.py", line)


def test_what_was_lost_is_said():
    run = in_world(nominal(RACES / "publish_at_once.py"), world_named("discovery"))
    assert run.cause == "a message on /position_joint_trajectory_controller/command is lost"


def test_nothing_of_a_sound_program_depends_on_a_world(tmp_path):
    path = tmp_path / "sound.py"
    path.write_text(quick_controller("arm.set_named_target('ready')", "arm.go(wait=True)"))
    (tmp_path / "pyproject.toml").touch()
    of_program = nominal(path)
    runs = [in_world(of_program, world) for world in WORLDS if may_differ(world, of_program)]
    assert [run for run in runs if run.depends] == []
    assert len(runs) == len(WORLDS)


@pytest.mark.slow
@pytest.mark.parametrize("sample", sorted((ROOT / "sample_controllers").glob("*.py")))
def test_nothing_of_a_sample_depends_on_a_world(sample):
    of_sample = nominal(sample)
    runs = [in_world(of_sample, world) for world in WORLDS if may_differ(world, of_sample)]
    assert [run for run in runs if run.depends] == []
