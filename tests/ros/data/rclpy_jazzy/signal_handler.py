import os, signal, threading, time
import rclpy
from rclpy.signals import SignalHandlerOptions
rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node("n")
node.create_timer(0.2, lambda: print("tick"))
def stop():
    time.sleep(0.5)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=stop, daemon=True).start()
try:
    rclpy.spin(node)
except BaseException as error:
    print("spin raised", type(error).__name__, error)
print("ok", rclpy.ok())
