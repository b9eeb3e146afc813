"""ros_numpy and ros2_numpy: there and back again."""

import numpy as np
import pytest

PROGRAM = """
import numpy as np
import {0} as rn
from geometry_msgs.msg import Point, Pose, Quaternion, Transform, Vector3
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import Image, PointCloud2
pose = Pose(position=Point(x=1.0, y=2.0, z=3.0), orientation=Quaternion(x=0.0, y=0.0, z=1.0, w=0.0))
matrix = rn.numpify(pose)
back = rn.msgify(Pose, matrix)
many = rn.msgify(Transform, np.stack([matrix, matrix]))
homogeneous = rn.numpify(Vector3(x=1.0), hom=True)
picture = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
image = rn.msgify(Image, picture, 'rgb8')
again = rn.numpify(image)
points = np.zeros(3, dtype=[('x', np.float32), ('y', np.float32), ('z', np.float32), ('rgb', np.float32)])
points['x'] = [1, 2, np.nan]
cloud = rn.point_cloud2.array_to_pointcloud2(points, frame_id='camera')
xyz = rn.point_cloud2.pointcloud2_to_xyz_array(cloud)
split = rn.point_cloud2.split_rgb_field(rn.numpify(cloud))
merged = rn.point_cloud2.merge_rgb_fields(split)
grid = rn.msgify(OccupancyGrid, np.array([[0, -1], [100, 5]], dtype=np.int8))
cells = rn.numpify(grid)
told = []
for bad in (lambda: rn.numpify(3), lambda: rn.numpify([]), lambda: rn.msgify(Image, picture, 'mono8')):
    try:
        bad()
    except (ValueError, TypeError) as error:
        told.append(str(error))
"""


@pytest.mark.parametrize(("ros", "library"), [(1, "ros_numpy"), (2, "ros2_numpy")])
def test_messages_are_made_into_arrays_and_back(run_on, ros, library):
    ran = run_on("wx250s", PROGRAM.format(library), ros=ros)
    assert ran["matrix"][:3, 3].tolist() == [1.0, 2.0, 3.0]
    assert ran["matrix"][0, 0] == pytest.approx(-1.0)
    assert ran["back"].position.y == 2.0
    assert abs(ran["back"].orientation.z) == pytest.approx(1.0)
    assert len(ran["many"]) == 2
    assert ran["homogeneous"].tolist() == [1.0, 0.0, 0.0, 0.0]
    assert (ran["again"] == ran["picture"]).all()
    assert ran["image"].step == 12
    assert ran["xyz"].tolist() == [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]
    assert set(ran["split"].dtype.names) == {"x", "y", "z", "r", "g", "b"}
    assert (ran["merged"]["rgb"] == ran["points"]["rgb"]).all()
    assert ran["cells"].mask.tolist() == [[False, True], [False, False]]
    assert isinstance(ran["cells"], np.ma.MaskedArray)
    assert "Unable to convert message int" in ran["told"][0]
    assert "empty Collection" in ran["told"][1]
    assert "mono8 requires 1" in ran["told"][2]
