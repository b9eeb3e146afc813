"""The planning scene, and pick and place in it."""

import struct
from pathlib import Path

import pytest

SCENE = """
scene = moveit_commander.PlanningSceneInterface()
place = geometry_msgs.msg.PoseStamped()
place.header.frame_id = "panda_link0"
place.pose.position.x, place.pose.position.z = 0.4, 0.2
place.pose.orientation.w = 1.0
arm = MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)
arm.set_max_acceleration_scaling_factor(1.0)
"""


def test_objects_are_added_and_removed(run):
    ran = run(
        SCENE
        + """
scene.add_box("box", place, size=(0.1, 0.2, 0.3))
scene.add_sphere("ball", place, radius=0.05)
scene.add_cylinder("tube", place, 0.1, 0.01)
scene.add_plane("floor", place)
names = scene.get_known_object_names()
box = scene.get_objects(["box"])["box"]
near = scene.get_known_object_names_in_roi(0, -1, 0, 1, 1, 1)
scene.remove_world_object("ball")
after = scene.get_known_object_names()
scene.remove_world_object()
empty = scene.get_known_object_names()
"""
    )
    assert ran["names"] == ["ball", "box", "floor", "tube"]
    assert ran["box"].primitives[0].type == ran["box"].primitives[0].BOX
    assert ran["box"].primitives[0].dimensions == [0.1, 0.2, 0.3]
    assert {"ball", "box", "tube"} <= set(ran["near"])
    assert ran["after"] == ["box", "floor", "tube"]
    assert ran["empty"] == []


def test_what_is_given_in_an_unknown_frame_is_left_out_and_told(run):
    """As by move_group, which logs it: the program goes on."""
    ran = run(
        SCENE
        + """
place.header.frame_id = "table"
scene.add_box("box", place)
names = scene.get_known_object_names()
"""
    )
    assert ran["names"] == []
    assert "'box' is given in the unknown frame 'table'; allowed: panda_hand" in ran.findings[0]


def test_every_client_sees_the_same_scene(run):
    ran = run(
        SCENE
        + """
scene.add_box("box", place)
names = moveit_commander.PlanningSceneInterface().get_known_object_names()
"""
    )
    assert ran["names"] == ["box"]


def test_an_attached_object_moves_with_its_link_and_stays_where_it_is_left(run):
    ran = run(
        SCENE
        + """
arm.set_named_target("ready"); arm.go()
scene.add_box("box", arm.get_current_pose(), size=(0.02, 0.02, 0.1))
arm.attach_object("box", "panda_hand", ["panda_leftfinger", "panda_rightfinger"])
rospy.sleep(0.1)
world, attached = scene.get_known_object_names(), scene.get_attached_objects()
arm.shift_pose_target(2, -0.1); arm.go()
hand = arm.get_current_pose().pose
arm.detach_object("box")
rospy.sleep(0.1)
pose = scene.get_object_poses(["box"])["box"]
"""
    )
    assert ran["world"] == []
    assert ran["attached"]["box"].link_name == "panda_hand"
    assert ran["attached"]["box"].touch_links == ["panda_leftfinger", "panda_rightfinger"]
    (shape,) = ran["attached"]["box"].object.primitive_poses
    assert (shape.position.x, shape.orientation.w) == (0.0, 1.0)
    assert ran["pose"].position.z == pytest.approx(ran["hand"].position.z, abs=2e-4)


def test_removing_an_attached_object_leaves_it_in_the_world(run):
    ran = run(
        SCENE
        + """
scene.add_box("box", place)
scene.attach_box("panda_hand", "box")
scene.attach_sphere("panda_hand", "ball", place, 0.01)
held = sorted(scene.get_attached_objects())
scene.remove_attached_object("panda_hand", name="box")
one = scene.get_known_object_names()
scene.remove_attached_object("panda_hand")
both = scene.get_known_object_names()
"""
    )
    assert ran["held"] == ["ball", "box"]
    assert (ran["one"], ran["both"]) == (["box"], ["ball", "box"])


def test_an_object_that_is_not_there_is_a_finding(run):
    ran = run(SCENE + "done = arm.attach_object('cup')\nscene.remove_world_object('cup')\n")
    assert ran["done"] is True
    # To remove what is not there is ordinary clean-up.
    assert [finding.kind for finding in ran.recording.findings] == ["attach_failure"]
    assert "object 'cup' cannot be attached" in ran.findings[0]


