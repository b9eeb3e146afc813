import rclpy
import threading
import time
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rclpy.wait_for_message import wait_for_message
from sensor_msgs.msg import JointState
from std_msgs.msg import String

rclpy.init()
driver = rclpy.create_node("driver")
controller = rclpy.create_node("controller")
publisher = driver.create_publisher(JointState, "joint_states", 10)
found, message = wait_for_message(JointState, controller, "joint_states", time_to_wait=0.3)
print(found, message, controller.count_subscribers("joint_states"))

running = True


def publish():
    number = 0
    while running:
        number += 1
        publisher.publish(JointState(name=["a"], position=[0.1]))
        time.sleep(0.1)


thread = threading.Thread(target=publish)
thread.start()
for qos in (1, 10, qos_profile_sensor_data):
    found, message = wait_for_message(JointState, controller, "joint_states", qos_profile=qos, time_to_wait=5.0)
    print(found, list(message.name), list(message.position), controller.count_subscribers("joint_states"))
found, message = wait_for_message(JointState, controller, "/joint_states", time_to_wait=-1)
print(found, list(message.name))
found, message = wait_for_message(JointState, controller, "joint_states", qos_profile=QoSProfile(
    depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL), time_to_wait=0.5)
print("latched wanted", found, message)
running = False
thread.join()

latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
text = driver.create_publisher(String, "robot_description", latched)
text.publish(String(data="<robot/>"))
print(*wait_for_message(String, controller, "robot_description", qos_profile=latched, time_to_wait=3.0))
print(*wait_for_message(String, controller, "robot_description", time_to_wait=0.5))
got = []
controller.create_subscription(String, "robot_description", lambda message: got.append(message.data), latched)
print(*wait_for_message(String, controller, "robot_description", qos_profile=latched, time_to_wait=3.0), got)
rclpy.spin_once(controller, timeout_sec=1.0)
print(got)
for words, arguments in (("wrong node", (String, None, "x")), ("wrong name", (String, controller, "a b"))):
    try:
        print(wait_for_message(*arguments, time_to_wait=0.2))
    except Exception as error:
        print(words, type(error).__name__)
rclpy.shutdown()
