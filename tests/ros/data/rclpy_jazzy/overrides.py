import rclpy
from rclpy.parameter import Parameter

rclpy.init(args=["program", "--ros-args", "-p", "speed:=0.25", "-p", "names:=[a, b]", "-p", "arm:on:=true", "-p", "limits.low:=-1"])
arm = rclpy.create_node("arm")
print(arm.declare_parameter("speed", 1.0).value)
print(arm.declare_parameter("names", ["x"]).value, arm.declare_parameter("on", False).value)
print(arm.declare_parameter("limits.low", 0).value)
print(sorted(name for name in arm._parameter_overrides if name != "use_sim_time"))
try:
    rclpy.create_node("typed").declare_parameter("speed", 3)
except Exception as error:
    print(type(error).__name__, error)
hand = rclpy.create_node("hand", automatically_declare_parameters_from_overrides=True, parameter_overrides=[Parameter("width", value=0.04)])
print(hand.get_parameter("width").value, hand.get_parameter("speed").value, hand.has_parameter("on"))
free = rclpy.create_node("free", allow_undeclared_parameters=True)
print(free.get_parameter("nothing").type_.name, free.set_parameters([Parameter("new", value=[1, 2])])[0].successful)
print(list(free.get_parameter("new").value), type(free.get_parameter("new").value).__name__)
print(free.declare_parameter("ignored", 4, ignore_override=True).value)
free.undeclare_parameter("ignored")
print(free.has_parameter("ignored"))
quiet = rclpy.create_node("quiet", start_parameter_services=False, enable_rosout=False)
print([name for name, _ in quiet.get_service_names_and_types_by_node("quiet", "/") if "parameter" in name])
alone = rclpy.create_node("alone", use_global_arguments=False, cli_args=["--ros-args", "-p", "own:=1", "-r", "__node:=renamed"])
print(alone.get_name(), alone.declare_parameter("own", 0).value, alone.declare_parameter("speed", 9.0).value)
