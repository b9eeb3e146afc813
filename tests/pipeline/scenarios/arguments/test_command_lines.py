"""The command lines that a source takes, read without running it."""

import pytest

from tracerisk.errors import Location
from tracerisk.pipeline.scenarios.arguments.command_line import reads_arguments
from tracerisk.pipeline.scenarios.arguments.command_lines import command_lines
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.ros.drafts.named_numbers import Reach
from tracerisk.trace import RunEnd


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("p.add_argument('side', choices=['left', 'right'])\n", [("left",)]),
        (
            "p.add_argument('--count', type=int, required=True)\np.add_argument('file')\n",
            [("--count", "1", "file")],
        ),
        ("p.add_argument('xyz', type=float, nargs=3)\n", [("0.1", "0.1", "0.1")]),
        ("p.add_argument('--speed', type=float, default=0.5)\n", []),
        ("p.add_argument('side', nargs='?')\n", []),
        (
            "p.add_argument('-m', '--move', action='store_true')\n"
            "p.add_argument('--turn', action='store_true')\n",
            [("--move",), ("--turn",)],
        ),
        (
            "g = p.add_mutually_exclusive_group(required=True)\n"
            "g.add_argument('--a', action='store_true')\ng.add_argument('--b', action='store_true')\n",
            [("--a",), ("--a", "--b")],
        ),
        (
            "if sys.argv[1] == 'open': pass\nelif sys.argv[1] == 'close': pass\n",
            [("open",), ("close",)],
        ),
        ("x = float(sys.argv[1])\ny = float(sys.argv[2])\n", [("1", "1")]),
        (
            "def parse(args):\n    if args[0] == 'init': pass\n    return float(args[1])\n"
            "def main(argv):\n    parse(argv)\nmain(sys.argv[1:])\n",
            [("init", "1")],
        ),
        ("args = sys.argv[1:]\nif args[0] == 'open': pass\n", [("open",)]),
        (
            "class Node:\n    def go(self, words):\n        rest = words[1:]\n"
            "        if rest[0] == 'left': pass\n"
            "Node().go(words=rospy.myargv(argv=sys.argv))\n",
            [("left",)],
        ),
        ("p.add_argument('mode', type=int, default=0)\n", [("0",)]),
        ("p.add_argument('arm', default='left', choices=['left', 'right'])\n", [("left",)]),
        ("p.add_argument('q', nargs=2, type=float, default=0.5)\n", [("0.5", "0.5")]),
        ("p.add_argument('mode', nargs='?', default='home')\n", []),
        ("def other(args):\n    return args[0] == 'init'\nother(['init'])\n", []),
        ("print('no arguments')\n", []),
        # None where they are not given.
        (
            "p.add_argument('-a', '--angles', type=float, nargs=2)\np.add_argument('--name')\n",
            [("--angles", "0.1", "0.1")],
        ),
        # Keys of a table of the source.
        (
            "PLACES = {'home': 1, 'bin': 2}\nname = sys.argv[1]\nif name in PLACES: pass\n",
            [("home",), ("bin",)],
        ),
        ("PLACES = {'home': 1, 'bin': 2}\ngo(PLACES[sys.argv[1]])\n", [("home",), ("bin",)]),
    ],
)
def test_command_lines(tmp_path, source, words):
    (tmp_path / "c.py").write_text(f"import rospy, sys, argparse\n{source}")
    found = command_lines(load_controller(tmp_path / "c.py"))
    assert [each.words for each in found] == words


def test_an_option_that_is_not_given_is_what_a_run_lacks_wherever_none_is_used(tmp_path):
    parsed = "import argparse, rospy\np.add_argument('--q', type=float, nargs=2)\nlen(goal)\n"
    (tmp_path / "c.py").write_text(parsed)
    (tmp_path / "d.py").write_text("import rospy\n\nlen(goal)\n")
    for name, message, reads in (
        ("c.py", "TypeError: object of type 'NoneType' has no len()", True),
        ("c.py", "ValueError: no goal", False),
        ("d.py", "TypeError: object of type 'NoneType' has no len()", False),
    ):
        end = RunEnd("raised", message, 0.0, Location(name, 3))
        assert reads_arguments(load_controller(tmp_path / name), end) is reads


def test_command_lines_that_the_repository_writes_come_first(tmp_path):
    (tmp_path / "c.py").write_text("import rospy\np.add_argument('side')\n")
    found = command_lines(load_controller(tmp_path / "c.py"), [(("left",), "README.md:3")])
    assert [(each.words, each.remark) for each in found] == [
        (("left",), "as in README.md:3"),
        (("side",), "what argparse demands"),
    ]


