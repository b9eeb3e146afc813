"""End effectors of the plate cell."""
import rospy
from gazebo_ros_link_attacher.srv import Attach, AttachRequest
from ur_msgs.srv import SetIO, SetIORequest


class Tool(object):
    """Something on the flange of the UR5e that can hold a plate."""

    settle = 0.2

    def __init__(self):
        self.load = None

    def pick(self, name):
        self._on(name)
        self.load = name
        rospy.sleep(self.settle)

    def drop(self):
        self._off(self.load)
        self.load = None
        rospy.sleep(self.settle)

    def _on(self, name):
        raise NotImplementedError

    def _off(self, name):
        raise NotImplementedError


class Magnet(Tool):
    """A switched magnet on a digital output; its hold is a weld of the simulation."""

    COIL = 4
    settle = 0.3

    def __init__(self, current_pin=0):
        super(Magnet, self).__init__()
        self.current_pin = current_pin
        self._io = rospy.ServiceProxy("/ur_hardware_interface/set_io", SetIO)
        self._weld = rospy.ServiceProxy("/link_attacher_node/attach", Attach)
        self._unweld = rospy.ServiceProxy("/link_attacher_node/detach", Attach)

    def current(self, ampere):
        """The coil's driver takes 0..1 for 0..4 A."""
        self._io(fun=SetIORequest.FUN_SET_ANALOG_OUT, pin=self.current_pin, state=ampere / 4.0)

    def _on(self, name):
        self.current(3.0)
        self._io(fun=SetIORequest.FUN_SET_DIGITAL_OUT, pin=self.COIL, state=1.0)
        self._weld(self._request(name))

    def _off(self, name):
        self._io(fun=SetIORequest.FUN_SET_DIGITAL_OUT, pin=self.COIL, state=0.0)
        self._unweld(self._request(name))
        self.current(0.0)

    @staticmethod
    def _request(name):
        return AttachRequest(model_name_1="robot", link_name_1="tool0", model_name_2=name, link_name_2="link")