@pytest.mark.parametrize(
    ("statements", "refused"),
    [
        ("scene.attach_box('panda_hand', 'cup')", ["cup"]),
        ("scene.attach_object('cup', 'panda_hand')", ["cup"]),
        ("arm.attach_object('cup')\nscene.add_box('cup', place)\narm.attach_object('cup')", []),
        ("scene.remove_attached_object('panda_hand', 'cup')", []),
    ],
)
def test_what_could_not_be_attached_is_a_failure_until_a_retry_succeeds(run, statements, refused):
    ran = run(SCENE + statements + "\n")
    failed = [each for each in ran.recording.findings if each.kind == "attach_failure"]
    assert [each.object for each in failed if each.recovered_s is None] == refused


def test_an_object_is_a_frame(run):
    ran = run(
        SCENE
        + """
scene.add_box("box", place)
arm.set_pose_reference_frame("box")
arm.set_pose_target([0.0, 0.0, 0.2, math.pi, 0.0, 0.0])
request = arm.construct_motion_plan_request()
"""
    )
    region = ran["request"].goal_constraints[0].position_constraints[0].constraint_region
    position = region.primitive_poses[0].position
    assert (position.x, position.y, position.z) == pytest.approx((0.4, 0.0, 0.4))


def test_a_scene_message_is_applied_and_asked_back(run):
    ran = run(
        SCENE
        + """
message = moveit_msgs.msg.PlanningScene(is_diff=True)
message.world.collision_objects = [scene.make_box("box", place, (1, 1, 1))]
message.object_colors = [moveit_msgs.msg.ObjectColor(id="box")]
done = scene.apply_planning_scene(message)
parts = moveit_msgs.msg.PlanningSceneComponents
back = scene.get_planning_scene(
    parts.WORLD_OBJECT_NAMES | parts.ROBOT_STATE | parts.OBJECT_COLORS)
"""
    )
    assert ran["done"] is True
    assert [item.id for item in ran["back"].world.collision_objects] == ["box"]
    assert [color.id for color in ran["back"].object_colors] == ["box"]
    assert len(ran["back"].robot_state.joint_state.name) == 9


def test_a_mesh_is_read_from_a_file(run, tmp_path: Path):
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    faces = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]
    stl = tmp_path / "four.stl"
    facets = [
        struct.pack("<12f2x", 0, 0, 0, *(value for corner in face for value in corners[corner]))
        for face in faces
    ]
    stl.write_bytes(b"\0" * 80 + struct.pack("<I", len(facets)) + b"".join(facets))
    obj = tmp_path / "four.obj"
    obj.write_text(
        "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
        + "".join(f"f {a + 1}/1 {b + 1}/1 {c + 1}/1\n" for a, b, c in faces)
    )
    ran = run(
        SCENE
        + f"""
scene.add_mesh("stl", place, {str(stl)!r}, size=(2, 2, 2))
scene.add_mesh("obj", place, {str(obj)!r})
stl, obj = (scene.get_objects()[name].meshes[0] for name in ("stl", "obj"))
text = ""
try:
    scene.add_mesh("dae", place, "cup.dae")
except MoveItCommanderException as error:
    text = str(error)
"""
    )
    assert (len(ran["stl"].vertices), len(ran["stl"].triangles)) == (4, 4)
    assert (len(ran["obj"].vertices), len(ran["obj"].triangles)) == (4, 4)
    assert max(vertex.x for vertex in ran["stl"].vertices) == 2.0
    assert "There are no meshes in the file" in ran["text"]


def test_allowed_collisions_can_be_set(run):
    ran = run(
        """
matrix = moveit_msgs.msg.AllowedCollisionMatrix()
matrix.set_allowed("floor")
matrix.entry_names = ["a"]
matrix.entry_values = [moveit_msgs.msg.AllowedCollisionEntry(enabled=[False])]
matrix.set_allowed("b", "a")
"""
    )
    matrix = ran["matrix"]
    assert (matrix.default_entry_names, matrix.default_entry_values) == (["floor"], [True])
    assert matrix.entry_names == ["a", "b"]
    assert [entry.enabled for entry in matrix.entry_values] == [[False, True], [True, False]]


