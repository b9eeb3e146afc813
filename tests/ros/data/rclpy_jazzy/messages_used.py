import copy
from array import array
import numpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from sensor_msgs.msg import JointState
from std_msgs.msg import ColorRGBA, Float64MultiArray, Header, String, UInt8MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from geometry_msgs.msg import PoseWithCovariance

pose = Pose()
print(pose)
print(pose.orientation.w, Quaternion().w, Pose() == Pose(), Pose(position=Point(x=1.0)) == Pose())
print(repr(Point(x=1.5, y=-0.0, z=1e-9)))
print(str(Header(stamp=Time(sec=1, nanosec=2), frame_id="base")))
state = JointState(name=["a", "b"], position=[0.1, 0.2])
print(type(state.position).__name__, state.position, state.velocity, state.name)
state.position = (1.0, 2.0)
print(state.position)
state.position = numpy.array([3.0, 4.0])
print(state.position, type(state.position).__name__)
state.position.append(5.0)
print(list(state.position))
print(type(PoseWithCovariance().covariance).__name__, PoseWithCovariance().covariance.shape)
point = JointTrajectoryPoint(positions=[1.0])
print(point.time_from_start, point.positions)
trajectory = JointTrajectory(joint_names=("a",), points=[point])
print(len(trajectory.points), trajectory.points[0] is point, type(trajectory.joint_names).__name__)
print(UInt8MultiArray(data=b"\x01\x02").data, UInt8MultiArray(data=[3]).data)
print(Float64MultiArray(data=range(0)).data, Float64MultiArray().layout)
print(copy.deepcopy(pose) == pose, copy.copy(pose).position is pose.position)
print(PoseStamped.get_fields_and_field_types())
print(ColorRGBA(r=0.1).r, float(numpy.float32(0.1)))
print(JointState.get_fields_and_field_types()["position"], sorted(Time.get_fields_and_field_types()))
for do in (
    lambda: setattr(pose, "nothing", 1),
    lambda: pose.nothing,
    lambda: JointState(position=[1]).position,
    lambda: JointState(position=array("d", [1.0])).position,
    lambda: {pose: 1},
    lambda: pose < Pose(),
):
    try:
        print(do())
    except Exception as error:
        print(type(error).__name__, error)
