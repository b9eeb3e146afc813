import os, signal, threading, time
import rclpy
signal.signal(signal.SIGINT, lambda number, frame: print("handler", number))
rclpy.init()
node = rclpy.create_node("n")
def stop():
    time.sleep(0.5)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=stop, daemon=True).start()
try:
    rclpy.spin(node)
    print("spin returned")
except BaseException as error:
    print("spin raised", type(error).__name__, error)
print("ok", rclpy.ok())
