import rclpy
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, ParameterType, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter


def attempt(words, act):
    try:
        print(words, act())
    except Exception as error:
        print(words, type(error).__name__, error)


class Arm(Node):
    def __init__(self):
        super().__init__("arm")
        self.declare_parameter("speed", 0.2, ParameterDescriptor(
            description="share of the fastest", floating_point_range=[FloatingPointRange(from_value=0.0, to_value=1.0, step=0.1)]))
        self.declare_parameter("tries", 3, ParameterDescriptor(integer_range=[IntegerRange(from_value=1, to_value=9, step=2)]))
        self.declare_parameter("model", "ur5e", ParameterDescriptor(read_only=True))
        self.declare_parameter("anything", 1, ParameterDescriptor(dynamic_typing=True))
        self.declare_parameters("home", [("joints", [0.0, -1.57]), ("frame", "base"), ("wait", Parameter.Type.DOUBLE)])
        self.judging = self.add_on_set_parameters_callback(self.judge)

    def judge(self, parameters):
        for parameter in parameters:
            if parameter.name == "speed" and parameter.value > 0.8:
                return SetParametersResult(successful=False, reason="too fast for the cell")
        return SetParametersResult(successful=True)


rclpy.init()
arm = Arm()


def put(name, value, kind=None):
    return lambda: [(answer.successful, answer.reason) for answer in arm.set_parameters(
        [Parameter(name, kind, value) if kind else Parameter(name, value=value)])]


attempt("speed 0.5", put("speed", 0.5))
attempt("speed 0.9", put("speed", 0.9))
attempt("speed 1.5", put("speed", 1.5))
attempt("speed 0.55", put("speed", 0.55))
attempt("speed whole", put("speed", 1))
attempt("speed", lambda: arm.get_parameter("speed").value)
attempt("tries 4", put("tries", 4))
attempt("tries 5", put("tries", 5))
attempt("model", put("model", "ur10e"))
attempt("anything text", put("anything", "text"))
attempt("joints ints", put("home.joints", [1, 2]))
attempt("joints", put("home.joints", [1.0, 2.0]))
attempt("unknown", put("unknown", 1))
attempt("wait", lambda: arm.get_parameter("home.wait").value)
attempt("wait or", lambda: arm.get_parameter_or("home.wait", Parameter("home.wait", value=2.0)).value)
attempt("wait set", put("home.wait", 1.5))
attempt("wait", lambda: arm.get_parameter("home.wait").value)
attempt("get unknown", lambda: arm.get_parameter("unknown").value)
attempt("again", lambda: arm.declare_parameter("speed", 0.3).value)
attempt("no value", lambda: arm.declare_parameter("plain").value)
attempt("beyond its range", lambda: arm.declare_parameter("far", 3, ParameterDescriptor(
    integer_range=[IntegerRange(from_value=0, to_value=2, step=1)])).value)
attempt("prefix", lambda: sorted(arm.get_parameters_by_prefix("home")))
attempt("has", lambda: (arm.has_parameter("home.frame"), arm.has_parameter("frame")))
attempt("descriptor", lambda: (arm.describe_parameter("speed").description, arm.describe_parameter("speed").type == ParameterType.PARAMETER_DOUBLE))
attempt("type", lambda: arm.get_parameter_type("home.joints").name)
attempt("several", lambda: [parameter.value for parameter in arm.get_parameters(["speed", "tries"])])
attempt("undeclare read only", lambda: arm.undeclare_parameter("model"))
attempt("undeclare", lambda: arm.undeclare_parameter("tries"))
attempt("undeclare once more", lambda: arm.undeclare_parameter("tries"))
attempt("atomically", lambda: (lambda answer: (answer.successful, answer.reason))(
    arm.set_parameters_atomically([Parameter("home.frame", value="tool"), Parameter("speed", value=0.9)])))
attempt("frame", lambda: arm.get_parameter("home.frame").value)

order = []
attempt("what add returned", lambda: (arm.judging, arm.remove_on_set_parameters_callback(arm.judging)))
arm.remove_on_set_parameters_callback(arm.judge)
attempt("handle is taken", lambda: setattr(arm, "handle", 1))
arm.add_pre_set_parameters_callback(lambda parameters: (order.append("pre"), parameters + [Parameter("home.frame", value="added")])[1])
arm.add_on_set_parameters_callback(lambda parameters: (order.append(("on", [p.name for p in parameters])), SetParametersResult(successful=True))[1])
arm.add_post_set_parameters_callback(lambda parameters: order.append(("post", [p.name for p in parameters])))
attempt("free", put("speed", 0.9))
print(order, arm.get_parameter("home.frame").value)
arm.add_on_set_parameters_callback(lambda parameters: None)
attempt("returns none", put("speed", 0.1))
attempt("speed", lambda: arm.get_parameter("speed").value)
attempt("undo type", lambda: put("speed", None, Parameter.Type.NOT_SET)())

loose = Node("loose", allow_undeclared_parameters=True, parameter_overrides=[Parameter("gain", value=2.0), Parameter("x.y", value=1)])
attempt("loose", lambda: loose.get_parameter("gain").value)
attempt("declared", lambda: loose.declare_parameter("gain", 1.0).value)
attempt("loose unknown", lambda: loose.get_parameter("never").value)
attempt("loose set", lambda: [answer.successful for answer in loose.set_parameters([Parameter("never", value=1)])])
attempt("loose unknown", lambda: loose.get_parameter("never").value)
auto = Node("auto", automatically_declare_parameters_from_overrides=True, parameter_overrides=[Parameter("x.y", value=1)])
attempt("auto", lambda: auto.get_parameter("x.y").value)
attempt("auto again", lambda: auto.declare_parameter("x.y", 3).value)
rclpy.shutdown()
