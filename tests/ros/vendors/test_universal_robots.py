"""The controller box of a Universal Robots arm, by the messages of either ROS."""

import pytest

OUTPUT = "set_io: an output of the controller box moves nothing of the twin"


def test_outputs_and_payloads_are_taken_and_the_speed_slider_is_refused(run_on):
    ran = run_on(
        "ur5",
        """
import rospy
from ur_msgs.srv import SetIO, SetIORequest, SetPayload, SetSpeedSliderFraction
rospy.init_node('box')
box = '/ur_hardware_interface/'
rospy.wait_for_service(box + 'set_io')
fun, on = SetIORequest.FUN_SET_DIGITAL_OUT, SetIORequest.STATE_ON
output = rospy.ServiceProxy(box + 'set_io', SetIO)(fun=fun, pin=1, state=on)
payload = rospy.ServiceProxy(box + 'set_payload', SetPayload)(mass=1.0)
slider = rospy.ServiceProxy(box + 'set_speed_slider', SetSpeedSliderFraction)(0.5)
""",
    )
    assert (ran["output"].success, ran["payload"].success, ran["slider"].success) == (
        True,
        True,
        False,
    )
    assert ran.findings == [
        OUTPUT,
        "set_payload: the twin's load is what it holds",
        "set_speed_slider: the twin moves as fast as it is asked to; ask for slower motions",
    ]


def test_outputs_are_taken_in_ros_2(run_on):
    ran = run_on(
        "ur5e",
        """
import rclpy
from ur_msgs.srv import SetIO
rclpy.init()
node = rclpy.create_node('box')
client = node.create_client(SetIO, '/io_and_status_controller/set_io')
client.wait_for_service()
future = client.call_async(SetIO.Request(fun=SetIO.Request.FUN_SET_DIGITAL_OUT, pin=0, state=1.0))
rclpy.spin_until_future_complete(node, future)
output = future.result()
""",
        ros=2,
    )
    assert ran["output"].success
    assert ran.findings == [OUTPUT]


IN_ROS_1 = """
import actionlib, rospy
from ur_dashboard_msgs.msg import RobotMode, SetModeAction, SetModeGoal
from ur_dashboard_msgs.srv import GetRobotMode, IsInRemoteControl
rospy.init_node('box')
box = '/ur_hardware_interface/dashboard/'
remote = rospy.ServiceProxy(box + 'is_in_remote_control', IsInRemoteControl)().in_remote_control
client = actionlib.SimpleActionClient('/ur_hardware_interface/set_mode', SetModeAction)
client.wait_for_server()
goal = SetModeGoal()
goal.target_robot_mode.mode = RobotMode.IDLE
client.send_goal_and_wait(goal, rospy.Duration(5))
mode = rospy.ServiceProxy(box + 'get_robot_mode', GetRobotMode)().robot_mode.mode
idle = RobotMode.IDLE
"""
IN_ROS_2 = """
import rclpy
from rclpy.action import ActionClient
from ur_dashboard_msgs.action import SetMode
from ur_dashboard_msgs.msg import RobotMode
from ur_dashboard_msgs.srv import GetRobotMode, IsInRemoteControl
rclpy.init()
node = rclpy.create_node('box')
def call(kind, name):
    client = node.create_client(kind, '/dashboard_client/' + name)
    future = client.call_async(kind.Request())
    rclpy.spin_until_future_complete(node, future)
    return future.result()
remote = call(IsInRemoteControl, 'is_in_remote_control').remote_control
client = ActionClient(node, SetMode, '/ur_hardware_interface/set_mode')
client.wait_for_server()
future = client.send_goal_async(SetMode.Goal(target_robot_mode=RobotMode.IDLE))
rclpy.spin_until_future_complete(node, future)
result = future.result().get_result_async()
rclpy.spin_until_future_complete(node, result)
mode = call(GetRobotMode, 'get_robot_mode').robot_mode.mode
idle = RobotMode.IDLE
"""


@pytest.mark.parametrize(("program", "ros"), [(IN_ROS_1, 1), (IN_ROS_2, 2)], ids=["ros1", "ros2"])
def test_the_dashboard_answers_in_the_fields_of_each_ros(run_on, program, ros):
    ran = run_on("ur5e", program, ros=ros)
    assert ran["remote"]
    assert ran["mode"] == ran["idle"]
