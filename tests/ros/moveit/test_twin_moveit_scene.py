"""The planning scene over services and topics, as programs tell it."""

import pytest

PROGRAM = """
import rospy
from geometry_msgs.msg import Pose, Point, Quaternion
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, PlanningScene
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene, GetPlanningSceneRequest
from shape_msgs.msg import SolidPrimitive

rospy.init_node("scene")
rospy.wait_for_service("/apply_planning_scene")
apply = rospy.ServiceProxy("/apply_planning_scene", ApplyPlanningScene)
get = rospy.ServiceProxy("/get_planning_scene", GetPlanningScene)

def box(name, z=0.6, operation=CollisionObject.ADD, frame="panda_link0"):
    item = CollisionObject(id=name, operation=operation)
    item.header.frame_id = frame
    item.pose = Pose(Point(-0.6, 0.6, z), Quaternion(0, 0, 0, 1))
    item.primitives = [SolidPrimitive(type=1, dimensions=[0.05] * 3)]
    item.primitive_poses = [Pose(orientation=Quaternion(0, 0, 0, 1))]
    return item

def known():
    request = GetPlanningSceneRequest()
    request.components.components = 4 | 8 | 16
    scene = get(request).scene
    world = {each.id: each.pose.position.z for each in scene.world.collision_objects}
    attached = {each.object.id: each.link_name
                for each in scene.robot_state.attached_collision_objects}
    return world, attached

def diff(*objects):
    scene = PlanningScene(is_diff=True)
    scene.world.collision_objects = list(objects)
    return apply(scene).success

told = [diff(box("a"), box("b"))]
objects = rospy.Publisher("/collision_object", CollisionObject, queue_size=1)
objects.publish(box("b", 0.8, CollisionObject.MOVE))
at_once = known()
rospy.sleep(0.1)
first = known()
carried = AttachedCollisionObject(link_name="panda_hand", touch_links=["panda_hand"])
carried.object = CollisionObject(id="a", operation=CollisionObject.ADD)
rospy.Publisher("/attached_collision_object", AttachedCollisionObject, queue_size=1).publish(
    carried)
rospy.sleep(0.1)
second = known()
told.append(diff(box("c", operation=CollisionObject.REMOVE)))
told.append(diff(box("a", operation=CollisionObject.REMOVE)))
told.append(diff(box("d", frame="table")))
told.append(apply(PlanningScene()).success)
third = known()
"""


def test_objects_are_added_moved_attached_and_cleared(run_on_twin):
    ran = run_on_twin(PROGRAM)
    assert ran["told"] == [True, False, False, False, True]
    assert ran["at_once"][0] == {"a": pytest.approx(0.6), "b": pytest.approx(0.6)}
    assert ran["first"] == ({"a": pytest.approx(0.6), "b": pytest.approx(0.8)}, {})
    assert ran["second"] == ({"b": pytest.approx(0.8)}, {"a": "panda_hand"})
    assert ran["third"] == ({}, {})
    assert not any("'c'" in message for message in ran.findings)
    attached = "'a' cannot be removed from the world: it is attached to link 'panda_hand'"
    assert any(attached in message for message in ran.findings)
    assert any("unknown frame 'table'" in message for message in ran.findings)


def test_the_map_of_a_camera_can_be_cleared(run_on_twin):
    ran = run_on_twin(
        """
import rospy
from std_srvs.srv import Empty
rospy.init_node("clears")
rospy.wait_for_service("/clear_octomap", timeout=1.0)
answer = rospy.ServiceProxy("/clear_octomap", Empty)()
"""
    )
    assert ran["answer"] is not None