PICK = """
arm.set_named_target("ready"); arm.go()
top = arm.get_current_pose()
top.pose.position.z -= 0.15
cup = copy.deepcopy(top)
cup.pose.position.z -= 0.105  # between the pads when the flange is at `top`
scene.add_box("cup", cup, size=(0.02, 0.02, 0.06))
def posture(opening):
    message = moveit_msgs.msg.Grasp().grasp_posture
    message.joint_names = ["panda_finger_joint1", "panda_finger_joint2"]
    message.points = [type(arm.plan()[1].joint_trajectory.points[0])(
        positions=[opening, opening])]
    return message
def along(z, distance):
    message = moveit_msgs.msg.GripperTranslation(desired_distance=distance, min_distance=0.05)
    message.direction.header.frame_id = "panda_link0"
    message.direction.vector.z = z
    return message
"""


def test_pick_and_place_go_through_their_steps(run):
    ran = run(
        SCENE
        + PICK
        + """
grasp = moveit_msgs.msg.Grasp(
    grasp_pose=top, pre_grasp_posture=posture(0.03), grasp_posture=posture(0.01),
    pre_grasp_approach=along(-1.0, 0.1), post_grasp_retreat=along(1.0, 0.1))
picked = arm.pick("cup", grasp)
held = list(scene.get_attached_objects())
goal = copy.deepcopy(cup)
goal.pose.position.y += 0.1
location = moveit_msgs.msg.PlaceLocation(
    place_pose=goal, pre_place_approach=along(-1.0, 0.1), post_place_retreat=along(1.0, 0.1))
placed = arm.place("cup", location)
pose = scene.get_object_poses(["cup"])["cup"]
fingers = MoveGroupCommander("hand").get_current_joint_values()
"""
    )
    assert ran.findings == []
    assert (ran["picked"], ran["placed"]) == (1, True)
    assert ran["held"] == ["cup"]
    goal = ran["goal"].pose.position
    assert (ran["pose"].position.x, ran["pose"].position.y) == pytest.approx(
        (goal.x, goal.y), abs=0.004
    )
    # After placing the hand opens as far as it did before the grasp.
    assert ran["fingers"] == pytest.approx([0.03, 0.03], abs=0.001)
    steps = ["panda_hand" in command.elements for command in ran.recording.commands[1:]]
    assert steps == [True, False, False, True, False, False, False, True, False]


@pytest.mark.parametrize(
    ("call", "code", "text"),
    [
        ("arm.pick('mug')", -19, "the planning scene has no such object; did you mean 'cup'"),
        (
            "arm.pick('cup', moveit_msgs.msg.Grasp(grasp_pose=top, "
            "post_grasp_retreat=moveit_msgs.msg.GripperTranslation(desired_distance=3.0, "
            "min_distance=2.0, direction=along(1.0, 1.0).direction)))",
            -1,
            "of the straight way from the pose can be followed, and 2 m are the least",
        ),
    ],
)
def test_a_pick_that_cannot_be_done_returns_its_code(run, call, code, text):
    text = text.replace("did you mean 'cup'", "allowed: cup")
    ran = run(SCENE + PICK + f"code = {call}\n")
    assert ran["code"] == code
    assert text in ran.findings[0]


def test_placing_what_is_not_held_fails(run):
    ran = run(SCENE + PICK + "done = arm.place('cup', top)\n")
    assert ran["done"] is False
    assert "no such object is attached" in ran.findings[0]


def test_a_grasp_out_of_reach_gives_way_to_the_next(run):
    ran = run(
        SCENE
        + PICK
        + """
far = moveit_msgs.msg.Grasp(grasp_pose=copy.deepcopy(top))
far.grasp_pose.pose.position.x = 4.0
near = moveit_msgs.msg.Grasp(grasp_pose=top, pre_grasp_posture=posture(0.03))
code = arm.pick("cup", [far, near])
"""
    )
    assert ran["code"] == 1
    assert "picking 'cup' failed" in ran.findings[0]


@pytest.mark.slow
def test_a_way_to_a_grasp_may_be_shorter_than_desired(run):
    """As there: an approach of 2 m that is followed for its least 5 cm or more is one."""
    ran = run(
        SCENE
        + PICK
        + """
grasp = moveit_msgs.msg.Grasp(
    grasp_pose=top, pre_grasp_posture=posture(0.03), grasp_posture=posture(0.01),
    pre_grasp_approach=along(-1.0, 2.0), post_grasp_retreat=along(1.0, 2.0))
code = arm.pick("cup", grasp)
held = list(scene.get_attached_objects())
"""
    )
    assert (ran["code"], ran["held"]) == (1, ["cup"])
    assert ran.findings == []


