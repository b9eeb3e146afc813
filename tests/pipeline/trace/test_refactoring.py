"""The law of refactoring: how the code is cut into functions is no risk."""

import json
from functools import partial

import pytest

from tests.pipeline.every_law import figure_by_every_law, made_up
from tracerisk.common import trace_json
from tracerisk.common.outcome.changes import outcome_changes
from tracerisk.common.outcome.outcome import Outcome


def replace_once(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1, f"{text.count(old)} times: {old}"
    return text.replace(old, new)


LOOP = """\
        init(arm, hand)
        pick_position(arm, number)
        pick(arm, hand)
        place_position(arm, number)
        place(hand)
"""


def body_of(text: str, name: str) -> str:
    """The statements of a function of the sample, its docstring left out."""
    lines = text[text.index(f"def {name}(") :].split("\n")
    kept = []
    for line in lines[2:]:
        if line and not line.startswith(" "):
            break
        kept.append(line)
    return "\n".join(kept).rstrip() + "\n"


def split_in_two(text: str) -> str:
    text = replace_once(
        text,
        '    hand.set_named_target("close")\n',
        '\n\ndef take(arm, hand):\n    """Close on the tube and lift it."""\n'
        '    hand.set_named_target("close")\n',
    )
    return replace_once(
        text, "        pick(arm, hand)\n", "        pick(arm, hand)\n        take(arm, hand)\n"
    )


def two_merged(text: str) -> str:
    body = body_of(text, "pick_position") + body_of(text, "pick")
    both = f'def fetch(arm, hand, number):\n    """Fetch the tube."""\n{body}\n\ndef main():\n'
    text = replace_once(text, "def main():\n", both)
    return replace_once(
        text,
        "        pick_position(arm, number)\n        pick(arm, hand)\n",
        "        fetch(arm, hand, number)\n",
    )


def all_inlined(text: str) -> str:
    bodies = "".join(
        body_of(text, name) for name in ("init", "pick_position", "pick", "place_position", "place")
    )
    indented = "".join(f"    {line}\n" if line else "\n" for line in bodies.split("\n")[:-1])
    return replace_once(text, LOOP, indented)


def dead_function_added(text: str) -> str:
    dead = "def never(arm, hand, number):\n" + LOOP.replace("        ", "    ")
    return replace_once(text, "def main():\n", f"{dead}\n\ndef main():\n")


def renamed(text: str) -> str:
    assert text.count("    place_position(") == text.count("def place_position(") == 1
    return text.replace("place_position(", "bring_home(")


def renamed_and_dead_function_added(text: str) -> str:
    return dead_function_added(renamed(text)).replace("    place_position(", "    bring_home(")


def step_extracted(text: str) -> str:
    """Two functions share a helper for what both did themselves."""
    shared = (
        'def above(arm, number, rack_y):\n    """Go above a slot."""\n'
        "    arm.set_pose_target(slot(number, rack_y, TRAVEL_HEIGHT))\n    arm.go(wait=True)\n"
        "    arm.stop()\n    arm.clear_pose_targets()\n\n\ndef init(arm, hand):\n"
    )
    text = replace_once(text, "def init(arm, hand):\n", shared)
    for rack in ("SOURCE_RACK_Y", "TARGET_RACK_Y"):
        text = replace_once(
            text,
            f"    arm.set_pose_target(slot(number, {rack}, TRAVEL_HEIGHT))\n    arm.go(wait=True)\n"
            "    arm.stop()\n    arm.clear_pose_targets()\n",
            f"    above(arm, number, {rack})\n",
        )
    return text


CHANGES = {
    "split in two": (
        split_in_two,
        ["init", "pick_position", "pick", "take", "place_position", "place"],
    ),
    "two merged": (two_merged, ["init", "fetch", "place_position", "place"]),
    "all inlined": (all_inlined, ["main"]),
    "renamed, and a dead function added": (
        renamed_and_dead_function_added,
        ["init", "pick_position", "pick", "bring_home", "place"],
    ),
    "step extracted": (
        step_extracted,
        ["init", "pick_position", "pick", "place_position", "place"],
    ),
}


QUICK_CHANGES = ("split in two",)
"""What every test run looks at; what the others do, `test_samples.py` does to other samples."""


@pytest.fixture
def by_every_law(tmp_path):
    return partial(figure_by_every_law, folder=tmp_path)


def outcome_of(printed) -> Outcome:
    """What a run brought about, as its JSON has it."""
    outcome = trace_json.loads(json.dumps(printed["trace"]), "trace").outcome
    assert outcome is not None
    return outcome


@pytest.fixture(scope="module")
def as_it_was(short_run):
    """What the run of the unchanged controller gives."""
    _, outcome = short_run
    return outcome.json


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in QUICK_CHANGES else pytest.mark.slow)
        for name in CHANGES
    ],
)
def test_the_missions_failure_probability_stays(
    name, as_it_was, example, short_source, by_every_law
):
    change, functions = CHANGES[name]
    example.write("pick_and_place.py", change(short_source.decode()))
    outcome = example.run("run", "pick_and_place.py", "--json")
    assert outcome.code == 0, outcome.err
    assessment = outcome.json["assessment"]
    assert [state["name"] for state in assessment["states"]] == functions
    expected = as_it_was["assessment"]["mission"]
    for figure in ("failure_probability", "fixed_cycles", "visits_as_run"):
        assert assessment["mission"][figure] == pytest.approx(expected[figure], rel=0.01)
    assert not outcome_changes(*map(outcome_of, (as_it_was, outcome.json))).sentences
    # Four digits stand in a block, and a changed program may move a step later.
    by_use = by_every_law(as_it_was["trace"])
    assert by_every_law(outcome.json["trace"]) == pytest.approx(by_use, rel=0.001)
    # The same cells are drawn of both: what of the hazard ends the mission is the same too.
    found = made_up(as_it_was["trace"])
    with_it = by_every_law(as_it_was["trace"], evidence=found)
    assert with_it < 0.9 * by_use
    assert by_every_law(outcome.json["trace"], evidence=found) == pytest.approx(with_it, rel=0.01)


