"""A controller that loses its way: it finds no frame, logs an error and goes home.

Its run is shorter and moves less than the mission, so every gate must stop it.
"""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from tracerisk.adder.lock.lock import data_digest
from tracerisk.api import load_controller
from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import choose_launch
from tracerisk.pipeline.robot.choice import choose_launched_robot
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.urdf.urdf import read_urdf

PACKAGES = Path(__file__).parent / "press_feeder"
CONTROLLER = "press_cell/press_cell/press_feeder.py"
WORLD = ("--scenario", "press_cell/cell_world.yaml")


@pytest.fixture(scope="session")
def ran(tmp_path_factory, example_in):
    """The cell, run with the frame and committed, then run without it."""
    folder = tmp_path_factory.mktemp("feeder")
    shutil.copytree(PACKAGES, folder, dirs_exist_ok=True)
    cell = example_in(folder)
    outcomes = {"good": cell.run("run", CONTROLLER, *WORLD)}
    outcomes["good check"] = cell.run("check", CONTROLLER)
    outcomes["good solve"] = cell.run("solve", CONTROLLER)
    good = cell.files()
    outcomes["bad"] = cell.run("run", CONTROLLER)
    outcomes["bad check"] = cell.run("check", CONTROLLER)
    outcomes["bad solve"] = cell.run("solve", CONTROLLER)
    return outcomes, good, cell.files()


MACROS = """\
<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="seven_joint_arm">
  <xacro:arg name="prefix" default="left_"/>
  <xacro:property name="prefix" value="$(arg prefix)"/>
  <xacro:include filename="$(find seven_joint_arm)/urdf/parts.xacro"/>
</robot>
"""
BRINGUP = """\
<launch>
  <arg name="arm" default="openarm"/>
  <node pkg="robot_state_publisher" exec="robot_state_publisher">
    <param name="robot_description" value="$(command 'xacro
      $(find-pkg-share seven_joint_arm)/urdf/seven_joint_arm.urdf.xacro prefix:=$(var arm)_')"/>
  </node>
</launch>
"""


@pytest.mark.slow
def test_an_arm_by_prefix_made_names_gives_the_same_run_to_the_last_byte(ran, tmp_path, example_in):
    shutil.copytree(PACKAGES, tmp_path, dirs_exist_ok=True)
    urdf = tmp_path / "seven_joint_arm" / "urdf" / "seven_joint_arm.urdf"
    plain = urdf.read_text()
    urdf.unlink()
    parts = plain.replace("openarm_", "${prefix}")
    assert "openarm" not in parts
    (urdf.parent / "parts.xacro").write_text(parts)
    (urdf.parent / "seven_joint_arm.urdf.xacro").write_text(MACROS)
    launch = tmp_path / "seven_joint_arm" / "launch"
    launch.mkdir()
    (launch / "arm.launch.xml").write_text(BRINGUP)
    controller = load_controller(tmp_path / CONTROLLER)
    robot = choose_launched_robot(
        controller, Settings(), choose_launch(controller, Settings())
    ).robot
    wanted = Kinematics(read_urdf(plain, "plain.urdf"))
    names = [joint.name for joint in robot.arm_joints]
    assert names == [f"openarm_joint{number}" for number in range(1, 8)]
    for angles in np.random.default_rng(3).uniform(-1.5, 1.5, (50, 7)):
        state = dict(zip(names, angles, strict=True))
        at, to = (
            kinematics.forward(state, "openarm_left_finger").position
            for kinematics in (Kinematics(robot), wanted)
        )
        assert np.linalg.norm(np.subtract(at, to)) < 1e-4  # [m]
    outcome = example_in(tmp_path).run("run", CONTROLLER, *WORLD)
    assert outcome.code == 0, outcome.err
    assert (tmp_path / CONTROLLER).read_bytes() == ran[1][CONTROLLER]


def in_git(repository, before, after):
    for name, data in before.items():
        repository.write(name, data)
    repository.commit()
    for name, data in after.items():
        repository.write(name, data)
    return repository


def test_with_its_frame_the_run_is_partial_by_the_handler_that_never_ran(ran):
    outcome = ran[0]["good"]
    assert outcome.code == 0, outcome.err
    lines = outcome.out.splitlines()
    assert lines[0] == "partial, 8 of 9 functions with commands ran"
    assert "PressFeeder.fault can command hardware and never ran" in lines[1]
    assert not lines[2].startswith(" ")


def test_with_its_frame_the_check_passes(ran):
    outcome = ran[0]["good check"]
    assert outcome.code == 0
    assert outcome.out == f"{CONTROLLER}: partial, 8 of 9 functions with commands ran\n"


def test_without_its_frame_the_run_is_faulted_and_names_the_frame(ran):
    outcome = ran[0]["bad"]
    assert outcome.code == 1
    first = outcome.out.splitlines()[0]
    assert first.startswith("faulted: tf look-up of frame 'part' failed (press_cell/")
    assert "in PressFeeder.locate, at 2." in first
    assert first.endswith("5 of 9 functions with commands ran")