def test_a_grasp_whose_way_is_too_short_gives_way_to_the_next(run):
    ran = run(
        SCENE
        + PICK
        + """
low = moveit_msgs.msg.Grasp(
    grasp_quality=1.0, grasp_pose=top, pre_grasp_approach=along(1.0, 0.5))
low.pre_grasp_approach.min_distance = 0.5
near = moveit_msgs.msg.Grasp(
    grasp_pose=top, pre_grasp_posture=posture(0.03), pre_grasp_approach=along(-1.0, 0.1))
code = arm.pick("cup", [near, low])
"""
    )
    assert ran["code"] == 1
    assert "0.5 m are the least" in ran.findings[0]


@pytest.mark.slow
def test_without_grasps_one_from_behind_is_tried(run):
    """move_group's own: 0.2 m behind the object along x, and on from there."""
    ran = run(
        SCENE
        + PICK
        + """
ball = copy.deepcopy(top)
ball.pose.orientation = type(ball.pose.orientation)(w=1.0)
ball.pose.position.x, ball.pose.position.z = 0.6, 0.6
scene.add_box("ball", ball, size=(0.04, 0.04, 0.04))
code = arm.pick("ball")
held = list(scene.get_attached_objects())
place = arm.get_current_pose().pose.position
"""
    )
    assert (ran["code"], ran["held"]) == (1, ["ball"])
    # From 0.4 m on to where the hand, 0.05 m wide, would touch it, and up by at least 0.1 m.
    assert 0.45 < ran["place"].x < 0.58
    assert 0.69 < ran["place"].z < 0.81


WALL = """
wall = copy.deepcopy(place)
wall.pose.position.x, wall.pose.position.y, wall.pose.position.z = 0.32, 0.0, 0.4
"""


def test_a_plan_leads_around_what_is_declared_and_a_goal_inside_it_fails(run):
    """Goal in collision: -12 (moveit_msgs/MoveItErrorCodes)."""
    ran = run(
        SCENE
        + WALL
        + """
aside = [-1.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
across = [1.0] + aside[1:]
arm.go(aside)
straight = arm.plan(across)[1].joint_trajectory.points
scene.add_box("wall", wall, size=(0.1, 0.1, 0.8))
around = arm.plan(across)[1].joint_trajectory.points
inside = arm.plan([0.0] + aside[1:])
done = arm.go(across)
"""
    )
    assert all(point.positions[1] == pytest.approx(-0.785) for point in ran["straight"])
    assert max(abs(point.positions[1] + 0.785) for point in ran["around"]) > 0.05
    assert ran["inside"][0] is False
    assert ran["inside"][3].val == -12
    assert ran["done"] is True
    assert ran.twin.object_pose("wall").position[0] == pytest.approx(0.32)
    (finding,) = ran.findings
    assert "the goal is in collision" in finding
    assert "'wall'" in finding


def test_a_cartesian_path_ends_before_a_collision_unless_reported_not_to_look(run):
    ran = run(
        SCENE
        + """
arm.set_named_target("ready"); arm.go()
here = arm.get_current_pose().pose
down = copy.deepcopy(here); down.position.z -= 0.3
table = copy.deepcopy(place)
table.pose.position.z = here.position.z - 0.33
scene.add_box("table", table, size=(0.4, 0.4, 0.1))
_, careful = arm.compute_cartesian_path([down], 0.01)
_, careless = arm.compute_cartesian_path([down], 0.01, avoid_collisions=False)
"""
    )
    assert 0.2 < ran["careful"] < 0.9
    assert ran["careless"] == 1.0


def test_a_collision_that_is_allowed_is_no_hindrance(run):
    ran = run(
        SCENE
        + """
arm.set_named_target("ready"); arm.go()
scene.add_box("cloud", place, size=(0.6, 0.6, 1.0))
before = arm.plan([0.5, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])[3].val
change = moveit_msgs.msg.PlanningScene(is_diff=True)
change.allowed_collision_matrix.default_entry_names = ["cloud"]
change.allowed_collision_matrix.default_entry_values = [True]
scene.apply_planning_scene(change)
after = arm.plan([0.5, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])[3].val
"""
    )
    assert ran["before"] == -10
    assert ran["after"] == 1


