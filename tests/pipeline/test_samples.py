"""Every other sample controller through the whole path, and the law of refactoring on each.

`pick_and_place.py` has tests of its own, `test_sample.py` and `test_refactoring.py`.
"""

import json
import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from tests.pipeline.every_law import figure_by_every_law, made_up
from tests.prm.other_models.formats.openpra_engine import check_by_engine, needs_engine, violations
from tests.slow import slow_but
from tracerisk.adder.sources.insert import strip_blocks
from tracerisk.common import trace_json

SAMPLES = Path(__file__).parents[2] / "sample_controllers"
PACKAGE = "part_sorting/src/part_sorting"
SORTER = f"{PACKAGE}/src/part_sorting/sorter.py"
ARM = f"{PACKAGE}/src/part_sorting/arm.py"

Edits = tuple[tuple[str, str], ...]
"""Texts that stand once in the source, each with what takes its place."""


@dataclass(frozen=True)
class Change:
    """A refactoring: the edits of each file, and the functions that are relevant after it."""

    functions: tuple[str, ...]
    edits: dict[str, Edits | Callable[[str], str]]

    def of(self, files: dict[str, bytes]) -> dict[str, bytes]:
        changed = dict(files)
        for name, edits in self.edits.items():
            text = files[name].decode()
            if callable(edits):
                text = edits(text)
            else:
                for old, new in edits:
                    assert text.count(old) == 1, f"{text.count(old)} times: {old}"
                    text = text.replace(old, new)
            changed[name] = text.encode()
        return changed


@dataclass(frozen=True)
class Sample:
    """A sample, what is expected of its run, and its refactorings."""

    entry: str
    functions: dict[str, tuple[str, ...]]
    changes: dict[str, Change]
    uncovered: tuple[str, ...] = ()
    end: str = "ended"
    sources: tuple[str, ...] = field(default=())

    @property
    def annotated(self) -> tuple[str, ...]:
        return self.sources or (self.entry,)

    def files(self) -> dict[str, bytes]:
        """Its files without blocks, whatever a run in the work tree has put in."""
        top = SAMPLES / self.entry.split("/")[0]
        paths = [top] if top.is_file() else sorted(p for p in top.rglob("*") if p.is_file())
        return {
            path.relative_to(SAMPLES).as_posix(): (
                strip_blocks(path.read_bytes(), path.name)
                if path.suffix == ".py"
                else path.read_bytes()
            )
            for path in paths
            if "__pycache__" not in path.parts and path.name != "tracerisk.lock"
        }


def into_main(text: str) -> str:
    """Put all statements after the imports of a flat script into a function, and call it."""
    begin = text.index("moveit_commander.roscpp_initialize")
    lines = (f"    {line}" if line else "" for line in text[begin:].split("\n"))
    return text[:begin] + "\ndef main():\n" + "\n".join(lines) + "\n\nmain()\n"


BOTH = ("gripper", "electric_motor")
MOTORS = ("electric_motor",)
# The published study, of the Panda, has no sensors.
ENCODERS = ("joint_encoder",)
TORQUE = ("joint_encoder", "joint_torque_sensor")

