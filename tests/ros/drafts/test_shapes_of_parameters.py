"""A drafted parameter has the shape in which the code uses it, whatever its name."""

import pytest

from tests.ros.drafts.test_guards import values  # noqa: F401
from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.messages.ros2 import Interfaces2

SOURCE = """\
class Cell:
    def __init__(self):
        self.rest = rospy.get_param("~rest")

    def work(self):
        {use}
"""


@pytest.mark.parametrize(
    ("use", "shape"),
    [
        ("self.arm.go(self.rest, wait=True)", "joints"),
        ("for i, q in enumerate(self.rest): self.arm.go(q)", "list of joints"),
        ("for word in self.rest: print(word)", "list"),
        ("goal = (self.rest['x'], self.rest['z'])", "mapping"),
        ("x = self.rest[0]", ""),
        ("x = self.rest[0]\n        self.arm.go(x)", ""),
    ],
)
def test_what_takes_a_parameter_says_its_shape(tmp_path, values, use, shape):  # noqa: F811
    file = tmp_path / "node.py"
    file.write_text(SOURCE.format(use=use))
    missed = Missed(Need("parameter", "/cell/rest"), 0, 0, Location(str(file), 3))
    (draft,) = drafts([missed], Interfaces2(), values)
    x, _, z = values.pose.position
    posture = list(values.posture)
    wanted = {
        "joints": posture,
        "list of joints": [posture],
        "list": [0.1],
        "mapping": {"x": x, "z": z},
        "": 1,
    }
    assert draft.value == wanted[shape]
