import rclpy
rclpy.init()
log = rclpy.create_node("n").get_logger()
for given in ("text", b"bytes", None, 5, 1.5, ValueError("x"), ["a"], "a\0b", "\udc80", "é"):
    try:
        print(type(given).__name__, log.info(given))
    except Exception as error:
        print(type(given).__name__, type(error).__name__, str(error).split(":")[0])
log.set_level(rclpy.logging.LoggingSeverity.ERROR)
print("below the level", log.info(5))
