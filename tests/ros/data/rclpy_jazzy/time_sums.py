import rclpy
from builtin_interfaces.msg import Duration as DurationMsg, Time as TimeMsg
from rclpy.clock import Clock, ClockType, ROSClock
from rclpy.duration import Duration, Infinite
from rclpy.time import Time

rclpy.init()
node = rclpy.create_node("n")
a, b = Time(seconds=3, nanoseconds=500), Time(seconds=1)
print(a, b, a - b, a + Duration(seconds=0.5), a - Duration(seconds=1))
print(a > b, a == Time(seconds=3, nanoseconds=500), a != b, a.seconds_nanoseconds(), a.nanoseconds, int(a.clock_type))
print(a.to_msg(), Time.from_msg(TimeMsg(sec=4, nanosec=7)), Time.from_msg(a.to_msg(), clock_type=ClockType.SYSTEM_TIME).clock_type == ClockType.SYSTEM_TIME)
print(Duration(seconds=1.5).to_msg(), Duration.from_msg(DurationMsg(sec=-1, nanosec=500000000)).nanoseconds, Duration(seconds=-0.25))
print(Duration(seconds=2) > Duration(nanoseconds=5), Duration(seconds=1) == Duration(nanoseconds=10**9), Infinite)
for do in (
    lambda: a - Time(clock_type=ClockType.ROS_TIME),
    lambda: a < Time(clock_type=ClockType.ROS_TIME),
    lambda: a == Time(clock_type=ClockType.ROS_TIME),
    lambda: a + 1,
    lambda: Time(seconds=-1),
    lambda: Time(nanoseconds=2**63),
    lambda: Duration(nanoseconds=2**63),
    lambda: a - 1.0,
    lambda: Duration(seconds=1) < 1,
    lambda: Time(seconds=1, clock_type="ros"),
    lambda: b - Duration(seconds=2),
    lambda: Duration(seconds=1) == 1,
    lambda: Time.from_msg(3),
    lambda: hash(a),
):
    try:
        result = do()
        print("a hash" if isinstance(result, int) and not isinstance(result, bool) else result)
    except Exception as error:
        print(type(error).__name__, error)
print(int(Clock().clock_type), int(ROSClock().clock_type), int(node.get_clock().clock_type), Clock(clock_type=ClockType.STEADY_TIME))
print(ROSClock().ros_time_is_active, type(ROSClock()).__name__, int(node.get_clock().now().clock_type))
print(repr(Duration(seconds=1)), repr(Time()))