JOG = """\
import moveit_commander
import rospy


{functions}
rospy.init_node("jog")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_named_target("ready")
arm.go(wait=True)
for i in range(60):
    target = arm.get_current_joint_values()
    target[0] += 0.02 if i % 40 < 20 else -0.02
    {call}
    rospy.sleep(0.02)
"""


def test_steps_shorter_than_any_activity_lose_no_hardware(example, by_every_law):
    """A motion streamed by two functions in turn, each for 20 ms at a time."""
    nudge = "def {}(target):\n    arm.go(target, wait=False)\n\n\n"
    programs = {
        "one.py": (nudge.format("nudge"), "nudge(target)"),
        "two.py": (
            nudge.format("left") + nudge.format("right"),
            "(left if i % 2 else right)(target)",
        ),
    }
    figures, by_use, outcomes = [], [], []
    for name, (functions, call) in programs.items():
        example.write(name, JOG.format(functions=functions, call=call))
        outcome = example.run("run", name, "--json")
        assert outcome.code == 0, outcome.err
        figures.append(outcome.json["assessment"]["mission"]["visits_as_run"])
        by_use.append(by_every_law(outcome.json["trace"]))
        outcomes.append(outcome_of(outcome.json))
    assert figures[1] == pytest.approx(figures[0], rel=0.01)
    assert by_use[1] == pytest.approx(by_use[0], rel=0.01)
    assert not outcome_changes(*outcomes).sentences


def test_a_function_that_never_ran_is_reported_as_no_risk_data(example, quick):
    dead = "def never(arm):\n    act(arm)\n\n\ndef main():\n"
    example.write("controller.py", replace_once(quick(), "def main():\n", dead))
    outcome = example.run("trace", "controller.py", "--json")
    uncovered = [each["ref"] for each in outcome.json["trace"]["uncovered"]]
    assert uncovered == [
        {"file": "controller.py", "name": "home"},
        {"file": "controller.py", "name": "never"},
    ]
