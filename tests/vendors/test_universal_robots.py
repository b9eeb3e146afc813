"""The controller box of a Universal Robots arm, by the messages of either ROS."""

from __future__ import annotations

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
