import rclpy
rclpy.init()
node = rclpy.create_node("n")
for name, make in (
    ("timer", lambda: node.create_timer(0.05, None)),
    ("guard", lambda: node.create_guard_condition(None)),
    ("number", lambda: node.create_timer(0.05, 5)),
):
    made = make()
    if name == "guard":
        made.trigger()
    try:
        for turn in range(3):
            rclpy.spin_once(node, timeout_sec=0.2)
        print(name, "goes on")
    except Exception as error:
        print(name, turn, type(error).__name__, error)
    made.destroy()
