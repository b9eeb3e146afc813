import tempfile
import rclpy

TEXT = """
/**:
  ros__parameters:
    speed: 0.25
    joints: [a, b]
    gains: {p: 1.0, i: 2}
arm:
  ros__parameters:
    speed: 0.75
    flags: [true, false]
/left/arm:
  ros__parameters:
    side: left
"""
file = tempfile.NamedTemporaryFile("w", suffix=".yaml", delete=False)
file.write(TEXT)
file.close()
rclpy.init(args=["program", "--ros-args", "--params-file", file.name, "-p", "late:=1e3"])
for name, space in (("arm", "/"), ("arm", "/left"), ("hand", "/")):
    node = rclpy.create_node(name, namespace=space, automatically_declare_parameters_from_overrides=True)
    for parameter in ("speed", "joints", "gains.p", "gains.i", "flags", "side", "late"):
        if node.has_parameter(parameter):
            found = node.get_parameter(parameter)
            print(space, name, parameter, found.type_.name, found.value)
rclpy.shutdown()
for words in (["-p", "novalue"], ["-p", "a:=[1, b]"], ["-r", "x"], ["--params-file", "/nowhere.yaml"], ["--log-level", "LOUD"], ["--strange"]):
    try:
        rclpy.init(args=["program", "--ros-args", *words])
        print(words, "taken")
        rclpy.shutdown()
    except Exception as error:
        print(words, "refused")
