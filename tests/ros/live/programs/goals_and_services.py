"""Goals with feedback, and services. A wait in vain is in `wait_for_service`: real rospy waits on
the wall clock, in which the arm would hold still for another time."""

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
HOME = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
ACTION = "/arm_controller/follow_joint_trajectory"


def switch(request):
    if not request.data:
        raise rospy.ServiceException("it stays on")
    return SetBoolResponse(True, "on")


def serve_and_call():
    rospy.Service("~trigger", Trigger, lambda request: TriggerResponse(True, "hello"))
    rospy.Service("switch", SetBool, switch)
    rospy.Service("pair", SetBool, lambda request: (request.data, "as tuple"))
    rospy.wait_for_service("switch", timeout=2.0)
    call = rospy.ServiceProxy("switch", SetBool)
    print("> on", call(True).message, call(data=True).success)
    try:
        call(False)
    except rospy.ServiceException as error:
        print("> refused", error)
    print("> pair", rospy.ServiceProxy("pair", SetBool)(True).message)
    trigger = rospy.ServiceProxy("/goals_and_services/trigger", Trigger)
    print("> trigger", trigger().message)
    try:
        rospy.ServiceProxy("/nobody", Trigger)()
    except rospy.ServiceException as error:
        print("> missing", error)
    try:
        call(1, 2, 3)
    except TypeError as error:
        print("> arguments", type(error).__name__)


def goal_to(positions, seconds):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points = [
        JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(seconds))
    ]
    return goal


class Watcher:
    def __init__(self):
        self.heard = 0
        self.names = None
        self.events = []

    def feedback(self, feedback):
        self.heard += 1
        self.names = feedback.joint_names

    def active(self):
        self.events.append("active")

    def done(self, state, result):
        self.events.append(f"done {state} {result.error_code}")


def reach(client, watcher):
    client.send_goal(
        goal_to([0.3, *HOME[1:]], 1.0),
        done_cb=watcher.done,
        active_cb=watcher.active,
        feedback_cb=watcher.feedback,
    )
    print("> waited", client.wait_for_result(), client.get_state())
    print("> result", client.get_result().error_code)


def back(client):
    state = client.send_goal_and_wait(goal_to(HOME, 0.5))
    print("> state", state, client.get_goal_status_text())


def main():
    rospy.init_node("goals_and_services")
    serve_and_call()
    client = actionlib.SimpleActionClient(ACTION, FollowJointTrajectoryAction)
    print("> server", client.wait_for_server())
    watcher = Watcher()
    reach(client, watcher)
    print("> events", watcher.events)
    print("> names", watcher.names == JOINTS, watcher.heard > 10)
    rospy.sleep(0.1)
    back(client)


if __name__ == "__main__":
    main()
