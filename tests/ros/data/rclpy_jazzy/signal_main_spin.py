import os, signal, threading, time
import rclpy
rclpy.init()
node = rclpy.create_node("n")
def stop():
    time.sleep(1.0)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=stop, daemon=True).start()
try:
    rclpy.spin(node)
    print("spin returned")
except BaseException as error:
    print("spin raised", type(error).__name__, error)
print("ok", rclpy.ok())
try:
    node.destroy_node()
    rclpy.shutdown()
    print("shut down")
except BaseException as error:
    print("shutdown raised", type(error).__name__, str(error).split(", at")[0])
