#!/usr/bin/env python
"""Opens a quarter-turn valve with a Jaco 2 (j2n6s300) by the kinova_msgs actions. A worker thread takes orders
from a queue; the main thread only writes the recipe down."""
import queue
import threading

import actionlib
import rospy
from kinova_msgs.msg import (ArmJointAnglesAction, ArmJointAnglesGoal, SetFingersPositionAction,
                             SetFingersPositionGoal)
from std_msgs.msg import Float32, Int32, String
from std_srvs.srv import SetBool

DRIVER = "/j2n6s300_driver"
TURN_DEG = 90.0
STEPS = 3

HOME = [275.29, 167.58, 57.41, 240.82, 82.84, 75.82]
STANDOFF = [260.0, 190.0, 80.0, 240.0, 85.0, 75.0]
AT_VALVE = [256.0, 205.0, 92.0, 240.0, 88.0, 75.0]

OPEN = 500.0
GRASP = 5200.0
FULL = 6400.0


class Worker(threading.Thread):
    """Executes (function, arguments) in order until it finds None."""

    def __init__(self):
        super(Worker, self).__init__()
        self.orders = queue.Queue()
        self.error = None
        self.daemon = True

    def put(self, function, *args):
        self.orders.put((function, args))

    def run(self):
        while True:
            order = self.orders.get()
            if order is None:
                return
            function, args = order
            try:
                function(*args)
            except Exception as problem:  # the rest of the recipe must not run
                rospy.logerr("%s", problem)
                self.error = problem
                return

    def finish(self):
        self.orders.put(None)
        self.join()


class Jaco(object):
    def __init__(self):
        self.arm = actionlib.SimpleActionClient(DRIVER + "/joints_action/joint_angles", ArmJointAnglesAction)
        self.hand = actionlib.SimpleActionClient(DRIVER + "/fingers_action/finger_positions",
                                                 SetFingersPositionAction)
        self.arm.wait_for_server()
        self.hand.wait_for_server()

    def joints(self, degrees):
        goal = ArmJointAnglesGoal()
        for number, value in enumerate(degrees, 1):
            setattr(goal.angles, "joint%d" % number, value)
        self.arm.send_goal(goal)
        if not self.arm.wait_for_result(rospy.Duration(20.0)):
            self.arm.cancel_all_goals()
            raise RuntimeError("the arm did not arrive")

    def fingers(self, turns):
        turns = min(max(turns, 0.0), FULL)
        goal = SetFingersPositionGoal()
        goal.fingers.finger1 = goal.fingers.finger2 = goal.fingers.finger3 = turns
        self.hand.send_goal(goal)
        self.hand.wait_for_result(rospy.Duration(8.0))


class Valve(object):
    def __init__(self):
        self.angle = rospy.Publisher("/valve/angle", Float32, queue_size=8)
        self.state = rospy.Publisher("/valve/state", String, queue_size=8)
        self.number = rospy.Publisher("/plant/valve_opened", Int32, queue_size=2)
        self.pump = rospy.ServiceProxy("/pump/run", SetBool)

    def tell(self, degrees):
        self.angle.publish(degrees)
        self.state.publish("OPEN" if degrees >= TURN_DEG else "TURNING")

    def opened(self, number):
        self.number.publish(number)
        self.pump(True)


def turned(joints, degrees):
    out = list(joints)
    out[5] += degrees
    return out


def main():
    rospy.init_node("valve")
    number = rospy.get_param("~valve", 17)
    jaco, valve, worker = Jaco(), Valve(), Worker()
    valve.pump(False)
    worker.start()
    worker.put(jaco.joints, HOME)
    worker.put(jaco.fingers, OPEN)
    worker.put(jaco.joints, STANDOFF)
    worker.put(jaco.joints, AT_VALVE)
    worker.put(jaco.fingers, GRASP)
    for step in range(1, STEPS + 1):
        share = TURN_DEG * step / STEPS
        worker.put(jaco.joints, turned(AT_VALVE, share))
        worker.put(valve.tell, share)
    worker.put(jaco.fingers, OPEN)
    worker.put(jaco.joints, turned(STANDOFF, TURN_DEG))
    worker.put(valve.opened, number)
    worker.put(jaco.joints, HOME)
    worker.finish()
    if worker.error is not None:
        rospy.signal_shutdown("recipe broken off")
    rospy.sleep(0.2)


if __name__ == "__main__":
    main()
