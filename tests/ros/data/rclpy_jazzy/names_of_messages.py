import rclpy
print(__import__("std_msgs.msg", fromlist=["msg"]).__name__)
print(__import__("std_msgs.msg", fromlist=["String"]).String.__name__)
print(__import__("std_msgs.msg").__name__)
import std_msgs.msg
try:
    std_msgs.msg.Strin
except AttributeError as error:
    print("AttributeError")
try:
    from std_msgs.msg import Strin
except ImportError:
    print("ImportError")
