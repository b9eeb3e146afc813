import os, signal, threading, time
import rclpy
rclpy.init()
node = rclpy.create_node("n")
signal.signal(signal.SIGINT, lambda number, frame: print("handler", number))
def stop():
    time.sleep(0.5)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=stop, daemon=True).start()
try:
    rclpy.spin_once(node, timeout_sec=1.5)
    print("spun")
except BaseException as error:
    print("spin_once raised", type(error).__name__, error)
print("ok", rclpy.ok())
