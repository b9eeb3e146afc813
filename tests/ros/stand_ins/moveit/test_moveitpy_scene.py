"""The planning scene of MoveItPy."""

import numpy as np
import pytest


def test_an_object_is_a_body_that_plans_avoid(run):
    ran = run(
        """
go("ready")
with monitor.read_write() as scene:
    scene.apply_collision_object(box("wall", (0.45, 0.25, 0.55), (0.4, 0.05, 0.5)))
    known = scene.knows_frame_transform("wall")
    place = scene.get_frame_transform("wall")
    listed = [one.id for one in scene.planning_scene_message.world.collision_objects]
state = RobotState(panda.get_robot_model())
state.set_joint_group_positions("panda_arm", [1.2, *READY[1:]])
arm.set_goal_state(robot_state=state)
plan = arm.plan()
clear = not any(
    scene.is_state_colliding(state, "panda_arm") for state, _ in plan.trajectory
)
valid = scene.is_path_valid(plan.trajectory, "panda_arm")
straight = []
for step in np.linspace(0.0, 1.2, 25):
    state.set_joint_group_positions("panda_arm", [step, *READY[1:]])
    straight.append(scene.is_state_colliding(state, "panda_arm"))
time.sleep(0.1)
"""
    )
    assert ran["known"] is True
    assert ran["place"][:3, 3].tolist() == [0.45, 0.25, 0.55]
    assert ran["listed"] == ["wall"]
    assert (ran["clear"], ran["valid"]) == (True, True)
    assert any(ran["straight"])
    assert not ran["straight"][0]
    assert ran.twin.object_pose("wall").position == pytest.approx((0.45, 0.25, 0.55), abs=1e-6)


def test_a_state_in_an_object_collides_until_that_is_allowed_or_the_object_is_gone(run):
    ran = run(
        """
from moveit.core.collision_detection import CollisionRequest, CollisionResult
go("ready")
with monitor.read_write() as scene:
    scene.apply_collision_object(box("block", (0.31, 0.0, 0.6), (0.2, 0.2, 0.2)))
    hits = scene.is_state_colliding("panda_arm", verbose=True)
    invalid = scene.is_state_valid(scene.current_state, "panda_arm")
    request, result = CollisionRequest(), CollisionResult()
    request.contacts, request.max_contacts = True, 100
    scene.check_collision(request, result)
    own = CollisionResult()
    scene.check_self_collision(request, own)
    acm = scene.allowed_collision_matrix
    before = acm.get_entry("block", "panda_hand")
    for link in (*panda.get_robot_model().get_joint_model_group("panda_arm").link_model_names,
                 "panda_hand", "panda_leftfinger", "panda_rightfinger"):
        acm.set_entry("block", link, True)
    after = scene.allowed_collision_matrix.get_entry("block", "panda_hand")
    allowed = scene.is_state_colliding("panda_arm")
    acm.remove_entry("block", "panda_hand")
    again = scene.is_state_colliding("panda_arm")
    scene.remove_all_collision_objects()
    gone = scene.is_state_colliding("panda_arm")
"""
    )
    assert (ran["hits"], ran["allowed"], ran["again"], ran["gone"]) == (True, False, True, False)
    assert ran["invalid"] is False
    assert ran["result"].collision is True
    assert ran["result"].contact_count >= 1
    assert ran["own"].collision is False
    assert (ran["before"], ran["after"]) == ((False, "UNKNOWN"), (True, "ALWAYS"))


def test_an_attached_object_moves_with_the_hand_and_stays_where_it_is_detached(run):
    ran = run(
        """
go("ready")
attached = AttachedCollisionObject(link_name="panda_hand", touch_links=["panda_hand", "panda_leftfinger", "panda_rightfinger"])
attached.object = box("part", (0.0, 0.0, 0.15), (0.02, 0.02, 0.05), frame="panda_hand")
first = monitor.process_attached_collision_object(attached)
with monitor.read_only() as scene:
    held = [one.object.id for one in scene.planning_scene_message.robot_state.attached_collision_objects]
    before = scene.get_frame_transform("part")[:3, 3]
go("transport")
with monitor.read_only() as scene:
    after = scene.get_frame_transform("part")[:3, 3]
attached.object.operation = CollisionObject.REMOVE
second = monitor.process_attached_collision_object(attached)
with monitor.read_only() as scene:
    world = [one.id for one in scene.planning_scene_message.world.collision_objects]
    put = scene.get_frame_transform("part")[:3, 3]
"""
    )
    assert (ran["first"], ran["second"]) == (True, True)
    assert ran["held"] == ["part"]
    assert np.linalg.norm(ran["after"] - ran["before"]) > 0.05
    assert ran["world"] == ["part"]
    assert ran["put"] == pytest.approx(ran["after"], abs=0.003)


