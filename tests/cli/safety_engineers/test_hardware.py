"""`tracerisk hardware`: descriptions shown, begun and written in the other format."""

import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.formats import read_description
from tracerisk.common.hardware.shipped import hardware_of
from tracerisk.common.hardware.units import SHEET_KINDS
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.twin.robots.robot import load_robot, robot_names

CELL = """\
# a comment
robot: panda
components:
  arm.motor:
    failure_rate: {value: 570, unit: FIT, error_factor: 3}
    twin: {joints: "*"}
    load_law: {reference_load: 0.3, wearing_share: 0.6, exponent: 10/3}
    modes: {jam: {fraction: 0.4, when: [moving]}}
    source: "data book, table 3"
  gripper:
    probability: {value: 1e-7, per: demand, of: grasp}
    twin: {gripper: true}
    source: "assumed: as others"
  power:
    weibull: {shape: 2, scale: 30000, per: hour}
    age: {value: 12000, per: hour}
    quantity: 3
    required: 2
    detected: {test_interval: 8, per: hour}
    active: always
"""


@pytest.fixture
def cell(example):
    example.write("cell.yaml", CELL)
    return example


def test_a_description_is_shown_with_units_places_and_sources(cell):
    outcome = cell.run("hardware", "show", "cell.yaml")
    assert outcome.code == 0, outcome.err
    assert outcome.out == (Path(__file__).parent / "hardware_cell.txt").read_text()


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (["joint1", "joint4", "joint5", "joint6"], "joints joint1, joint4 to joint6"),
        (["joint2", "joint3"], "joints joint2, joint3"),
        (
            ["joint1", "joint2", "joint4", "wrist", "elbow"],
            "joints joint1, joint2, joint4, wrist, elbow",
        ),
        ([f"joint{number}" for number in range(1, 8)], "joints joint1 to joint7"),
    ],
)
def test_the_joints_of_a_component_are_named_by_rows_of_their_numbers(example, names, told):
    rate = "failure_rate: {value: 1e-7, per: hour}"
    motor = f"{{{rate}, twin: {{joints: [{', '.join(names)}]}}}}"
    example.write("cell.yaml", f"components:\n  motor: {motor}\n")
    lines = example.run("hardware", "show", "cell.yaml").out.splitlines()
    assert max(map(len, lines)) <= 80
    place = lines[1].index("seen at")
    assert (
        " ".join(" ".join(line[place : lines[1].index("source")] for line in lines[2:]).split())
        == told
    )


def test_with_a_robot_the_units_are_those_of_the_robot(cell):
    outcome = cell.run("hardware", "show", "cell.yaml", "--robot", "panda", "--json")
    assert outcome.code == 0, outcome.err
    joints = [joint.name for joint in load_robot("panda").arm_joints]
    assert outcome.json["units"]["arm.motor"] == {"quantity": 7, "elements": joints}
    assert outcome.json["assumed"] == ["gripper"]
    motor = outcome.json["hardware"]["components"]["arm.motor"]
    assert motor["failure_rate"] == {"value": 570.0, "unit": "FIT", "error_factor": 3.0}
    (rate,) = outcome.json["rates"]["arm.motor"]
    assert (rate["value"], rate["per"]) == (5.7e-7, "hour")
    assert cell.run("hardware", "show", "cell.yaml", "--json").json["units"] is None


def test_the_shipped_description_of_a_robot_is_shown(example):
    outcome = example.run("hardware", "show", "--robot", "baxter")
    assert outcome.code == 0, outcome.err
    (row,) = [line for line in outcome.out.splitlines() if line.startswith("gripper ")]
    assert row.split()[:4] == ["gripper", "2,", "all", "needed"]


def test_what_an_optional_part_the_robot_lacks_is_reported(example):
    example.write(
        "h.yaml",
        "components:\n  camera:\n    failure_rate: {value: 1e-6, per: hour}\n"
        "    twin: {sensors: wrench, optional: true}\n",
    )
    outcome = example.run("hardware", "show", "h.yaml", "--robot", "px100")
    assert "the robot has none" in outcome.out


def test_nothing_to_show_is_bad_input(example):
    outcome = example.run("hardware", "show")
    assert outcome.code == 2
    assert "give one, or --robot NAME" in outcome.err


