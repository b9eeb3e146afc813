import os, signal, threading, time
import rclpy
rclpy.init()
node = rclpy.create_node("n")
def spin():
    try:
        rclpy.spin(node)
        print("spin returned", flush=True)
    except BaseException as error:
        print("spin raised", type(error).__name__, error, flush=True)
t = threading.Thread(target=spin); t.start()
time.sleep(1.0)
try:
    signal.raise_signal(signal.SIGINT)
    time.sleep(1.0)
    print("went on", flush=True)
except KeyboardInterrupt:
    print("KeyboardInterrupt", flush=True)
t.join(2.0)
print("alive", t.is_alive(), "ok", rclpy.ok(), flush=True)
