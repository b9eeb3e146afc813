"""The whole errand: tubes from rack to rack, by friction alone."""

import math
from pathlib import Path

import numpy as np
import pytest

from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.recording.activity import element_activity
from tracerisk.twin.recording.exposure import ACTIVE_S, exposure
from tracerisk.twin.recording.replay import replay
from tracerisk.twin.recording.samples import POSE_EVERY
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.simulation.twin import Twin

STEP_NS = 2_000_000
GRASP_Z, TRAVEL_Z = 0.085, 0.235


def test_all_tubes_stand_in_the_target_rack(errand, tubes):
    carried = errand.offsets[:tubes]
    assert [offset.goal for offset in carried] == [
        f"target_rack_slot_{i}" for i in range(1, tubes + 1)
    ]
    for offset in carried:
        assert offset.offset_m < 0.0015, offset
        assert offset.tilt_rad < math.radians(2.0)
        assert offset.upright


def test_the_errand_takes_less_than_20_s_a_tube(errand, tubes):
    assert errand.time_ns * 1e-9 < 20.0 * tubes


def test_the_same_calls_give_the_same_bits(
    one_tube, run_errand, panda: Robot, tube_racks: Scene, tmp_path: Path
):
    again = run_errand(panda, tube_racks, tmp_path, range(1, 2))
    names = sorted(path.name for path in one_tube.directory.iterdir())
    assert names == sorted(path.name for path in tmp_path.iterdir())
    for name in names:
        assert (tmp_path / name).read_bytes() == (one_tube.directory / name).read_bytes(), name
    assert again.offsets == one_tube.offsets


def test_nothing_but_the_controls_decides_where_a_run_ends(one_tube):
    found = replay(one_tube.samples, one_tube.robot, one_tube.scene)
    assert found.same_end
    assert found.n_steps == one_tube.time_ns // STEP_NS


def test_a_changed_control_changes_the_end(one_tube):
    control = one_tube.samples.control.copy()
    control[1000:2000, 0] += 1e-3
    changed = type(one_tube.samples)(
        one_tube.samples.header,
        control,
        one_tube.samples.position,
        one_tube.samples.velocity,
        one_tube.samples.torque,
        one_tube.samples.pad_force,
        one_tube.samples.poses,
        one_tube.samples.end_pose,
    )
    assert not replay(changed, one_tube.robot, one_tube.scene).same_end


def test_poses_are_kept_for_a_later_look(errand):
    poses = errand.samples.poses
    assert len(poses) == -(-errand.samples.n_steps // POSE_EVERY)
    assert poses.shape[1] == errand.samples.header.n_pose
    # The first tube starts in the source rack (y = 0.2) and ends in the target rack.
    tube_y = poses[:, 1]
    assert (tube_y[0], tube_y[-1]) == pytest.approx((0.2, -0.2), abs=0.002)


@pytest.fixture(scope="module")
def activity(errand):
    return element_activity(errand.samples, errand.robot)


def visit_mask(errand, name: str, nth: int) -> np.ndarray:
    spans = [(begin, end) for label, begin, end in errand.spans if label == name]
    begin, end = spans[nth]
    mask = np.zeros(errand.samples.n_steps, dtype=bool)
    mask[begin // STEP_NS : end // STEP_NS] = True
    return mask


@pytest.mark.parametrize("nth", [0, 1, -1])
def test_only_the_gripper_moves_when_it_places(errand, activity, nth: int):
    mask = visit_mask(errand, "place", nth)
    moved = {
        name
        for name, found in activity.items()
        if exposure(found, mask, errand.samples.step_s).longest_moving_s >= ACTIVE_S
    }
    assert moved == {"panda_hand"}


@pytest.mark.parametrize("nth", [0, 1, -1])
@pytest.mark.parametrize("name", ["pick_position", "place_position"])
def test_the_gripper_does_not_move_while_only_the_arm_does(errand, activity, name: str, nth: int):
    mask = visit_mask(errand, name, nth)
    step_s = errand.samples.step_s
    hand = exposure(activity["panda_hand"], mask, step_s)
    assert hand.longest_moving_s < ACTIVE_S
    assert exposure(activity["panda_joint2"], mask, step_s).longest_moving_s > 0.5
    carries = name == "place_position"
    assert (hand.grasping_s > 0.0) == carries


@pytest.mark.parametrize("name", ["pick"])
def test_gripper_and_arm_move_where_both_should(errand, activity, name: str):
    mask = visit_mask(errand, name, 0)
    for element in ("panda_hand", "panda_joint4"):
        found = exposure(activity[element], mask, errand.samples.step_s)
        assert found.longest_moving_s >= ACTIVE_S, element


def test_each_tube_is_one_grasp(errand, activity, tubes):
    everything = np.ones(errand.samples.n_steps, dtype=bool)
    assert exposure(activity["panda_hand"], everything, errand.samples.step_s).grasps == tubes


def test_visits_share_out_all_activity(one_tube):
    activity = element_activity(one_tube.samples, one_tube.robot)
    n, step_s = one_tube.samples.n_steps, one_tube.samples.step_s
    owner = np.zeros(n, dtype=np.int64)
    for index, (_, begin, _) in enumerate(one_tube.spans):
        owner[begin // STEP_NS :] = index
    for found in activity.values():
        whole = exposure(found, np.ones(n, dtype=bool), step_s)
        parts = [exposure(found, owner == i, step_s) for i in range(len(one_tube.spans))]
        for field in ("moving_s", "holding_s", "grasping_s", "active_s", "starts", "grasps"):
            total = sum(getattr(part, field) for part in parts)
            assert total == pytest.approx(getattr(whole, field), abs=1e-9), field


def test_a_grasp_lifts_the_tube_and_knows_that_it_stalled(operator):
    operator.state("ready")
    operator.fingers(0.035)
    operator.fly(0.42, 0.2, TRAVEL_Z)
    operator.line(0.42, 0.2, GRASP_Z)
    grasp = operator.fingers(0.0)
    assert grasp.stalled
    assert "stalled at 0.00" in grasp.message
    operator.line(0.42, 0.2, TRAVEL_Z)
    before = operator.twin.link_pose("panda_hand_tcp").position
    assert before[2] == pytest.approx(TRAVEL_Z, abs=1e-3)
    operator.twin.advance(operator.twin.time_ns + 2_000_000_000)
    tube = operator.twin.object_pose("tube_4")
    # Lifted by the 150 mm that the hand rose, and still between the fingers' middle.
    assert tube.position[2] == pytest.approx(0.055 + 0.15, abs=0.002)
    assert tube.position[:2] == pytest.approx((0.42, 0.2), abs=0.002)


def test_a_closed_hand_without_a_tube_has_not_stalled(operator):
    operator.fingers(0.035)
    assert not operator.fingers(0.0).stalled


def test_a_weak_grasp_presses_no_harder_than_asked(operator):
    operator.state("ready")
    operator.fingers(0.035)
    operator.fly(0.42, 0.2, TRAVEL_Z)
    operator.line(0.42, 0.2, GRASP_Z)
    twin: Twin = operator.twin
    motion = operator.wait(twin.move_gripper("panda_hand", 0.0, max_effort=1.5))
    assert motion.stalled
    twin.advance(twin.time_ns + 500_000_000)
    efforts = [abs(effort) for effort in twin.joint_state().effort[-2:]]
    assert max(efforts) == pytest.approx(1.5, abs=0.05)
