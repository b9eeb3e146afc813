#!/usr/bin/env python3
"""Turns the flange of a UR10 by 0.4 rad with the velocity controller (ur_modern_driver)."""
import rospy
from controller_manager_msgs.srv import SwitchController, SwitchControllerRequest
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

SPEED = 0.2
ANGLE = 0.4


def flange():
    state = rospy.wait_for_message("/joint_states", JointState)
    return state.position[state.name.index("wrist_3_joint")]


def switch():
    service = rospy.ServiceProxy("/controller_manager/switch_controller", SwitchController)
    service.wait_for_service()
    request = SwitchControllerRequest()
    request.start_controllers = ["joint_group_vel_controller"]
    request.stop_controllers = ["vel_based_pos_traj_controller"]
    request.strictness = SwitchControllerRequest.BEST_EFFORT
    return service(request).ok


def main():
    rospy.init_node("ur10_flange")
    publisher = rospy.Publisher(
        "/joint_group_vel_controller/command", Float64MultiArray, queue_size=1)
    if not switch():
        raise RuntimeError("the controllers were not switched")
    while publisher.get_num_connections() == 0:
        rospy.sleep(0.1)
    before = flange()
    rate = rospy.Rate(125)
    for _ in range(int(125 * ANGLE / SPEED)):
        publisher.publish(Float64MultiArray(data=[0.0, 0.0, 0.0, 0.0, 0.0, SPEED]))
        rate.sleep()
    for _ in range(25):
        publisher.publish(Float64MultiArray(data=[0.0] * 6))
        rate.sleep()
    rospy.sleep(1.0)
    rospy.loginfo("turned by %.2f", flange() - before)


if __name__ == "__main__":
    main()
