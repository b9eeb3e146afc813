import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter


class Arm(Node):
    def __init__(self):
        super().__init__("arm")
        self.declare_parameter("speed", 0.5)
        self.declare_parameters("gripper", [("width", 0.04), ("name", "hand")])
        self.add_pre_set_parameters_callback(self.before)
        self.add_on_set_parameters_callback(self.check)
        self.add_post_set_parameters_callback(self.after)

    def before(self, parameters):
        print("before", [parameter.name for parameter in parameters])
        return [*parameters, Parameter("gripper.name", value="changed")]

    def check(self, parameters):
        for parameter in parameters:
            if parameter.name == "speed" and parameter.value > 1.0:
                return SetParametersResult(successful=False, reason="too fast")
        return SetParametersResult(successful=True)

    def after(self, parameters):
        print("after", [(parameter.name, parameter.value) for parameter in parameters])


rclpy.init()
arm = Arm()
print(arm.set_parameters([Parameter("speed", value=0.7)]))
print(arm.set_parameters([Parameter("speed", value=2.0)]))
print(arm.get_parameter("speed").value, arm.get_parameter("gripper.name").value)
print(arm.set_parameters_atomically([Parameter("speed", Parameter.Type.DOUBLE, 0.9), Parameter("gripper.width", value=0.01)]))
print(sorted(arm.get_parameters_by_prefix("gripper")))
arm.remove_on_set_parameters_callback(arm.check)
print(arm.set_parameters([Parameter("speed", value=2.0)])[0].successful, arm.get_parameter("speed").value)
arm.remove_pre_set_parameters_callback(arm.before)
arm.remove_post_set_parameters_callback(arm.after)
print(arm.has_parameter("speed"), arm.has_parameter("none"))
try:
    arm.remove_on_set_parameters_callback(arm.check)
except Exception as error:
    print(type(error).__name__)
try:
    arm.set_parameters(["speed"])
except Exception as error:
    print(type(error).__name__)
arm.add_on_set_parameters_callback(lambda parameters: None)
try:
    arm.set_parameters([Parameter("speed", value=0.1)])
except Exception as error:
    print(type(error).__name__)
print(arm.get_parameter("speed").value)
print(arm.get_parameter("speed").to_parameter_msg().value.double_value)
print([int(arm.get_parameter_type(name)) for name in ("speed", "gripper.name")])
print(arm.list_parameters(["gripper"], 2).names, arm.list_parameters([], 1).names)
