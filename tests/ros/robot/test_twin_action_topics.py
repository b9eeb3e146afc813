"""Actions of ROS 1 by their topics alone."""

PROGRAM = """
import rospy
from actionlib_msgs.msg import GoalID, GoalStatusArray
from control_msgs.msg import FollowJointTrajectoryActionGoal, FollowJointTrajectoryActionResult
from trajectory_msgs.msg import JointTrajectoryPoint

rospy.init_node("raw")
results, states, arrays = [], [], []
rospy.Subscriber("/arm/result", FollowJointTrajectoryActionResult, results.append)
def told_status(array):
    told = [(each.goal_id.id, each.status) for each in array.status_list]
    arrays.append(told)
    if not states or states[-1] != told:
        states.append(told)

rospy.Subscriber("/arm/status", GoalStatusArray, told_status)
goals = rospy.Publisher("/arm/goal", FollowJointTrajectoryActionGoal, queue_size=1)
cancels = rospy.Publisher("/arm/cancel", GoalID, queue_size=1)

def send(name):
    message = FollowJointTrajectoryActionGoal()
    message.goal_id.id = name
    message.goal.trajectory.joint_names = ["panda_joint%d" % i for i in range(1, 8)]
    position = [0.3 if name == "there" else 0.0, -0.5599, 0.0, -2.6, 0.0, 2.0, 0.785]
    message.goal.trajectory.points = [
        JointTrajectoryPoint(positions=position, time_from_start=rospy.Duration(1.0))]
    goals.publish(message)

send("there")
rospy.sleep(2.0)
send("back")
rospy.sleep(0.3)
cancels.publish(GoalID(id="back"))
rospy.sleep(1.0)
told = [(each.status.goal_id.id, each.status.status) for each in results]
"""


def test_a_goal_that_is_published_is_pursued_and_can_be_cancelled(run_on_twin):
    ran = run_on_twin(PROGRAM)
    assert ran["told"] == [("there", 3), ("back", 2)]
    assert ran["states"] == [
        [],
        [("there", 1)],
        [("there", 3)],
        [("there", 3), ("back", 1)],
        [("there", 3), ("back", 6)],
        [("there", 3), ("back", 2)],
    ]
    # Five times a second, and at each change.
    assert 20 <= len(ran["arrays"]) <= 24
    assert ran.owners == ["send", "send"]
    assert [command.end for command in ran.recording.commands] == ["arrived", "cancelled"]
