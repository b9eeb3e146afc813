"""The names that a launch file gives a controller tell of its robot too."""

import ast
from dataclasses import replace

from tracerisk.api import load_robot
from tracerisk.config import Settings
from tracerisk.pipeline.launch.launch_hints import with_parameters
from tracerisk.pipeline.launch_files.records import NOTHING_LAUNCHED, LaunchParameter
from tracerisk.pipeline.workspace.controller import load_controller, string_literals
from tracerisk.twin.robots.generic import names_asked


def test_texts_and_lists_of_texts_are_part_of_what_a_source_says(tmp_path):
    (tmp_path / "pick.py").write_bytes(b"x = 'group'  # no newline at the end")
    controller = load_controller(tmp_path / "pick.py")
    own = (
        LaunchParameter("/pick", "arm.joint_names", ["shoulder", "elbow"]),
        LaunchParameter("/**", "group", "m\u00fcll'\"\\\n"),
        LaunchParameter("/**", "speed", 0.5),
        LaunchParameter("/**", "gains", [1.0]),
    )
    spoken = with_parameters(controller, replace(NOTHING_LAUNCHED, own=own))
    ast.parse(spoken.source)
    assert string_literals(spoken) == ("group", "m\u00fcll'\"\\\n", "shoulder", "elbow")
    assert names_asked(spoken.tree).joints == ("shoulder", "elbow")


def test_without_any_it_is_the_controller_itself(tmp_path):
    (tmp_path / "pick.py").write_bytes(b"")
    controller = load_controller(tmp_path / "pick.py")
    assert with_parameters(controller, None) is controller
    assert with_parameters(controller, NOTHING_LAUNCHED) is controller


def test_a_robot_that_only_the_launch_file_names_is_taken(workspace):
    workspace.write("scripts/pick.py", "import rospy\njoints = rospy.get_param('~joints')\n")
    joints = ", ".join(f"panda_joint{i}" for i in range(1, 8))
    workspace.write(
        "launch/a.launch",
        '<launch><node pkg="arm_task" type="pick.py" name="pick">'
        f'<rosparam param="joints">[{joints}]</rosparam></node></launch>',
    )
    controller = load_controller(workspace.package / "scripts/pick.py")
    assert load_robot(controller, Settings()).name == "panda"
    assert load_robot(controller, Settings(launch=False)).name == "generic"