TENDING = "machine_tending.py"
MACHINE_TENDING = Sample(
    TENDING,
    {
        "MachineTending.go_home": BOTH + TORQUE,
        "MachineTending.fetch_part": BOTH + TORQUE,
        "MachineTending.load_machine": BOTH + TORQUE,
    },
    {
        "extracted": Change(
            ("MachineTending.go_home", "MachineTending.fetch_part", "MachineTending.load_machine",
             "MachineTending.let_go"),
            {TENDING: ((
                "        self.set_gripper(OPEN)\n        self.follow([(IN_FRONT_OF_MACHINE, 1.0)])\n",
                "        self.let_go()\n\n    def let_go(self):\n        self.set_gripper(OPEN)\n"
                "        self.follow([(IN_FRONT_OF_MACHINE, 1.0)])\n",
            ),)},
        ),
        "inlined": Change(
            ("MachineTending.set_gripper", "MachineTending.follow"),
            {TENDING: (
                (
                    '        """Load every part, then park the arm."""\n        self.go_home()\n',
                    '        """Load every part, then park the arm."""\n'
                    "        self.set_gripper(OPEN)\n        self.follow([(HOME, 2.0)])\n",
                ),
                (
                    "            self.fetch_part()\n            self.load_machine()\n",
                    "            self.follow([(ABOVE_TRAY, 2.0), (AT_TRAY, 3.0)])\n"
                    "            self.set_gripper(CLOSED)\n"
                    "            self.follow([(ABOVE_TRAY, 1.0)])\n"
                    "            self.follow([(IN_FRONT_OF_MACHINE, 2.5), (IN_CHUCK, 3.5)])\n"
                    "            self.set_gripper(OPEN)\n"
                    "            self.follow([(IN_FRONT_OF_MACHINE, 1.0)])\n",
                ),
                (
                    "        self.go_home()\n\n    def go_home",
                    "        self.set_gripper(OPEN)\n        self.follow([(HOME, 2.0)])\n\n"
                    "    def go_home",
                ),
            )},
        ),
        "renamed, and a dead function added": Change(
            ("MachineTending.go_home", "MachineTending.take_part", "MachineTending.load_machine"),
            {TENDING: (
                ("self.fetch_part()", "self.take_part()"),
                (
                    "    def fetch_part(self):",
                    "    def never(self):\n        self.follow([(HOME, 1.0)])\n"
                    "        self.set_gripper(OPEN)\n\n    def take_part(self):",
                ),
            )},
        ),
    },
)  # fmt: skip

SCAN = "surface_scan.py"
SURFACE_SCAN = Sample(
    SCAN,
    {"SurfaceScan.scan_front": MOTORS + ENCODERS, "SurfaceScan.scan_back": MOTORS + ENCODERS},
    {
        "extracted": Change(
            ("SurfaceScan.scan_front", "SurfaceScan.scan_back"),
            {SCAN: ((
                "        self.publisher.publish(message)\n",
                "        self.send(message)\n\n    def send(self, message):\n"
                "        self.publisher.publish(message)\n",
            ),)},
        ),
        "inlined": Change(
            ("SurfaceScan.publish_line",),
            {SCAN: (
                ("self.scan_front()", 'self.publish_line(*LINES["front"])'),
                ("self.scan_back()", 'self.publish_line(*LINES["back"])'),
            )},
        ),
        "renamed, and a dead function added": Change(
            ("SurfaceScan.scan_near", "SurfaceScan.scan_back"),
            {SCAN: (
                ("self.scan_front()", "self.scan_near()"),
                (
                    "    def scan_front(self):",
                    '    def never(self):\n        self.publish_line(*LINES["back"])\n\n'
                    "    def scan_near(self):",
                ),
            )},
        ),
    },
    end="cycles",
)  # fmt: skip

GLUE = "glue_bead.py"
GLUE_BEAD = Sample(
    GLUE,
    {"<module>": MOTORS + ENCODERS},
    {
        "extracted": Change(
            ("<module>",),
            {GLUE: (
                (
                    "approach = [",
                    "\ndef follow_rim(waypoints):\n"
                    "    plan, fraction = arm.compute_cartesian_path(waypoints, 0.005)\n"
                    "    if fraction < 0.99:\n        sys.exit(1)\n"
                    "    arm.execute(plan, wait=True)\n\n\napproach = [",
                ),
                (
                    "    plan, fraction = arm.compute_cartesian_path(waypoints, 0.005)\n"
                    "    if fraction < 0.99:\n"
                    '        rospy.logerr("only %.0f %% of the rim can be reached", 100 * fraction)\n'
                    "        sys.exit(1)\n    arm.execute(plan, wait=True)\n",
                    "    follow_rim(waypoints)\n",
                ),
            )},
        ),
        "put into a function": Change(("main",), {GLUE: into_main}),
        "dead function added": Change(
            ("<module>",),
            {GLUE: (
                (
                    "corner = arm.get_current_pose().pose\n",
                    "corner = arm.get_current_pose().pose\n\n\ndef never():\n"
                    "    arm.go(approach, wait=True)\n\n\n",
                ),
            )},
        ),
    },
)  # fmt: skip

