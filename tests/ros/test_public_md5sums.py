"""Messages and services of ROS 1 have the sums that real nodes compare when they connect.

`data/public_md5sums.csv` holds what the generated classes of Debian 12's packages say of
themselves (python3-std-msgs 0.5.13, python3-geometry-msgs and its neighbours 1.13.1,
python3-actionlib 1.14.0, python3-tf2-msgs 0.7.6 and others), as `_md5sum`.
"""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from tracerisk.ros.messages.ros1 import Interfaces

TABLE = Path(__file__).parent / "data" / "public_md5sums.csv"


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
