import os, signal, threading, time
import rclpy
rclpy.init()
node = rclpy.create_node("n")
def tick():
    print("tick")
    os.kill(os.getpid(), signal.SIGINT)
    print("after")
node.create_timer(0.2, tick)
try:
    rclpy.spin(node)
except BaseException as error:
    print("spin raised", type(error).__name__, error)
print("ok", rclpy.ok())
