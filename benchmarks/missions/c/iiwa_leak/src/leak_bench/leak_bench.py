#!/usr/bin/env python
"""Leak test of a manifold with a LBR iiwa 7: couple to each port, pressurise, judge, mark the leaky ones (SMACH)."""
import actionlib
import rospy
import smach
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from leak_msgs.srv import LeakTest
from std_msgs.msg import Float32, UInt16, UInt16MultiArray
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

NAMES = ["lbr_A%d" % i for i in range(1, 8)]
HOME = [0.0, 0.4363, 0.0, -1.5707, 0.0, 1.1, 0.0]

# port number -> (in front of it, coupled)
PORTS = {
    11: ([-0.2512, 0.4857, -0.0528, -1.6616, 0.0294, 0.9952, -0.3139],
         [-0.2546, 0.5925, -0.0486, -1.7060, 0.0363, 0.8439, -0.3190]),
    12: ([0.0155, 0.4391, -0.0197, -1.7324, 0.0101, 0.9702, -0.0080],
         [0.0141, 0.5509, -0.0181, -1.7774, 0.0130, 0.8134, -0.0102]),
    13: ([0.2796, 0.4852, 0.0155, -1.6616, -0.0086, 0.9949, 0.2980],
         [0.2806, 0.5921, 0.0143, -1.7060, -0.0107, 0.8436, 0.2996]),
}
LIMIT_MBAR = 2.5
TEST_BAR = 6.0


class Mover(object):
    def __init__(self):
        self.client = actionlib.SimpleActionClient("/joint_trajectory_controller/follow_joint_trajectory",
                                                   FollowJointTrajectoryAction)
        self.client.wait_for_server()

    def __call__(self, joints, seconds):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = NAMES
        goal.trajectory.points = [JointTrajectoryPoint(
            positions=joints, velocities=[0.0] * 7, time_from_start=rospy.Duration.from_sec(seconds))]
        self.client.send_goal(goal)
        self.client.wait_for_result()
        return self.client.get_result().error_code == 0


class Next(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["port", "finished"], input_keys=["queue"], output_keys=["queue", "port"])

    def execute(self, ud):
        if not ud.queue:
            return "finished"
        ud.port = ud.queue[0]
        ud.queue = ud.queue[1:]
        return "port"


class Couple(smach.State):
    def __init__(self, move, clamp):
        smach.State.__init__(self, outcomes=["coupled", "failed"], input_keys=["port"])
        self.move, self.clamp = move, clamp

    def execute(self, ud):
        front, coupled = PORTS[ud.port]
        if not (self.move(front, 1.8) and self.move(coupled, 1.2)):
            return "failed"
        self.clamp(True)
        return "coupled"


class Test(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["tight", "leaky"], input_keys=["port"], output_keys=["loss"])
        self.test = rospy.ServiceProxy("/tester/run", LeakTest)

    def execute(self, ud):
        answer = self.test(port=ud.port, pressure_bar=TEST_BAR, hold_s=0.8)
        ud.loss = answer.loss_mbar
        return "leaky" if answer.loss_mbar > LIMIT_MBAR else "tight"


class Mark(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["marked"], input_keys=["port", "loss", "bad"], output_keys=["bad"])
        self.port = rospy.Publisher("/marker/port", UInt16, queue_size=5)
        self.loss = rospy.Publisher("/marker/loss_mbar", Float32, queue_size=5)

    def execute(self, ud):
        ud.bad = ud.bad + [ud.port]
        self.port.publish(ud.port)
        self.loss.publish(ud.loss)
        return "marked"


class Release(smach.State):
    def __init__(self, move, clamp):
        smach.State.__init__(self, outcomes=["free"], input_keys=["port"])
        self.move, self.clamp = move, clamp
        self.vent = rospy.ServiceProxy("/tester/vent", Trigger)

    def execute(self, ud):
        self.vent()
        self.clamp(False)
        self.move(PORTS[ud.port][0], 1.2)
        return "free"


def main():
    rospy.init_node("leak_bench")
    move = Mover()
    clamp = rospy.ServiceProxy("/coupling/clamp", SetBool)
    protocol = rospy.Publisher("/protocol/leaky", UInt16MultiArray, queue_size=1)
    machine = smach.StateMachine(outcomes=["done", "broken"])
    machine.userdata.queue = rospy.get_param("~ports")
    machine.userdata.bad = []
    machine.userdata.loss = 0.0
    with machine:
        smach.StateMachine.add("NEXT", Next(), {"port": "COUPLE", "finished": "done"})
        smach.StateMachine.add("COUPLE", Couple(move, clamp), {"coupled": "TEST", "failed": "broken"})
        smach.StateMachine.add("TEST", Test(), {"tight": "RELEASE", "leaky": "MARK"})
        smach.StateMachine.add("MARK", Mark(), {"marked": "RELEASE"})
        smach.StateMachine.add("RELEASE", Release(move, clamp), {"free": "NEXT"})
    move(HOME, 1.5)
    machine.execute()
    move(HOME, 2.0)
    protocol.publish(UInt16MultiArray(data=machine.userdata.bad))
    rospy.sleep(0.2)


if __name__ == "__main__":
    main()
