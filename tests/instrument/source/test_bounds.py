"""Numbers and lengths with which a source goes on behind its checks."""

import pytest

from tracerisk.errors import Location
from tracerisk.instrument.source.literals.compared_values import compared_in_callback


def compared(tmp_path, *body: str):
    lines = ["Subscriber('/a', A, on_a)", "def on_a(msg):", *(f"    {line}" for line in body)]
    file = tmp_path / "node.py"
    file.write_text("\n".join([*lines, "    move(msg.data)", ""]))
    return compared_in_callback(Location(str(file), 1))


@pytest.mark.parametrize(
    ("body", "number"),
    [
        (["if not 0.02 <= msg.data <= 0.06:", "    return"], 0.04),
        (["if 0.02 < msg.data < 0.06:", "    go()"], 0.04),
        (["if msg.data < 1 or msg.data > 6:", "    log.error('no')", "    return"], 3),
        (["if msg.data > 0.02 and msg.data < 0.03:", "    go()"], 0.025),
        (["w = float(msg.data)", "if w < 0.0 or w > 0.05:", "    raise ValueError(w)"], 0.025),
        (["if msg.data < 5:", "    self.get_logger().warn('small')", "    return"], 6),
    ],
)
def test_a_number_is_one_that_the_check_lets_through(tmp_path, body, number):
    assert compared(tmp_path, *body).numbers(("data",))[0] == number


@pytest.mark.parametrize(
    ("body", "length", "least"),
    [
        (["if len(msg.data) != 7:", "    return"], 7, 0),
        (["q = np.asarray(msg.data).reshape(-1)", "if q.shape != (7,):", "    return"], 7, 0),
        (["if len(msg.data) < 3:", "    return"], None, 3),
        (["if len(msg.data) == 0:", "    return"], None, 1),
        (["if not msg.data:", "    return"], None, 1),
        (["if len(msg.data) >= 2:", "    go()"], None, 2),
        (["if len(msg.data) == 4 and ready:", "    go()"], 4, 0),
        (["if len(msg.data) == 0:", "    go()"], None, 0),
    ],
)
def test_a_list_is_as_long_as_the_check_asks(tmp_path, body, length, least):
    found = compared(tmp_path, *body)
    assert (found.length(("data",)), found.least(("data",))) == (length, least)


def test_a_number_for_which_a_branch_acts_is_no_refusal(tmp_path):
    found = compared(tmp_path, "if msg.data > 0.5:", "    arm.open()", "    return")
    assert found.numbers(("data",))[0] > 0.5
