"""The part that controllers with keys share."""

JOG = """\
import moveit_commander, rospy

rospy.init_node("keys")
arm = moveit_commander.MoveGroupCommander("panda_arm")

def jog(delta):
    joints = arm.get_current_joint_values()
    joints[0] += delta
    arm.go(joints, wait=True)

"""
