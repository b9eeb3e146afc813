import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import pytest

from tests.ran import Ran
from tests.traced_run import run_traced
from tracerisk.config import RosDistro
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.time.scheduler import RunOver

SECOND = 1_000_000_000
PREAMBLE = """\
import copy, time
import numpy as np
from geometry_msgs.msg import Pose, PoseStamped
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, Constraints
from shape_msgs.msg import SolidPrimitive
from moveit.core.robot_state import RobotState
from moveit.planning import MoveItPy, MultiPipelinePlanRequestParameters, PlanRequestParameters
READY = [0.0, -0.7853981633974483, 0.0, -2.356194490192345, 0.0, 1.5707963267948966, 0.7853981633974483]
panda = MoveItPy()
arm = panda.get_planning_component("panda_arm")
monitor = panda.get_planning_scene_monitor()
def go(name):
    arm.set_start_state_to_current_state()
    arm.set_goal_state(configuration_name=name)
    return panda.execute(arm.plan().trajectory, controllers=[])
def box(name, position, size, frame="panda_link0"):
    made = CollisionObject(id=name, operation=CollisionObject.ADD)
    made.header.frame_id = frame
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = position
    made.primitives.append(SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(size)))
    made.primitive_poses.append(pose)
    return made
"""


@dataclass
class RanAndOver(Ran):
    """How it ended, too."""

    over: RunOver | None


@pytest.fixture
def run(tmp_path: Path) -> Callable[..., RanAndOver]:
    """Run a program of MoveItPy on the Panda, traced and in virtual time, as the command does."""

    def run_program(
        program: str,
        packages: Mapping[str, Path] = MappingProxyType({}),
        distro: RosDistro | None = None,
    ) -> RanAndOver:
        script = tmp_path / "program.py"
        script.write_text(PREAMBLE + textwrap.dedent(program))
        ran, over = run_traced(
            script,
            Interfaces2(),
            duration_s=100.0,
            packages=packages,
            has_topics=False,
            distro=distro,
        )
        return RanAndOver(**vars(ran), over=over)

    return run_program
