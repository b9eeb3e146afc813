"""Clouds of points in Python: the module of ROS 1 and that of ROS 2."""

import math

PROGRAM = """
from {module} import point_cloud2 as clouds
from sensor_msgs.msg import PointField
from std_msgs.msg import Header
header = Header(frame_id="camera")
cloud = clouds.create_cloud_xyz32(header, [(1, 2, 3), (4.5, 5, float("nan")), (7, 8, 9)])
fields = [PointField(name="id", offset=0, datatype=PointField.UINT16, count=1),
          PointField(name="x", offset=4, datatype=PointField.FLOAT64, count=1)]
other = clouds.create_cloud(header, fields, [(3, 0.25), (65535, -1.5)])
whole = [tuple(point) for point in clouds.read_points(cloud, skip_nans=True)]
part = [tuple(point) for point in clouds.read_points(cloud, field_names=["z", "x"])]
chosen = [tuple(point) for point in clouds.read_points(cloud, ["x"], False, {chosen})]
named = clouds.read_points_list(other)
"""


def _hold(ran):
    assert ran["whole"] == [(1, 2, 3), (7, 8, 9)]
    assert ran["part"][0] == (3, 1)
    assert math.isnan(ran["part"][1][0])
    assert ran["chosen"] == [(7,), (1,)]
    assert [(each.id, each.x) for each in ran["named"]] == [(3, 0.25), (65535, -1.5)]
    cloud, other = ran["cloud"], ran["other"]
    assert (cloud.width, cloud.height, cloud.point_step, cloud.row_step) == (3, 1, 12, 36)
    assert (other.point_step, other.header.frame_id) == (12, "camera")


def test_points_are_written_and_read_as_in_ros_1(run_on):
    _hold(run_on("panda", PROGRAM.format(module="sensor_msgs", chosen="[(2, 0), (0, 0)]"), ros=1))


def test_points_are_written_and_read_as_in_ros_2(run_on):
    program = PROGRAM.format(module="sensor_msgs_py", chosen="[2, 0]")
    ran = run_on("panda", program + "array = clouds.read_points_numpy(cloud, ['y', 'x'])\n", ros=2)
    _hold(ran)
    assert ran["array"].tolist() == [[2, 1], [5, 4.5], [8, 7]]


def test_the_module_of_ros_1_is_not_in_ros_2(run_on):
    ran = run_on(
        "panda",
        "try:\n    import sensor_msgs.point_cloud2\nexcept ImportError as error:\n"
        "    told = str(error)\n",
        ros=2,
    )
    assert "sensor_msgs_py.point_cloud2" in ran["told"]
