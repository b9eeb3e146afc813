import rclpy
from rclpy.duration import Duration
from rclpy.time import Time
a, b = Duration(seconds=1), Duration(seconds=2)
for name, do in (
    ("add", lambda: a + b), ("sub", lambda: b - a), ("mul", lambda: a * 2), ("rmul", lambda: 2 * a),
    ("neg", lambda: -a), ("abs", lambda: abs(a)), ("less", lambda: a < b), ("equal", lambda: a == b),
    ("div", lambda: a / 2), ("bool", lambda: bool(Duration())), ("hash", lambda: hash(a) is None),
    ("time", lambda: Time(seconds=3) + a), ("time-", lambda: Time(seconds=3) - Time(seconds=1)),
    ("sum", lambda: sum([a, b])), ("float", lambda: float(a)), ("text", lambda: str(a)),
):
    try:
        print(name, do())
    except Exception as error:
        print(name, type(error).__name__, error)
