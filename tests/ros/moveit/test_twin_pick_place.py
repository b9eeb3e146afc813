"""The actions Pickup and Place, sent by a program that knows no commander."""

PROGRAM = """
import actionlib, copy, rospy
from geometry_msgs.msg import PoseStamped
from moveit_commander import MoveGroupCommander, PlanningSceneInterface
from moveit_msgs.msg import (
    Grasp, GripperTranslation, PickupAction, PickupGoal, PlaceAction, PlaceGoal, PlaceLocation)
from trajectory_msgs.msg import JointTrajectoryPoint
rospy.init_node('picker')
scene = PlanningSceneInterface()
arm = MoveGroupCommander('panda_arm')
arm.set_named_target('ready')
arm.go()
top = arm.get_current_pose()
top.pose.position.z -= 0.15
cup = copy.deepcopy(top)
cup.pose.position.z -= 0.105
scene.add_box('cup', cup, size=(0.02, 0.02, 0.06))

def posture(opening):
    message = Grasp().grasp_posture
    message.joint_names = ['panda_finger_joint1', 'panda_finger_joint2']
    message.points = [JointTrajectoryPoint(positions=[opening, opening])]
    return message

def along(z):
    message = GripperTranslation(desired_distance=0.1, min_distance=0.05)
    message.direction.header.frame_id = 'panda_link0'
    message.direction.vector.z = z
    return message

def ask(name, kind, goal):
    client = actionlib.SimpleActionClient(name, kind)
    client.wait_for_server()
    client.send_goal_and_wait(goal)
    return client.get_state(), client.get_result().error_code.val

def pick(target):
    grasp = Grasp(grasp_pose=top, pre_grasp_posture=posture(0.03), grasp_posture=posture(0.01),
                  pre_grasp_approach=along(-1.0), post_grasp_retreat=along(1.0))
    return ask('/pickup', PickupAction,
               PickupGoal(target_name=target, group_name='panda_arm', possible_grasps=[grasp]))

def place():
    goal = copy.deepcopy(cup)
    goal.pose.position.y += 0.1
    there = PlaceLocation(place_pose=goal, pre_place_approach=along(-1.0),
                          post_place_retreat=along(1.0))
    return ask('/place', PlaceAction, PlaceGoal(attached_object_name='cup', place_locations=[there],
                                                group_name='panda_arm'))

picked = pick('cup')
held = list(scene.get_attached_objects())
placed = place()
missing = pick('mug')
"""


def test_goals_are_picked_and_placed_for_the_functions_that_sent_them(run_on_twin):
    ran = run_on_twin(PROGRAM)
    assert (ran["picked"], ran["placed"]) == ((3, 1), (3, 1))
    assert ran["held"] == ["cup"]
    assert ran["missing"] == (4, -19)
    assert ran.owners == ["<module>", "pick", "place"]
    assert any(
        "picking 'mug' failed: the planning scene has no such object" in each
        for each in ran.findings
    )


AGAIN = (
    PROGRAM.replace("place_locations=[there],", "place_locations=[away, there],")
    .replace(
        "    return ask('/place'",
        "    away = copy.deepcopy(there)\n    away.place_pose.pose.position.x = 3.0\n    return ask('/place'",
    )
    .replace("missing = pick('mug')\n", "")
)


def test_a_place_that_cannot_be_reached_is_settled_by_the_next_that_can(run_on_twin):
    ran = run_on_twin(AGAIN)
    assert (ran["picked"], ran["placed"]) == ((3, 1), (3, 1))
    failed = [each for each in ran.recording.findings if "placing 'cup' failed" in each.message]
    assert failed
    assert all(each.recovered_s is not None for each in failed)