READS_FILE = """\
import argparse, rospy
p = argparse.ArgumentParser()
p.add_argument('-f', '--file', metavar='PATH', required=True, help='a recording, such as a.csv')
p.add_argument('-o', '--output-file', required=True)
"""


def test_a_file_to_read_is_one_of_the_repository(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "c.py").write_text(READS_FILE)
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "moves.csv").write_text("time,a\n")
    (tmp_path / "notes.txt").write_text("")
    (found,) = command_lines(load_controller(tmp_path / "c.py"))
    assert found.words == ("--file", "data/moves.csv", "--output-file", "output-file")


def test_a_file_that_nobody_has_is_reported(tmp_path):
    (tmp_path / "c.py").write_text(READS_FILE)
    (found,) = command_lines(load_controller(tmp_path / "c.py"))
    assert found.words == ("--file", "file", "--output-file", "output-file")
    assert "a file of yours has to stand for file" in found.remark


REACH = Reach((0.4, 0.1, 0.25), (3.1416, 0.0, 0.5), (0.1, -0.2, 0.3, 0.4, 0.5, 0.6))


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (
            "x, y, z = float(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])\n",
            ("0.4", "0.1", "0.25"),
        ),
        (
            "pose.position.x = float(sys.argv[1])\npose.position.y = float(sys.argv[2])\n",
            ("0.4", "0.1"),
        ),
        ("move(x=float(sys.argv[1]), z=float(sys.argv[2]))\n", ("0.4", "0.25")),
        ("x, y, z = map(float, sys.argv[1:4])\n", ("0.4", "0.1", "0.25")),
        ("goal = [float(word) for word in sys.argv[1:4]]\n", ("0.4", "0.1", "0.25")),
        (
            "joints = [float(word) for word in sys.argv[1:]]\n",
            ("0.1", "-0.2", "0.3", "0.4", "0.5", "0.6"),
        ),
        # In the units that docstring, comment, name or conversion say.
        ("'''Usage: move.py X Y, in mm.'''\nx = float(sys.argv[1])\n", ("400",)),
        ("z = int(sys.argv[1]) / 1000.0\n", ("250",)),
        ("yaw = math.radians(float(sys.argv[1]))\n", ("28.6",)),
        ("j2 = float(sys.argv[1])  # degrees\n", ("-11.5",)),
        ("x_cm = float(sys.argv[1])\n", ("40",)),
        # A number that is no place stays what it was.
        ("count = int(sys.argv[1])\nif sys.argv[2] == 'fast': pass\n", ("1", "fast")),
    ],
)
def test_positions_of_a_command_line_are_reached_in_the_units_that_are_said(
    tmp_path, source, words
):
    head = "import rospy, sys, math\n"
    source = source if source.startswith("'''") else head + source
    (tmp_path / "c.py").write_text(source if head in source else source + head)
    (found,) = command_lines(load_controller(tmp_path / "c.py"), (), REACH)
    assert found.words == words


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ("'x', type=float, help='target x in m'", ("0.4",)),
        ("'--z', type=float, required=True, help='height in millimetres'", ("--z", "250")),
        ("'xyz', type=float, nargs=3", ("0.4", "0.1", "0.25")),
        ("'--yaw-deg', type=float, required=True", ("--yaw-deg", "28.6")),
        ("'angle', type=float, help='turn by so many degrees'", ("11.5",)),
        ("'joint_1', type=float, help='[rad]'", ("0.1",)),
        ("'speed', type=float", ("0.1",)),
        ("'side', choices=['left']", ("left",)),
    ],
)
def test_positions_of_options_are_reached_in_the_units_that_are_said(tmp_path, option, words):
    (tmp_path / "c.py").write_text(f"import rospy, argparse\np.add_argument({option})\n")
    (found,) = command_lines(load_controller(tmp_path / "c.py"), (), REACH)
    assert found.words == words


def test_a_usage_that_names_numbers_alone_is_no_command(tmp_path):
    (tmp_path / "c.py").write_text("import rospy, sys\nx = float(sys.argv[1])\n")
    written = [(("X",), "c.py:1"), (("0.3",), "README.md:2")]
    found = command_lines(load_controller(tmp_path / "c.py"), written, REACH)
    assert [each.words for each in found] == [("0.3",), ("0.4",)]
