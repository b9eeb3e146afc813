import rclpy
from rclpy.parameter import Parameter
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
rclpy.init()
node = rclpy.create_node("n")
def tried(name, do):
    try:
        print(name, do())
    except Exception as error:
        print(name, type(error).__name__, error)
tried("undeclared", lambda: node.get_parameter("no"))
tried("declare", lambda: node.declare_parameter("a", 1).value)
tried("again", lambda: node.declare_parameter("a", 1))
tried("no value", lambda: node.declare_parameter("b").value)
tried("typed", lambda: node.declare_parameter("c", Parameter.Type.DOUBLE).value)
tried("get typed", lambda: node.get_parameter("c"))
tried("other type", lambda: node.set_parameters([Parameter("a", value="x")])[0])
tried("set undeclared", lambda: node.set_parameters([Parameter("z", value=1)]))
node.declare_parameter("r", 4, ParameterDescriptor(integer_range=[IntegerRange(from_value=0, to_value=10, step=2)]))
tried("out of range", lambda: node.set_parameters([Parameter("r", value=20)])[0])
tried("off step", lambda: node.set_parameters([Parameter("r", value=3)])[0])
node.declare_parameter("f", 0.5, ParameterDescriptor(floating_point_range=[FloatingPointRange(from_value=0.0, to_value=1.0)]))
tried("out of floats", lambda: node.set_parameters([Parameter("f", value=2.0)])[0])
node.declare_parameter("o", 1, ParameterDescriptor(read_only=True))
tried("read only", lambda: node.set_parameters([Parameter("o", value=2)])[0])
tried("undeclare read only", lambda: node.undeclare_parameter("o"))
tried("undeclare", lambda: node.undeclare_parameter("none"))
tried("list", lambda: node.declare_parameter("l", [1, 2.0]))
tried("empty list", lambda: node.declare_parameter("e", []).type_)
tried("name", lambda: node.declare_parameter("", 1))
tried("or", lambda: node.get_parameter_or("none", Parameter("none", value=3)).value)
tried("value of other", lambda: Parameter("x", Parameter.Type.INTEGER, "a"))
tried("dict", lambda: Parameter("x", value={}))
tried("describe", lambda: node.describe_parameter("none"))