def test_a_copy_of_the_scene_is_for_planning_alone(run):
    ran = run(
        """
go("ready")
with monitor.read_only() as scene:
    other = copy.deepcopy(scene)
other.apply_collision_object(box("ghost", (0.31, 0.0, 0.6), (0.2, 0.2, 0.2)))
there = other.is_state_colliding("panda_arm")
with monitor.read_only() as scene:
    here = scene.is_state_colliding("panda_arm")
arm.set_goal_state(configuration_name="transport")
parameters = PlanRequestParameters(panda, "")
among = arm.plan(single_plan_parameters=parameters, planning_scene=other)
code = among.error_code.val
free = arm.plan(single_plan_parameters=parameters)
"""
    )
    assert (ran["there"], ran["here"]) == (True, False)
    assert ran["code"] == -10
    assert bool(ran["free"])
    with pytest.raises(Exception, match="ghost"):
        ran.twin.object_pose("ghost")


def test_a_scene_message_is_applied(run):
    ran = run(
        """
from moveit_msgs.msg import PlanningScene, PlanningSceneWorld
message = PlanningScene(is_diff=True)
message.world.collision_objects = [box("one", (0.6, 0.0, 0.1), (0.1, 0.1, 0.1))]
first = monitor.new_planning_scene_message(message)
with monitor.read_write() as scene:
    world = PlanningSceneWorld(collision_objects=[box("two", (0.6, 0.3, 0.1), (0.1, 0.1, 0.1))])
    second = scene.process_planning_scene_world(world)
third = monitor.process_collision_object(CollisionObject(id="none", operation=CollisionObject.REMOVE))
with monitor.read_only() as scene:
    names = [one.id for one in scene.planning_scene_message.world.collision_objects]
"""
    )
    assert (ran["first"], ran["second"], ran["third"]) == (True, True, False)
    assert ran["names"] == ["one", "two"]
    assert not ran.findings, "what is not there needs no removal"


def test_a_world_is_written_and_read_again(run, tmp_path):
    file = tmp_path / "world.scene"
    ran = run(
        f"""
with monitor.read_write() as scene:
    scene.apply_collision_object(box("block", (0.5, -0.1, 0.2), (0.1, 0.2, 0.3)))
    wrote = scene.save_geometry_to_file("{file}")
    scene.remove_all_collision_objects()
    read = scene.load_geometry_from_file("{file}")
    (block,) = scene.planning_scene_message.world.collision_objects
    nowhere = scene.save_geometry_to_file("{tmp_path}/none/world.scene")
    try:
        scene.load_geometry_from_file(__file__)
    except RuntimeError as error:
        refused = str(error)
"""
    )
    assert (ran["wrote"], ran["read"], ran["nowhere"]) == (True, True, False)
    assert file.read_text().splitlines()[:3] == ["(noname)", "* block", "0.5 -0.1 0.2"]
    assert list(ran["block"].primitives[0].dimensions) == [0.1, 0.2, 0.3]
    assert ran["block"].pose.position.y == -0.1
    assert "is no .scene file" in ran["refused"]


def test_planning_within_the_lock_is_reported_as_the_deadlock_that_it_is(run):
    # planning_scene_monitor.cpp of moveit/moveit2: updateFrameTransforms, which plan() calls,
    # locks scene_update_mutex_ for itself alone.
    ran = run(
        """
arm.set_goal_state(configuration_name="ready")
with monitor.read_only() as scene:
    arm.plan()
"""
    )
    assert ran.over is not None
    assert ran.over.cause == "deadlock"
    assert (
        "the lock of the planning scene, which it holds itself (leave the `with`"
        in ran.over.message
    )


def test_a_writer_who_needs_the_lock_again_gets_an_error(run):
    # glibc: pthread_rwlock_wrlock answers EDEADLK to the thread that writes, a system_error in C++.
    ran = run(
        """
arm.set_goal_state(configuration_name="ready")
try:
    with monitor.read_write() as scene:
        arm.plan()
except RuntimeError as error:
    said = str(error)
plan = arm.plan()
"""
    )
    assert ran["said"].startswith("Resource deadlock avoided: the thread holds the lock")
    assert bool(ran["plan"])


def test_readers_share_the_lock_and_a_writer_waits_for_them(run):
    ran = run(
        """
import threading
order = []
def write():
    with monitor.read_write():
        order.append("write")
with monitor.read_only():
    with monitor.read_only():
        thread = threading.Thread(target=write)
        thread.start()
        time.sleep(1.0)
        order.append("read")
thread.join()
"""
    )
    assert ran["order"] == ["read", "write"]
