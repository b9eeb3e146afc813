"""Messages and services of ROS 1 have the sums that real nodes compare when they connect.

`data/public_md5sums.csv` holds each sum with its source:
`debian`: `_md5sum` of the classes that Debian 12 has generated (python3-std-msgs 0.5.13,
python3-geometry-msgs and its neighbours 1.13.1, python3-actionlib 1.14.0, python3-tf2-msgs 0.7.6,
python3-move-base-msgs 1.14.1, python3-dynamic-reconfigure 1.7.3, python3-roscpp-msg 1.15.15);
`genmsg`: what genmsg 0.6 of Debian 12 computes of the public texts (moveit_msgs 851fe626,
control_msgs 36e2e305, ros_control 633c3746);
`rosserial`: `getMD5` of the headers that rosserial has generated in jgdo/arips_arm (edb1e0a4).
"""

import csv
from pathlib import Path

import pytest

from tracerisk.ros.messages.ros1 import Interfaces

TABLE = Path(__file__).parents[1] / "data" / "public_md5sums.csv"


def _public() -> dict[str, list[tuple[str, str]]]:
    packages: dict[str, list[tuple[str, str]]] = {}
    with TABLE.open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            packages.setdefault(row["type"].split("/")[0], []).append((row["type"], row["md5sum"]))
    return packages


@pytest.mark.parametrize(("package", "sums"), _public().items(), ids=_public())
def test_the_md5_sums_of_a_package_are_the_public_ones(package, sums):
    interfaces = Interfaces()
    ours = {name: interfaces.interface(*name.split("/"))._md5sum for name, _ in sums}
    assert ours == dict(sums), package