PICK = "careful_pick.py"
CAREFUL_PICK = Sample(
    PICK,
    {
        "TubePicker.approach": BOTH,
        "TubePicker.grasp": BOTH,
        "TubePicker.lift": BOTH,
        "TubePicker.put_back": BOTH,
    },
    {
        "extracted": Change(
            ("TubePicker.approach", "TubePicker.grasp", "TubePicker.lift", "TubePicker.put_back",
             "TubePicker.leave"),
            {PICK: ((
                "        self.open_hand()\n        self.straight_to(ABOVE)\n\n    def back_off",
                "        self.leave()\n\n    def leave(self):\n        self.open_hand()\n"
                "        self.straight_to(ABOVE)\n\n    def back_off",
            ),)},
        ),
        "inlined": Change(
            ("TubePicker.pick", "TubePicker.put_back"),
            {PICK: (
                (
                    "                self.approach(number)\n                self.grasp()\n",
                    "                self.open_hand()\n"
                    "                pose = Pose()\n"
                    "                pose.position.x = FIRST_TUBE_X + PITCH * number\n"
                    "                pose.position.y = RACK_Y\n"
                    "                pose.position.z = ABOVE\n"
                    "                pose.orientation.x = 0.9238795\n"
                    "                pose.orientation.y = -0.3826834\n"
                    "                self.arm.set_pose_target(pose)\n"
                    "                self.arm.go(wait=True)\n"
                    "                self.arm.clear_pose_targets()\n"
                    "                self.straight_to(AT_TUBE)\n"
                    "                goal = GraspGoal(width=TUBE_WIDTH, speed=0.05, force=15.0)\n"
                    "                goal.epsilon = GraspEpsilon(inner=0.004, outer=0.004)\n"
                    "                self.grasp_client.send_goal_and_wait(goal, rospy.Duration(5.0))\n"
                    "                result = self.grasp_client.get_result()\n"
                    "                if result is None or not result.success:\n"
                    "                    raise GraspError()\n",
                ),
                ("                self.lift()\n", "                self.straight_to(ABOVE)\n"),
            )},
        ),
        "renamed, and a dead function added": Change(
            ("TubePicker.reach_for", "TubePicker.grasp", "TubePicker.lift", "TubePicker.put_back"),
            {PICK: (
                ("self.approach(number)", "self.reach_for(number)"),
                (
                    "    def approach(self, number):",
                    "    def never(self):\n        self.straight_to(ABOVE)\n"
                    "        self.open_hand()\n\n    def reach_for(self, number):",
                ),
            )},
        ),
    },
    uncovered=("TubePicker.back_off", "TubePicker.ask_for_help"),
)  # fmt: skip

PART_SORTING = Sample(
    f"{PACKAGE}/scripts/sort_parts.py",
    {
        "Sorter.take": BOTH + ENCODERS,
        "Arm.reach_down": MOTORS + ENCODERS,
        "Sorter.drop": BOTH + ENCODERS,
        "Sorter.park": BOTH + ENCODERS,
    },
    {
        "extracted": Change(
            ("Sorter.take", "Arm.reach_down", "Sorter.lift", "Sorter.drop", "Sorter.park"),
            {SORTER: ((
                "        self.arm.close_hand()\n"
                "        self.arm.carry_to(part.bearing, seconds=1.5)\n",
                "        self.lift(part)\n\n    def lift(self, part):\n"
                "        self.arm.close_hand()\n"
                "        self.arm.carry_to(part.bearing, seconds=1.5)\n",
            ),)},
        ),
        "inlined": Change(
            ("Sorter.take", "Sorter.sort", "Sorter.park"),
            {SORTER: (
                (
                    "        self.drop(part)\n",
                    "        self.arm.carry_to(self.bins[part.colour])\n"
                    "        self.arm.open_hand()\n",
                ),
                (
                    "        self.arm.reach_down(part.bearing)\n",
                    "        self.arm._follow(\n            self.arm._arm,\n"
                    '            ["waist", "shoulder", "elbow", "forearm_roll", "wrist_angle",\n'
                    '             "wrist_rotate"],\n'
                    "            [part.bearing, 0.35, 0.25, 0.0, 0.95, 0.0],\n            1.5,\n"
                    "        )\n",
                ),
            )},
        ),
        "renamed, and a dead function added": Change(
            ("Sorter.fetch", "Arm.reach_down", "Sorter.drop", "Sorter.park"),
            {
                SORTER: (
                    ("self.take(part)", "self.fetch(part)"),
                    ("def take(self, part)", "def fetch(self, part)"),
                ),
                ARM: ((
                    "    def open_hand(self):",
                    "    def never(self):\n        self.carry_to(0.0)\n        self.close_hand()\n\n"
                    "    def open_hand(self):",
                ),),
            },
        ),
    },
    sources=(ARM, SORTER),
)  # fmt: skip

