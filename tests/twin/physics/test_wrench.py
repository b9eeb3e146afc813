"""Forces in the wrist, against weights and levers worked out from the robot's file."""

import numpy as np
import pytest

from tracerisk.common.geometry.frames import matrix_of
from tracerisk.twin.physics.motion import Pose

G = 9.81
HAND = ("panda_hand", "panda_leftfinger", "panda_rightfinger")


def axes_of(pose: Pose) -> np.ndarray:
    x, y, z, w = pose.orientation
    return np.array(matrix_of((w, x, y, z)))


def weight_at(twin, links: tuple[str, ...], at: str) -> tuple[np.ndarray, np.ndarray]:
    """The weight of some links, and its torque about the frame `at`, in the axes of that frame."""
    poses = twin.link_poses()
    origin = np.array(poses[at].position)
    force, torque = np.zeros(3), np.zeros(3)
    for link in twin.robot.links:
        if link.name in links:
            pose = poses[link.name]
            centre = np.array(pose.position) + axes_of(pose) @ np.array(link.centre_of_mass)
            weight = np.array([0.0, 0.0, -G * link.mass])
            force += weight
            torque += np.cross(centre - origin, weight)
    turn = axes_of(poses[at]).T
    return turn @ force, turn @ torque


@pytest.mark.parametrize("state", ["ready", "extended"])
def test_a_wrist_at_rest_bears_the_weight_of_the_hand(operator, state):
    operator.state(state)
    twin = operator.twin
    twin.advance(twin.time_ns + 500_000_000)
    found = twin.load_on("panda_hand")
    force, torque = weight_at(twin, HAND, "panda_hand")
    assert np.linalg.norm(force) == pytest.approx(G * 0.7126, rel=1e-12)
    # The servos still creep by some micrometres a second.
    assert found.force == pytest.approx(tuple(force), abs=2e-3)
    assert found.torque == pytest.approx(tuple(torque), abs=2e-4)


def test_without_a_touch_the_world_exerts_nothing(operator):
    operator.state("ready")
    found = operator.twin.touch_on("panda_hand_tcp")
    assert found.force == (0.0, 0.0, 0.0)
    assert found.torque == (0.0, 0.0, 0.0)


def test_a_held_tube_is_felt_with_its_weight(operator):
    twin = operator.twin
    operator.state("ready")
    operator.fingers(0.035)
    operator.fly(0.30, 0.2, 0.235)
    operator.line(0.30, 0.2, 0.085)
    operator.fingers(0.0)
    operator.line(0.30, 0.2, 0.235)
    twin.advance(twin.time_ns + 500_000_000)
    (tube,) = [
        thing for thing in twin.scene.objects if twin.object_pose(thing.name).position[2] > 0.12
    ]
    weight = G * tube.mass
    found = twin.touch_on("panda_hand_tcp")
    in_base = axes_of(twin.link_pose("panda_hand_tcp")) @ np.array(found.force)
    assert in_base == pytest.approx([0.0, 0.0, -weight], abs=0.02 * weight)
    whole, _ = weight_at(twin, HAND, "panda_hand")
    borne = np.array(twin.load_on("panda_hand").force) - whole
    assert np.linalg.norm(borne) == pytest.approx(weight, rel=0.05)