def test_yaml_is_written_anew_and_says_the_same(cell):
    outcome = cell.run("hardware", "convert", "cell.yaml", "-o", "again.yml", "--json")
    assert outcome.code == 0, outcome.err
    assert (outcome.json["format"], outcome.json["to"], outcome.json["components"]) == (
        "yaml",
        "yaml",
        3,
    )
    assert read_hardware(cell.folder / "again.yml") == read_hardware(cell.folder / "cell.yaml")


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (
            ("cell.yaml", "-o", "cell.txt"),
            "ends in '.txt', which is not a supported format; allowed: .sysml",
        ),
        (("cell", "-o", "a.yaml"), "cell: its name has no ending"),
        (("cell.yaml", "-o", "./cell.yaml"), "whose comments would be lost"),
        (("gone.yaml", "-o", "a.yaml"), "gone.yaml: cannot be read"),
    ],
)
def test_what_cannot_be_converted_is_reported(cell, arguments, expected):
    before = cell.files()
    outcome = cell.run("hardware", "convert", *arguments)
    assert outcome.code == 2
    assert expected in outcome.err
    assert cell.files() == before


def uncommented(text: str) -> str:
    """The text with each of its examples in place."""
    text = re.sub(
        r"^    # with its uncertainty: (\w+): (.*)$", r"    # sure \1: \2", text, flags=re.MULTILINE
    )
    found = []
    for line in text.splitlines():
        if match := re.match(r"    # sure (\w+): (.*)", line):
            at = max(i for i, each in enumerate(found) if each.startswith(f"    {match[1]}: "))
            found[at] = f"    {match[1]}: {match[2]}"
        else:
            found.append(re.sub(r"^    # ", "    ", line))
    return "\n".join(found) + "\n"


def units_by_figures(bound) -> Counter:
    units = Counter()
    for each in bound:
        units[each.component.figures] += each.quantity
    return units


@pytest.mark.parametrize(
    "robot", slow_but({*robot_names()[::3], "baxter", "panda", "px100"}, robot_names())
)
def test_a_first_description_covers_every_part_of_the_robot(tmp_path, robot, capsys):
    from tracerisk.cli import main

    file = tmp_path / "h.yaml"
    assert main(["hardware", "init", "--robot", robot, "-o", str(file), "-q"]) == 0
    elements = load_robot(robot).elements
    hardware = read_hardware(file)
    bound = bind(hardware, elements)
    assert hardware.robot == robot
    # A link that touches is no part of its own.
    parts = {each.name for each in elements if each.kind != "contact"}
    assert {name for each in bound for name in each.elements} == parts
    always = {each.name for each in hardware.components if each.always_active}
    assert {"power_system", "control_system"} <= always
    assert [each.name for each in hardware.components if each.twin and each.twin.optional] == [
        each.name
        for each in hardware_of(robot).components
        if each.name not in {found.component.name for found in bind(hardware_of(robot), elements)}
    ]
    # The figures are those that are shipped, of as many units.
    shipped = units_by_figures(bind(hardware_of(robot), elements))
    assert shipped.items() <= units_by_figures(bound).items()
    text = file.read_text(encoding="utf-8")
    assert text.startswith("# yaml-language-server: $schema=hardware.schema.json\n")
    file.write_text(uncommented(text), encoding="utf-8")
    more = read_hardware(file)
    bind(more, elements)
    motor = next(each for each in more.components if each.name.endswith("electric_motor"))
    assert (motor.load_law is not None, len(motor.modes), motor.age_s > 0) == (True, 2, True)
    assert motor.figures[0].error_factor == 3.0


def test_the_arms_of_a_robot_with_two_get_components_of_their_own(example):
    outcome = example.run("hardware", "init", "--robot", "baxter", "--json")
    names = [name for name in outcome.json["components"] if name.endswith("electric_motor")]
    assert names == ["left_arm.electric_motor", "right_arm.electric_motor", "other.electric_motor"]


def test_a_first_description_is_run(example, quick):
    example.write("controller.py", quick())
    assert example.run("hardware", "init", "--robot", "panda", "-o", "cell.yaml").code == 0
    outcome = example.run("run", "controller.py", "--hardware", "cell.yaml", "--json")
    assert outcome.code == 0, outcome.err
    (state,) = outcome.json["model"]["states"]
    assert {"power_system", "electric_motor"} <= set(state["probabilities"])


def test_a_first_description_takes_no_other_files_place(cell):
    before = cell.files()
    outcome = cell.run("hardware", "init", "--robot", "ur5e", "-o", "cell.yaml")
    assert outcome.code == 2
    assert "cell.yaml: is there already; give another name, or move it away" in outcome.err
    assert cell.files() == before