SHELF = "shelf_stocking.py"
SHELF_STOCKING = Sample(
    SHELF,
    {
        "ShelfStocking.look_out": MOTORS,
        "ShelfStocking.fetch_box": BOTH,
        "ShelfStocking.put_on_shelf": BOTH,
        "ShelfStocking.park": MOTORS,
    },
    {
        "extracted": Change(
            ("ShelfStocking.look_out", "ShelfStocking.fetch_box", "ShelfStocking.put_on_shelf",
             "ShelfStocking.let_go", "ShelfStocking.park"),
            {SHELF: ((
                '        self.set_hand("open")\n'
                "        self.move_to(0.40 + 0.08 * row, -0.42, 0.55)\n\n",
                "        self.let_go(row)\n\n    def let_go(self, row):\n"
                '        self.set_hand("open")\n'
                "        self.move_to(0.40 + 0.08 * row, -0.42, 0.55)\n\n",
            ),)},
        ),
        "inlined": Change(
            ("ShelfStocking.look_out", "ShelfStocking.fetch_box", "ShelfStocking.put_on_shelf",
             "main"),
            {SHELF: ((
                "    stocking.park()\n",
                "    stocking.arm.set_start_state_to_current_state()\n"
                '    stocking.arm.set_goal_state(configuration_name="ready")\n'
                "    stocking.plan_and_execute(stocking.arm)\n",
            ),)},
        ),
        "renamed, and a dead function added": Change(
            ("ShelfStocking.look_out", "ShelfStocking.take_box", "ShelfStocking.put_on_shelf",
             "ShelfStocking.park"),
            {SHELF: (
                ("stocking.fetch_box()", "stocking.take_box()"),
                (
                    "    def fetch_box(self):",
                    '    def never(self):\n        self.set_hand("open")\n        self.park()\n\n'
                    "    def take_box(self):",
                ),
            )},
        ),
    },
)  # fmt: skip

ALL = {
    "machine_tending": MACHINE_TENDING,
    "surface_scan": SURFACE_SCAN,
    "glue_bead": GLUE_BEAD,
    "careful_pick": CAREFUL_PICK,
    "part_sorting": PART_SORTING,
    "shelf_stocking": SHELF_STOCKING,
}
QUICK = ("surface_scan", "glue_bead", "part_sorting", "shelf_stocking")
"""Samples that every test run looks at: what the others are written with, these have too."""
NAMES = slow_but(QUICK, list(ALL))
QUICK_CHANGES = {"surface_scan": "inlined", "glue_bead": "put into a function"}
"""Refactorings that every test run looks at; the others are `slow`."""

OUTPUTS = ("--json", "--trace", "trace.json", "--model", "model.json")
CPU_LIMIT = ("--cpu-limit", "60")
"""Generous: a sample takes 2 to 6 s, and what it took is printed."""


def run_of(example, sample: Sample, *arguments: str):
    begun = time.monotonic()
    outcome = example.run("run", sample.entry, *arguments, *CPU_LIMIT)
    sys.stdout.write(f"{sample.entry}: {time.monotonic() - begun:.1f} s\n")
    assert outcome.code == 0, outcome.err
    return outcome


@pytest.fixture(scope="module")
def ran(tmp_path_factory, example_in):
    """Run a sample once, and keep the folder with all its outputs."""
    runs = {}

    def run(name: str):
        if name not in runs:
            example = example_in(tmp_path_factory.mktemp(name))
            for file, content in ALL[name].files().items():
                example.write(file, content)
            runs[name] = example, run_of(example, ALL[name], *OUTPUTS)
        return runs[name]

    return run


def slow_unless(quick: bool):
    return () if quick else (pytest.mark.slow,)


