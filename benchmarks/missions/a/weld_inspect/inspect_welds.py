#!/usr/bin/env python
"""UR10e looks at four welds of a frame; a bad one is marked.  SMACH state machine."""
import rospy
import smach
from moveit_commander import MoveGroupCommander
from std_msgs.msg import String
from std_srvs.srv import Trigger

from welds import HOME, MARK_OFFSET, WELDS


class Base(smach.State):
    arm = None  # shared by all states

    @classmethod
    def go(cls, joints):
        return cls.arm.go(joints, wait=True)


class Light(smach.State):
    def __init__(self, which):
        smach.State.__init__(self, outcomes=["done"])
        self.call = rospy.ServiceProxy("/light/" + which, Trigger)

    def execute(self, userdata):
        self.call()
        return "done"


class NextWeld(Base):
    def __init__(self):
        smach.State.__init__(self, outcomes=["weld", "all_seen", "failed"],
                             input_keys=["index", "weld"], output_keys=["index", "weld"])

    def execute(self, userdata):
        if userdata.index >= len(WELDS):
            return "all_seen"
        userdata.weld = WELDS[userdata.index]
        userdata.index += 1
        return "weld" if self.go(userdata.weld.view) else "failed"


class Look(Base):
    LOOKS = 2

    def __init__(self):
        smach.State.__init__(self, outcomes=["good", "bad", "blind"], input_keys=["weld"])
        self.camera = rospy.ServiceProxy("/camera/trigger", Trigger)
        self.report = rospy.Publisher("/welds/report", String, queue_size=10)

    def execute(self, userdata):
        for _ in range(self.LOOKS):
            seen = self.camera()
            if seen.success:
                break
            rospy.sleep(0.4)
        else:
            return "blind"
        self.report.publish("%s %s" % (userdata.weld.name, seen.message))
        return "good" if seen.message == "ok" else "bad"


class Mark(Base):
    """Put the marker's tip beside the weld and stamp."""

    def __init__(self):
        smach.State.__init__(self, outcomes=["marked", "failed"], input_keys=["weld"])
        self.stamp = rospy.ServiceProxy("/marker/stamp", Trigger)

    def execute(self, userdata):
        target = [q + d for q, d in zip(userdata.weld.view, MARK_OFFSET)]
        if not self.go(target):
            return "failed"
        ok = self.stamp().success
        self.go(userdata.weld.view)
        return "marked" if ok else "failed"


class Home(Base):
    def __init__(self):
        smach.State.__init__(self, outcomes=["home"])

    def execute(self, userdata):
        self.go(HOME)
        return "home"


def build():
    machine = smach.StateMachine(outcomes=["inspected", "aborted"])
    machine.userdata.index = 0
    with machine:
        add = smach.StateMachine.add
        add("LIGHT_ON", Light("on"), {"done": "NEXT"})
        add("NEXT", NextWeld(), {"weld": "LOOK", "all_seen": "HOME", "failed": "aborted"})
        add("LOOK", Look(), {"good": "NEXT", "bad": "MARK", "blind": "aborted"})
        add("MARK", Mark(), {"marked": "NEXT", "failed": "aborted"})
        add("HOME", Home(), {"home": "LIGHT_OFF"})
        add("LIGHT_OFF", Light("off"), {"done": "inspected"})
    return machine


if __name__ == "__main__":
    rospy.init_node("inspect_welds")
    Base.arm = MoveGroupCommander("manipulator")
    Base.arm.set_max_velocity_scaling_factor(0.5)
    Base.arm.set_max_acceleration_scaling_factor(0.5)
    outcome = build().execute()
    rospy.loginfo("inspection: %s", outcome)
