"""Drafted lists of numbers are as long as the code reads them, and hold what it compares."""

import pytest

from tests.ros.drafts.test_guards import values  # noqa: F401
from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.messages.ros2 import Interfaces2

HEAD = """\
class Cell(Node):
    def __init__(self):
        self.create_subscription(Float32MultiArray, "/seen", self.on_seen, 10)
        self.create_service(Place, "/place", self.on_place)

"""
SEEN = {
    "compared": (
        "if len(msg.data) < 4:\n    return\nself.seen = msg.data[0] >= 0.5\n"
        "self.x = float(msg.data[1])\n",
        [0.6, 0.5, 0.5, 0.5],
    ),
    "handed on": (
        "values = list(msg.data)\nif abs(values[1]) > 2.0:\n    self.turn(values[2])\n",
        [0.5, 2.2, 0.5],
    ),
    "refused": ("if msg.data[4] < 0.8:\n    return\nself.go(msg.data[0])\n", [0.5] * 4 + [0.9]),
}
PLACES = {
    "each": "point = [request.numbers[0], request.numbers[1], request.numbers[2]]\n",
    "a part": "self.go(request.numbers[:3])\n",
    "taken apart": "x, y, z = request.numbers\n",
}


def indented(lines):
    return "".join(f"        {line}\n" for line in lines.splitlines())


def drafted(folder, source, need):
    (folder / "cell" / "srv").mkdir(parents=True)
    (folder / "cell" / "srv" / "Place.srv").write_text("float32[] numbers\n---\nbool ok\n")
    file = folder / "node.py"
    file.write_text(source)
    line = next(at for at, text in enumerate(source.splitlines(), 1) if f'"{need.name}"' in text)
    return Missed(need, 0, 0, Location(str(file), line)), Interfaces2(
        workspace={"cell": folder / "cell"}
    )


@pytest.mark.parametrize("kind", SEEN)
def test_a_number_that_is_compared_by_its_index_passes(tmp_path, values, kind):  # noqa: F811
    body, wanted = SEEN[kind]
    source = HEAD + "    def on_seen(self, msg):\n" + indented(body)
    need = Need("topic", "/seen", "std_msgs/Float32MultiArray")
    missed, interfaces = drafted(tmp_path, source, need)
    (draft,) = drafts([missed], interfaces, values)
    assert draft.value["message"]["data"] == pytest.approx(wanted)


@pytest.mark.parametrize("kind", PLACES)
def test_three_numbers_that_say_nothing_are_a_place(tmp_path, values, kind):  # noqa: F811
    source = HEAD + "    def on_place(self, request, response):\n" + indented(PLACES[kind])
    missed, interfaces = drafted(tmp_path, source, Need("call", "/place", "cell/Place"))
    (draft,) = drafts([missed], interfaces, values)
    assert draft.value["request"]["numbers"] == pytest.approx(values.pose.position)


SHAPED = {
    "rows": (
        "places = np.array(request.numbers).reshape((-1, 3))\n"
        "scores = np.array(request.scores).reshape((-1))\n",
        3,
        1,
    ),
    "rows beside an indexed list": (
        "places = np.array(request.numbers).reshape((-1, 3))\nlast = request.scores[2]\n",
        3,
        3,
    ),
    "rows of which one is indexed": (
        "places = np.array(request.numbers).reshape((-1, 3))\nlast = request.numbers[4]\n",
        6,
        1,
    ),
    "a table": ("places = np.reshape(request.numbers, (2, 4))\n", 8, 0),
    "a field called rows": ("if request.rows == 4:\n    pass\n", 0, 0),
    "a flat list": ("places = np.array(request.numbers).reshape(-1)\n", 0, 0),
}


@pytest.mark.parametrize("kind", SHAPED)
def test_a_list_has_the_shape_that_the_code_gives_it(tmp_path, values, kind):  # noqa: F811
    body, *lengths = SHAPED[kind]
    source = HEAD + "    def on_place(self, request, response):\n" + indented(body)
    missed, interfaces = drafted(tmp_path, source, Need("call", "/place", "cell/Place"))
    path = tmp_path / "cell" / "srv" / "Place.srv"
    path.write_text("float32[] numbers\nfloat32[] scores\nint32 rows\n---\nbool ok\n")
    (draft,) = drafts([missed], interfaces, values)
    request = draft.value["request"]
    assert [len(request["numbers"]), len(request["scores"])] == lengths


NAMED = {
    "a pose by its topic": ("/euler_pos", 6),
    "joints by their topic": ("/joint_cmd", None),
}


@pytest.mark.parametrize("kind", NAMED)
def test_plain_data_are_what_their_topic_is_called(tmp_path, values, kind):  # noqa: F811
    topic, count = NAMED[kind]
    source = HEAD.replace("/seen", topic) + "    def on_seen(self, msg):\n        print(msg)\n"
    need = Need("topic", topic, "std_msgs/Float32MultiArray")
    missed, interfaces = drafted(tmp_path, source, need)
    (draft,) = drafts([missed], interfaces, values)
    data = draft.value["message"]["data"]
    if count is None:
        assert data == pytest.approx(values.posture)
    else:
        assert data[:3] == pytest.approx(values.pose.position)
        assert len(data) == count
