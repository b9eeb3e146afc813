import os, signal, threading, time
import rclpy
rclpy.init()
node = rclpy.create_node("n")
def stop():
    time.sleep(0.5)
    os.kill(os.getpid(), signal.SIGTERM)
threading.Thread(target=stop, daemon=True).start()
try:
    rclpy.spin(node)
    print("spin returned")
except BaseException as error:
    print("spin raised", type(error).__name__, error)
print("ok", rclpy.ok())