def risk(outcome) -> dict[str, float]:
    mission = outcome.json["assessment"]["mission"]
    return {
        each: mission[each] for each in ("failure_probability", "fixed_cycles", "visits_as_run")
    }


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("name", NAMES)
def test_the_functions_that_matter_are_found_with_what_they_use(name, ran):
    _, outcome = ran(name)
    trace = outcome.json["trace"]
    assert trace["end"]["cause"] == ALL[name].end
    found = {
        state["name"]: tuple(
            each for each in state["probabilities"] if not each.endswith("_system")
        )
        for state in outcome.json["model"]["states"]
    }
    assert {each: sorted(used) for each, used in found.items()} == {
        each: sorted(used) for each, used in ALL[name].functions.items()
    }
    assert list(found) == list(ALL[name].functions)
    assert outcome.json["assessment"]["mission"]["failure_probability"] > 0.0


@pytest.mark.parametrize("name", NAMES)
def test_what_could_move_the_arm_and_never_ran_has_no_risk_data(name, ran):
    example, outcome = ran(name)
    sample = ALL[name]
    uncovered = outcome.json["trace"]["uncovered"]
    assert tuple(each["ref"]["name"] for each in uncovered) == sample.uncovered
    source = example.read(sample.entry).decode().split("\n")
    for each in uncovered:
        assert f"def {each['ref']['name'].split('.')[-1]}(" in source[each["line"] - 1]


@pytest.mark.parametrize("name", NAMES)
def test_exposures_sum_to_the_active_time_of_the_run(name, ran):
    example, _ = ran(name)
    trace = trace_json.loads(example.read("trace.json").decode(), "trace.json")
    assert trace.active
    for element, whole in trace.active.items():
        for measure in ("moving_s", "holding_s", "grasping_s", "active_s"):
            parts = [
                getattr(visit.exposures[element], measure)
                for visit in trace.visits
                if element in visit.exposures
            ]
            assert math.fsum(parts) == pytest.approx(getattr(whole, measure), abs=0.002)


@pytest.mark.parametrize("name", NAMES)
def test_strip_gives_back_the_original_bytes(name, ran, example):
    run, _ = ran(name)
    sample = ALL[name]
    for source in sample.annotated:
        example.write(source, run.read(source))
        assert b"# | RiskAnnotation" in run.read(source)
    assert example.run("strip", *sample.annotated).code == 0
    original = sample.files()
    for source in sample.annotated:
        assert example.read(source) == original[source]


@pytest.mark.parametrize("name", NAMES)
def test_the_blocks_alone_give_the_model(name, ran):
    example, outcome = ran(name)
    sources = ALL[name].annotated
    built = example.run("build", *sources, "--json").json["model"]
    assert built["states"] == outcome.json["model"]["states"]
    solved = example.run("solve", *sources, "--json").json["assessment"]
    assert solved["mission"] == outcome.json["assessment"]["mission"]
    assert example.run("convert", *sources, "-o", "openpra.json").code == 0
    assert violations(json.loads(example.read("openpra.json"))) == []


@needs_engine
@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_the_openpra_engine_itself_solves_what_is_converted(name, ran, example):
    """Slow: it runs the samples, of which `test_the_blocks_alone_give_the_model` takes some."""
    run, _ = ran(name)
    sources = ALL[name].annotated
    for source in sources:
        example.write(source, run.read(source))
    check_by_engine(example, *sources)


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_a_second_run_changes_no_byte(name, ran):
    """Slow: `test_sample.py` sees that a second run of one sample changes none."""
    example, outcome = ran(name)
    before = example.files()
    again = run_of(example, ALL[name], *OUTPUTS)
    assert example.files() == before
    assert again.out == outcome.out


@pytest.mark.parametrize(
    ("name", "change"),
    [
        pytest.param(name, change, marks=slow_unless(QUICK_CHANGES.get(name) == change))
        for name, sample in ALL.items()
        for change in sample.changes
    ],
)
def test_how_the_code_is_cut_into_functions_is_no_risk(name, change, ran, example, tmp_path):
    sample = ALL[name]
    refactored = sample.changes[change]
    for file, content in refactored.of(sample.files()).items():
        example.write(file, content)
    outcome = run_of(example, sample, "--json")
    states = [state["name"] for state in outcome.json["model"]["states"]]
    assert tuple(states) == refactored.functions
    _, original = ran(name)
    assert risk(outcome) == pytest.approx(risk(original), rel=0.01)
    before, after = original.json["trace"], outcome.json["trace"]
    for evidence in (None, made_up(before)):
        figure = figure_by_every_law(before, tmp_path, evidence)
        assert figure_by_every_law(after, tmp_path, evidence) == pytest.approx(figure, rel=0.01)