def test_without_its_frame_the_blocks_are_written_with_the_verdict_in_the_lock(ran):
    _, good, bad = ran
    (lock,) = (name for name in bad if name.endswith("tracerisk.lock"))
    assert bad[CONTROLLER] != good[CONTROLLER]
    assert b'"kind": "faulted"' in bad[lock]
    assert b'"kind": "partial"' in good[lock]


def test_without_its_frame_the_check_fails_on_each_reason(ran):
    outcome = ran[0]["bad check"]
    assert outcome.code == 1
    assert "faulted: tf look-up of frame 'part' failed" in outcome.out
    assert "it logged ERROR: fault: going home" in outcome.out


@pytest.mark.parametrize(("run", "word"), [("good", "partial"), ("bad", "faulted: tf look-up")])
def test_solve_says_the_verdict_of_the_lock_first(ran, run, word):
    assert ran[0][f"{run} solve"].out.startswith(word)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("form", ["text", "markdown", "json"])
def test_a_change_that_breaks_the_run_says_what_broke_and_never_that_risk_falls(
    ran, repository, form
):
    _, good, bad = ran
    outcome = in_git(repository, good, bad).run("diff", "--format", form, "--max-increase", "0.1")
    assert outcome.code == 1
    text = " ".join((outcome.out + outcome.err).split()).replace("\\_", "_")
    assert "tf look-up of frame 'part' failed" in text
    assert "cannot be compared" in text
    assert "falls" not in text
    assert "rises" not in text
    assert not re.search(r"(?<!\w)x0\.\d", text)
    if form == "markdown":
        assert "was partial, is faulted; the two runs cannot be compared" in text
        assert outcome.out.count("tf look-up of frame 'part' failed") == 1
        assert "What the runs behind the blocks depended on: - " in text


def test_the_first_line_of_a_diff_is_the_verdict(ran, repository):
    _, good, bad = ran
    outcome = in_git(repository, good, bad).run("diff")
    assert outcome.code == 0
    assert outcome.out.startswith("faulted: tf look-up of frame 'part' failed")
    assert "before: partial, 8 of 9" in " ".join(outcome.out.split())


def test_a_repaired_run_passes_subject_to_the_greatest_risk(ran, repository):
    _, good, bad = ran
    cell = in_git(repository, bad, good)
    outcome = cell.run("diff", "--max-increase", "0.1")
    assert outcome.code == 0, outcome.err
    assert "repaired: tf look-up of frame 'part' failed" in " ".join(outcome.out.split())
    assert cell.run("diff", "--max-failure-probability", "1e-12").code == 1


def test_a_change_that_drops_the_lock_does_not_pass(ran, repository):
    _, good, _ = ran
    cell = in_git(repository, good, {})
    cell.write(CONTROLLER, good[CONTROLLER].replace(b"Take parts", b"Take blanks"))
    (lock,) = (name for name in good if name.endswith("tracerisk.lock"))
    (cell.folder / lock).unlink()
    outcome = cell.run("diff", "--max-increase", "0.1")
    assert outcome.code == 1
    assert "verdict of its run is unknown" in outcome.err


def test_fewer_functions_than_in_the_base_fail_the_check(ran, repository):
    _, good, bad = ran
    outcome = in_git(repository, good, bad).run("check", "--base", "HEAD", CONTROLLER)
    assert outcome.code == 1
    assert "coverage: 5 of 9 functions with commands ran" in outcome.out
    assert "before the change 8 of 9 did" in outcome.out


def test_a_call_that_the_base_did_not_miss_fails_the_check(ran, repository):
    _, good, _ = ran
    (lock,) = (name for name in good if name.endswith("tracerisk.lock"))
    data = json.loads(good[lock])
    (entry,) = data["controllers"].values()
    reasons = entry["trace"]["verdict"]["reasons"]
    words = "this call of self.go led to no command; another did"
    missed = {"code": "missed-call", "verdict": "partial", "words": words, "object": "self.go"}
    reasons.append({**reasons[0], **missed})
    entry["digest"] = data_digest(entry)
    changed = {lock: json.dumps(data).encode()}
    cell = in_git(repository, good, changed)
    assert cell.run("check", CONTROLLER).code == 0
    outcome = cell.run("check", "--base", "HEAD", CONTROLLER)
    assert outcome.code == 1
    assert (
        f"coverage: {words} (in PressFeeder.fault); before the change that was not so"
        in outcome.out
    )
    kept = in_git(repository, {**good, **changed}, {})
    assert kept.run("check", "--base", "HEAD", CONTROLLER).code == 0


def test_as_many_functions_as_in_the_base_pass(ran, repository):
    _, good, _ = ran
    assert in_git(repository, good, {}).run("check", "--base", "HEAD", CONTROLLER).code == 0


@pytest.mark.parametrize(("least", "code"), [("0.8", 0), ("0.9", 1)])
def test_the_least_coverage_is_a_limit_of_check(ran, repository, least, code):
    _, good, _ = ran
    cell = in_git(repository, good, {})
    outcome = cell.run("check", CONTROLLER, "--min-coverage", least)
    assert outcome.code == code
    assert ("the min_coverage is 0.9" in outcome.out) == (code == 1)
