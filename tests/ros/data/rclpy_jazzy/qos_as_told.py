import rclpy
from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    QoSPresetProfiles,
    ReliabilityPolicy,
    qos_check_compatible,
    qos_profile_parameters,
    qos_profile_sensor_data,
    qos_profile_services_default,
    qos_profile_system_default,
)
from sensor_msgs.msg import JointState

rclpy.init()
node = rclpy.create_node("n")
for name, profile in (
    ("sensor", qos_profile_sensor_data),
    ("services", qos_profile_services_default),
    ("parameters", qos_profile_parameters),
    ("system", qos_profile_system_default),
    ("depth", QoSProfile(depth=7)),
    ("latched", QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)),
    ("all", QoSProfile(history=HistoryPolicy.KEEP_ALL)),
):
    print(name, profile.depth, profile.history.name, profile.reliability.name, profile.durability.name, profile.liveliness.name)
try:
    QoSProfile()
except Exception as error:
    print(type(error).__name__, error)
try:
    QoSProfile(history=HistoryPolicy.KEEP_LAST)
except Exception as error:
    print(type(error).__name__, error)
try:
    node.create_publisher(JointState, "a", -1)
except Exception as error:
    print(type(error).__name__, error)
try:
    node.create_publisher(JointState, "a", "10")
except Exception as error:
    print(type(error).__name__, error)
print(QoSProfile(depth=3) == QoSProfile(depth=3), QoSProfile(depth=3) == QoSProfile(depth=4))
print(QoSPresetProfiles.SENSOR_DATA.value == qos_profile_sensor_data, QoSPresetProfiles.get_from_short_key("sensor_data") is not None)
print(ReliabilityPolicy.get_from_short_key("best_effort"), ReliabilityPolicy.BEST_EFFORT.short_key)
print(ReliabilityPolicy.short_keys())
print(sorted(DurabilityPolicy.short_keys()), sorted(LivelinessPolicy.short_keys()))
verdict, reason = qos_check_compatible(qos_profile_sensor_data, QoSProfile(depth=10))
print(verdict.name, reason)
verdict, reason = qos_check_compatible(QoSProfile(depth=10), qos_profile_sensor_data)
print(verdict.name, repr(reason))
verdict, reason = qos_check_compatible(QoSProfile(depth=10), QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, deadline=Duration(seconds=1)))
print(verdict.name, reason)
print(str(QoSProfile(depth=3)))
profile = QoSProfile(depth=5)
profile.reliability = ReliabilityPolicy.BEST_EFFORT
profile.deadline = Duration(seconds=0.5)
print(profile.reliability.name, profile.deadline.nanoseconds)
for name, value in (("depth", "a"), ("deadline", 1), ("reliability", 99), ("history", "x")):
    try:
        setattr(profile, name, value)
        print(name, "taken")
    except Exception as error:
        print(name, type(error).__name__)