def test_a_flat_mesh_is_kept_but_reported_to_be_no_body(run):
    ran = run(
        SCENE
        + """
item = moveit_msgs.msg.CollisionObject(id="sheet", header=place.header, pose=place.pose)
import shape_msgs.msg
item.meshes = [shape_msgs.msg.Mesh(vertices=[
    geometry_msgs.msg.Point(x, y, 0.0) for x in (0, 1) for y in (0, 1)])]
scene.add_object(item)
names = scene.get_known_object_names()
"""
    )
    assert ran["names"] == ["sheet"]
    assert "a mesh of scene object 'sheet' has no volume" in ran.findings[0]


@pytest.mark.parametrize(
    ("change", "seen"),
    [
        ("late.add_box('cube', place, (0.02, 0.02, 0.02))", "scene.get_known_object_names()"),
        ("arm.attach_object('box', 'panda_hand')", "list(scene.get_attached_objects())"),
        ("late.attach_box('panda_hand', 'box')", "list(scene.get_attached_objects(['box']))"),
        ("late.remove_world_object('box')", "list(scene.get_objects())"),
    ],
)
def test_what_is_changed_by_topic_is_not_seen_at_once(run, change, seen):
    ran = run(
        SCENE
        + f"""
late = moveit_commander.PlanningSceneInterface(synchronous=False)
scene.add_box("box", place, (0.02, 0.02, 0.02))
before = {seen}
{change}
at_once = {seen}
rospy.sleep(0.1)
after = {seen}
"""
    )
    assert ran["at_once"] == ran["before"] != ran["after"]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("change", "seen"),
    [
        ("scene.add_box('cube', place)", "scene.get_known_object_names()"),
        ("scene.attach_box('panda_hand', 'box')", "list(scene.get_attached_objects())"),
        (
            "arm.attach_object('box', 'panda_hand'); scene.add_box('cube', place)",
            "list(scene.get_attached_objects())",
        ),
    ],
)
def test_what_is_changed_by_the_service_is_seen_at_once(run, change, seen):
    ran = run(
        SCENE
        + f"""
scene.add_box("box", place, (0.02, 0.02, 0.02))
before = {seen}
{change}
at_once = {seen}
"""
    )
    assert len(ran["at_once"]) == len(ran["before"]) + 1


def test_a_plan_right_after_knows_what_was_changed_by_topic(run):
    ran = run(
        SCENE
        + """
arm.set_named_target("ready"); arm.go()
scene.add_box("box", arm.get_current_pose(), size=(0.02, 0.02, 0.1))
robot = moveit_commander.RobotCommander()
arm.attach_object("box", "panda_hand", robot.get_link_names())
arm.shift_pose_target(2, -0.1)
done = arm.go()
"""
    )
    assert ran["done"]


_HELD = """
from geometry_msgs.msg import PoseStamped
arm.set_named_target("ready"); arm.go()
pose = PoseStamped()
pose.header.frame_id = "panda_hand"
pose.pose.orientation.w = 1.0
pose.pose.position.z = Z
"""


@pytest.mark.slow(but=3)
@pytest.mark.parametrize(
    ("height", "attach", "done"),
    [
        (0.11, 'scene.attach_box("panda_hand", "box", pose, (0.1, 0.1, 0.1))', False),
        (0.11, 'scene.attach_sphere("panda_hand", "box", pose, 0.04)', False),
        (
            0.11,
            'scene.attach_box("panda_hand", "box", pose, (0.1, 0.1, 0.1), ["panda_hand"])',
            False,
        ),
        (
            0.11,
            'scene.add_box("box", pose, (0.1,) * 3); arm.attach_object("box", "panda_hand")',
            False,
        ),
        (0.11, 'scene.attach_box("panda_hand", "box", pose, (0.1, 0.1, 0.1), FINGERS)', True),
        (0.17, 'scene.attach_box("panda_hand", "box", pose, (0.1, 0.1, 0.1))', True),
        (0.03, 'scene.attach_box("panda_hand", "box", pose, (0.05, 0.05, 0.05))', True),
    ],
)
def test_what_is_attached_may_touch_its_link_and_no_other(run, height, attach, done):
    ran = run(
        SCENE
        + 'FINGERS = ["panda_leftfinger", "panda_rightfinger"]\n'
        + _HELD.replace("Z", str(height))
        + attach
        + "\nrospy.sleep(0.5)\ntarget = [0.8, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]\n"
        + "done = arm.go(target)\n"
    )
    assert ran["done"] is done
    assert any("the arm begins in collision" in text for text in ran.findings) is not done
