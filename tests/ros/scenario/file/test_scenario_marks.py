"""The mark of what nobody has confirmed: where it counts, and where it is part of a text."""

import pytest

from tracerisk.errors import ScenarioError
from tracerisk.ros.scenario.file.scenario_reader import read_scenario


def read(tmp_path, text: str):
    path = tmp_path / "s.yaml"
    path.write_bytes(text.encode())
    return read_scenario(path)


MARKED = """\
robot: panda  # assumed: one of several
arguments:
  - --left
parameters:
  /a: 1  # assumed: from a.yaml:3
  /b: 2
publish:
  - topic: /one
    type: std_msgs/String
    message:
      data: x  # assumed
  - topic: /two
    type: std_msgs/String
"""


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_each_entry_with_a_mark_is_reported_once_with_its_line(tmp_path, newline):
    scenario = read(tmp_path, MARKED.replace("\n", newline))
    reported = [(each.section, each.name, each.words) for each in scenario.unconfirmed]
    assert reported == [
        ("robot", "robot", "one of several"),
        ("parameters", "/a", "from a.yaml:3"),
        ("publish", "/one", ""),
    ]
    assert [each.location.line for each in scenario.unconfirmed] == [1, 5, 11]
    assert (scenario.robot, scenario.arguments) == ("panda", ("--left",))


def test_deleting_the_mark_confirms_the_entry(tmp_path):
    assert read(tmp_path, MARKED.replace("# assumed", "# seen")).unconfirmed == ()


@pytest.mark.parametrize(
    "text",
    [
        "answers: ['a # assumed b']\n",
        'answers: ["a # assumed: b"]\n',
        "parameters:\n  /text: |\n    first\n    # assumed: of a text\n",
        "answers: [a#assumed]\n",
        "answers: [a]  # as is assumed\n",
    ],
)
def test_what_stands_within_a_text_is_no_mark(tmp_path, text):
    assert read(tmp_path, text).unconfirmed == ()


def test_comments_alone_are_a_scenario_that_gives_nothing(tmp_path):
    scenario = read(tmp_path, "# nothing\n\n# assumed: nothing either\n")
    assert (scenario.published, scenario.unconfirmed) == ((), ())


def test_a_robot_that_is_a_file_is_named_from_the_scenarios_folder(tmp_path):
    assert read(tmp_path, "robot: my.urdf\n").robot == str(tmp_path / "my.urdf")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("robot: [a]\n", "s.yaml:1:1: robot: expected a string, found a list"),
        ("arguments: --left\n", "s.yaml:1:1: arguments: expected a list"),
        ("arguments: [true]\n", "arguments: expected strings or numbers, found True"),
        ("", "expected a mapping at the top, found nothing"),
    ],
)
def test_what_is_not_allowed_is_reported_with_its_place(tmp_path, text, expected):
    with pytest.raises(ScenarioError) as caught:
        read(tmp_path, text)
    assert expected in str(caught.value).replace(str(tmp_path) + "/", "")