def test_the_format_and_the_name_of_a_first_description_agree(example):
    outcome = example.run(
        "hardware", "init", "--robot", "ur5e", "-o", "a.yaml", "--format", "sysml"
    )
    assert outcome.code == 2
    assert "a.yaml: is the name of a yaml file, but --format says sysml" in outcome.err
    assert not example.files()


def test_the_schema_is_where_a_first_description_says(example):
    (example.folder / "arms").mkdir()
    made = example.run("hardware", "init", "--robot", "ur5e", "-o", "arms/cell.yaml")
    assert made.code == 0, made.err
    name = example.read("arms/cell.yaml").decode().splitlines()[0].partition("$schema=")[2]
    printed = example.run("schema", "hardware")
    assert example.read(f"arms/{name}").decode() == printed.out
    example.write(f"arms/{name}", "{}")
    assert example.run("hardware", "init", "--robot", "panda", "-o", "arms/b.yaml").code == 0
    assert example.read(f"arms/{name}") == b"{}", "a file that is there stays"


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    "name", ["settings", "pyproject", "hardware", "scenario", "driver", "model", "linked"]
)
def test_a_schema_is_printed_and_written(example, name):
    printed = example.run("schema", name)
    assert printed.code == 0, printed.err
    assert json.loads(printed.out)["$schema"].startswith(("http://json-schema", "https://json-s"))
    assert example.run("schema", name, "-o", "x.json", "-q").code == 0
    assert example.run("schema", name, "-o", "x.json").code == 0
    assert example.read("x.json").decode() == printed.out
    assert example.run("schema", name, "--json").json["text"] == printed.out


def test_an_unknown_schema_is_refused_with_those_that_there_are(example):
    outcome = example.run("schema", "robot")
    assert outcome.code == 2
    assert "settings" in outcome.err


