"""Numbers for a question whose answer the code takes apart."""

import pytest

from tracerisk.errors import Location
from tracerisk.ros.drafts.answers.split_answers import numbers_answer
from tracerisk.ros.drafts.asked_results import compared_results
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.robots.robot import load_robot


@pytest.fixture
def answer(tmp_path):
    robot = load_robot("panda")
    pose = Pose((0.4, 0.0, 0.3), (1.0, 0.0, 0.0, 0.0))
    values = UsableValues(robot, lambda *_: pose, lambda *_: {})

    def answer(source: str, line: int = 1) -> str | None:
        file = tmp_path / "c.py"
        file.write_text(source)
        return numbers_answer(Location(str(file), line), values)

    return answer


@pytest.mark.parametrize(
    ("source", "numbers"),
    [
        ("x, y, z = map(float, input('p ').split())\n", 3),
        ("a = [float(v) for v in input('p ').split(',')]\nif len(a) != 3: pass\n", 3),
        ("raw = input('p ').strip()\np = raw.split()\nx = float(p[0])\ny = float(p[1])\n", 2),
        ("raw = input('p ')\na = [float(v) for v in raw.split()]\n", 7),
        ("a = tuple(int(v) for v in input('p ').split())\nif len(a) == 4: pass\n", 4),
    ],
)
def test_as_many_numbers_are_given_as_the_code_wants(answer, source, numbers):
    found = answer(source)
    texts = found.replace(",", " ").split()
    assert len(texts) == numbers
    assert ("," in found) == ("','" in source)
    assert all(each.lstrip("-").isdigit() for each in texts) == ("int(" in source)


@pytest.mark.parametrize(
    "source", ["name = input('n ')\n", "words = input('n ').split()\n", "a = float(input('n '))\n"]
)
def test_an_answer_that_is_not_taken_apart_into_numbers_gets_none(answer, source):
    assert answer(source) is None


def test_a_name_of_another_loop_is_another_answer(answer):
    source = (
        "while True:\n    raw = input('speed ')\n    break\n"
        "while True:\n    raw = input('joints ')\n    a = [float(v) for v in raw.split()]\n"
    )
    assert answer(source, 2) is None
    assert len(answer(source, 5).split()) == 7


@pytest.mark.parametrize(
    ("guard", "number"),
    [("if n <= 0: continue", 1), ("if n <= 0: raise ValueError", 1), ("if n <= 0: print()", -1)],
)
def test_a_number_that_is_turned_away_is_no_answer(tmp_path, guard, number):
    file = tmp_path / "c.py"
    file.write_text(f"while True:\n    n = int(input('how many '))\n    {guard}\n")
    assert compared_results(Location(str(file), 2), "input") == (number,)
