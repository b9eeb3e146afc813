import rclpy
from rclpy.clock import ClockChange, JumpThreshold, ROSClock
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from rclpy.time import Time
from rclpy.time_source import TimeSource
from rosgraph_msgs.msg import Clock

rclpy.init()
server = rclpy.create_node("server")
publisher = server.create_publisher(Clock, "/clock", 10)
node = rclpy.create_node("n")
clock = ROSClock()
source = TimeSource(node=node)
source.attach_clock(clock)
jumps = []
handle = clock.create_jump_callback(
    JumpThreshold(min_forward=Duration(seconds=5), min_backward=Duration(nanoseconds=-1), on_clock_change=True),
    pre_callback=lambda: jumps.append("pre"),
    post_callback=lambda jump: jumps.append((jump.clock_change.name, jump.delta.nanoseconds // 10**9)),
)
print(clock.ros_time_is_active, source.ros_time_is_active)
source.ros_time_is_active = True
print(clock.ros_time_is_active, clock.now())
while publisher.get_subscription_count() == 0:
    rclpy.spin_once(node, timeout_sec=0.05)
for second in (1, 2, 3, 10, 4):
    publisher.publish(Clock(clock=Time(seconds=second).to_msg()))
    for _ in range(100):
        rclpy.spin_once(node, timeout_sec=0.02)
        if clock.now().seconds_nanoseconds()[0] == second:
            break
    print("time", clock.now().seconds_nanoseconds())
print(jumps[:1], jumps[2:])
source.ros_time_is_active = False
print(clock.ros_time_is_active, clock.now().nanoseconds > 10**9)
print(jumps[-1][0], ClockChange.ROS_TIME_DEACTIVATED.name)
handle.unregister()
clock.set_ros_time_override(Time(seconds=5, clock_type=clock.clock_type))
source.detach_node()
for do in (
    lambda: JumpThreshold(min_forward=Duration(seconds=-1), min_backward=None),
    lambda: JumpThreshold(min_forward=None, min_backward=Duration(seconds=1)),
    lambda: source.attach_clock(rclpy.clock.Clock()),
    lambda: source.attach_node(3),
    lambda: clock.set_ros_time_override(5),
    lambda: clock.create_jump_callback(JumpThreshold(min_forward=None, min_backward=None)),
):
    try:
        print(do())
    except Exception as error:
        print(type(error).__name__, error)