def test_usage_errors_of_an_action_suggest_and_are_json_too(example):
    outcome = example.run("hardware", "init", "--robto", "x", "--robot", "ur5e", "--json")
    assert outcome.code == outcome.json["exit_code"] == 2
    assert "unknown option --robto; did you mean --robot?" in outcome.err
    outcome = example.run("hardware", "init", "--json")
    assert outcome.json["error"]["kind"] == "UsageError"
    assert "required: --robot" in outcome.json["error"]["message"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["init", "--robot", "ur5e"],
        pytest.param(["show", "--robot", "ur5e"], marks=pytest.mark.slow),
    ],
)
def test_hardware_is_shown_without_a_simulator_or_a_parser_of_sysml(arguments):
    code = (
        "import sys; from tracerisk.cli import main; "
        f"assert main(['hardware', *{arguments!r}]) == 0; "
        "assert not {'mujoco', 'dm_control', 'libcst', 'lark', 'scipy'} & sys.modules.keys()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()


def test_a_description_goes_to_sysml_and_comes_back_the_same(cell):
    there = cell.run("hardware", "convert", "cell.yaml", "-o", "cell.sysml", "--json")
    assert there.code == 0, there.err
    assert (there.json["format"], there.json["to"]) == ("yaml", "sysml")
    back = cell.run("hardware", "convert", "cell.sysml", "-o", "back.yaml")
    assert back.code == 0, back.err
    assert read_description(cell.folder / "cell.sysml") == read_hardware(cell.folder / "cell.yaml")
    assert read_hardware(cell.folder / "back.yaml") == read_hardware(cell.folder / "cell.yaml")
    shown = cell.run("hardware", "show", "cell.sysml").out
    assert shown == cell.run("hardware", "show", "cell.yaml").out.replace(
        "cell.yaml:", "cell.sysml:", 1
    )


@pytest.mark.parametrize("robot", ["ur5e", "baxter", "panda"])
def test_a_first_description_is_the_same_in_both_formats(tmp_path, robot):
    from tracerisk.cli import main

    files = [tmp_path / "h.yaml", tmp_path / "h.sysml"]
    for file in files:
        assert main(["hardware", "init", "--robot", robot, "-o", str(file), "-q"]) == 0
    assert read_description(files[0]) == read_description(files[1])
    _, examples = files[1].read_text().split("// Examples of annotations of a part:\n")
    files[1].write_text(re.sub(r"^// ?", "", examples, flags=re.MULTILINE))
    motor, power = read_description(files[1]).components
    assert (motor.load_law is not None, len(motor.modes), motor.age_s) == (True, 2, 4.32e7)
    assert (motor.figures[0].error_factor, power.redundancy.common_cause) == (3.0, 0.1)


def test_blocks_and_result_are_the_same_from_either_format(annotated):
    tested_within_the_mission = CELL.replace("interval: 8, per: hour", "interval: 1, per: second")
    annotated.write("cell.yaml", tested_within_the_mission)
    assert annotated.run("hardware", "convert", "cell.yaml", "-o", "cell.sysml").code == 0
    sources = []
    for name in ("cell.yaml", "cell.sysml"):
        outcome = annotated.run(
            "annotate", "controller.py", "--trace", "trace.json", "--hardware", name
        )
        assert outcome.code == 0, outcome.err
        sources.append(annotated.read("controller.py"))
        solved = annotated.run("solve", "controller.py", "--json")
        assert solved.code == 0, solved.err
        sources.append(solved.out)
    assert b"arm.motor" in sources[0]
    assert sources[:2] == sources[2:]


def test_blocks_are_the_same_from_a_folder_with_several_systems(annotated):
    annotated.write("cell.yaml", CELL)
    bench = "package Bench { part bench { part m { @TraceriskHardware::FailureData { probability = 0.1; } } } }"
    annotated.write("model/other/bench.sysml", bench)
    assert annotated.run("hardware", "convert", "cell.yaml", "-o", "model/cell.sysml").code == 0
    assert (
        annotated.run(
            "annotate", "controller.py", "--trace", "trace.json", "--hardware", "cell.yaml"
        ).code
        == 0
    )
    expected = annotated.read("controller.py")
    shown = annotated.run("hardware", "show", "model")
    assert shown.code == 2
    assert "name one by --system or the setting system" in shown.err
    (system,) = set(re.findall(r"'(\w+::\w+|\w+)' \(", shown.err)) - {"bench", "Bench::bench"}
    assert "m " in annotated.run("hardware", "show", "model", "--system", "bench").out
    annotated.write(
        "pyproject.toml", f'[tool.tracerisk]\nhardware = "model"\nsystem = "{system}"\n'
    )
    assert annotated.run("annotate", "controller.py", "--trace", "trace.json").code == 0
    assert annotated.read("controller.py") == expected
    wrong = annotated.run("annotate", "controller.py", "--trace", "trace.json", "--system", "arms")
    assert wrong.code == 2
    assert "the system 'arms' is no part in a package" in wrong.err


def test_what_is_left_out_of_a_model_is_reported(example):
    example.write(
        "cell.sysml",
        """\
package Cell {
    private import SI::*;
    private import TraceriskHardware::*;
    part robot {
        part motor {
            @FailureData { rate = 5.7e-7 [h^-1]; }
            @TwinBinding { joints = "*"; }
            action spin;
        }
    }
}
""",
    )
    outcome = example.run("hardware", "show", "cell.sysml", "--json")
    assert outcome.code == 0, outcome.err
    assert "warning: cell.sysml:8:13: 'action'" in outcome.err
    (warning,) = outcome.json["warnings"]
    assert warning.startswith("cell.sysml:8:13: ")
    outcome = example.run("hardware", "convert", "cell.sysml", "-o", "cell.yaml", "-q")
    assert (outcome.code, outcome.err) == (0, "")


def test_a_fault_in_sysml_is_reported_before_anything_is_simulated(example, quick):
    example.write("cell.sysml", "package P {\n    part robot {\n        part motor [;\n    }\n}\n")
    example.write("pyproject.toml", '[tool.tracerisk]\nhardware = "cell.sysml"\n')
    example.write("controller.py", quick('open("ran", "w").close()'))
    before = example.files()
    outcome = example.run("run", "controller.py")
    assert outcome.code == 2
    assert "cell.sysml:3:" in outcome.err
    assert example.files() == before


def test_a_first_description_and_the_help_name_what_a_data_sheet_states(example):
    first = example.run("hardware", "init", "--robot", "panda").out
    head = " ".join(line.removeprefix("# ") for line in first.splitlines() if line.startswith("# "))
    said = " ".join(example.run("hardware", "update", "--help").out.split())
    for kind in SHEET_KINDS:
        assert re.search(rf"\b{kind}\b", head), kind
        assert re.search(rf"\b{kind}\b", said), kind
    forms = re.findall(r"(\w+): (\{value: [^}]*\})", head)
    assert [kind for kind, _ in forms] == ["mtbf", "b10d"]
    for kind, form in forms:
        text = form.replace("HOURS", "2e5").replace("CYCLES", "5e6").replace("SHARE", "0.5")
        example.write(
            "h.yaml", f"components:\n  part: {{twin: {{gripper: true}}, {kind}: {text}}}\n"
        )
        assert example.run("hardware", "show", "h.yaml").code == 0, text
