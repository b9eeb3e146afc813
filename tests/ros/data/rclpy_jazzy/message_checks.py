import numpy as np
from geometry_msgs.msg import PoseStamped, PoseWithCovariance
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64, Int32, String, UInt8
from rclpy.time import Time
def tried(name, do):
    try:
        print(name, do())
    except Exception as error:
        print(name, type(error).__name__, error)
def put(made, field, value):
    setattr(made, field, value)
    return getattr(made, field)
tried("int in float", lambda: put(Float64(), "data", 1))
tried("text in int", lambda: put(Int32(), "data", "1"))
tried("none in text", lambda: put(String(), "data", None))
tried("int in bool", lambda: put(Bool(), "data", 2))
tried("too large", lambda: put(UInt8(), "data", 300))
tried("floats", lambda: list(put(JointState(), "position", [0, 1.5])))
tried("array", lambda: list(put(JointState(), "position", np.array([1, 2]))))
tried("text as floats", lambda: put(JointState(), "position", "abc"))
tried("none as floats", lambda: put(JointState(), "position", None))
tried("one as floats", lambda: put(JointState(), "position", 1.0))
tried("texts as floats", lambda: put(JointState(), "position", ["a"]))
tried("one name", lambda: put(JointState(), "name", "abc"))
tried("covariance", lambda: len(put(PoseWithCovariance(), "covariance", [0.0] * 3)))
tried("covariance of text", lambda: put(PoseWithCovariance(), "covariance", ["a"] * 36))
tried("stamp", lambda: type(put(PoseStamped().header, "stamp", Time(seconds=1))).__name__)
tried("keyword", lambda: Float64(dat=1.0))
tried("keyword int", lambda: Float64(data=1).data)
tried("checked", lambda: Float64(data=1, check_fields=True))
tried("attribute", lambda: put(Float64(), "dat", 1.0))
