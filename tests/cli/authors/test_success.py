"""`tracerisk success`: a good run is drafted as a mission, and what a user wrote stays."""

from dataclasses import replace

import pytest
from ruamel.yaml import YAML

from tracerisk.common.outcome.arm import Arm
from tracerisk.common.outcome.outcome import CellUse, ObjectOutcome, Outcome, rest_of
from tracerisk.pipeline.mission.drafted import drafted_conditions
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.success import Condition
from tracerisk.twin.physics.scene import Goal

CELL = """\
# The cell of line 3.
services:
  - {name: /glue/enable, type: std_srvs/SetBool, reply: {success: true}}
objects:
  - {name: block, box: [0.04, 0.04, 0.04], xyz: [0.45, 0.25, 0.02], mass: 0.1}
"""
STEPS = (
    "from std_srvs.srv import SetBool",
    "from std_msgs.msg import String",
    "glue = rospy.ServiceProxy('/glue/enable', SetBool)",
    "glue(True), glue(False)",
    "rospy.Publisher('/status', String, queue_size=1).publish('done')",
    "home(arm)",
)


@pytest.fixture
def cell(example, quick):
    """A controller that rests at home, calls its cell, and leaves a block alone."""
    example.write("controller.py", quick(*STEPS))
    example.write("cell.yaml", CELL)
    return example


def drafted(example, *words):
    return example.run("success", "controller.py", "--scenario", "cell.yaml", *words)


def test_a_good_run_is_printed_as_conditions_that_a_scenario_takes(cell, tmp_path):
    outcome = drafted(cell)
    assert outcome.code == 0, outcome.err
    assert cell.read("cell.yaml").decode() == CELL
    lines = outcome.out.splitlines()
    assert lines[0] == "success:"
    assert "  - {object: block, moved: false}  # assumed: it stayed where it was" in lines
    assert "  - {called: /glue/enable, exactly: 2}  # assumed: the run did so 2 times" in lines
    assert "  - {sent: /status, exactly: 1}  # assumed: the run did so 1 time" in lines
    assert sum(1 for line in lines if "# assumed" in line) == 4
    path = tmp_path / "printed.yaml"
    path.write_text(outcome.out)
    assert [each.is_assumed for each in read_scenario(path).success] == [True] * 4


def test_what_is_written_is_met_by_the_run_and_written_once(cell):
    assert drafted(cell, "--write").code == 0
    text = cell.read("cell.yaml").decode()
    assert text.startswith(CELL)
    again = drafted(cell, "--write")
    assert again.code == 0
    assert "nothing that the scenario does not say already" in again.out
    assert cell.read("cell.yaml").decode() == text
    cell.write("cell.yaml", text.replace("  # assumed", "  # was assumed"))
    run = cell.run("run", "controller.py", "--scenario", "cell.yaml", "--json")
    assert (run.code, run.json["verdict"]["kind"]) == (0, "complete")


BESIDE = """\
import rospy
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger, TriggerResponse

rospy.init_node("finder")
glue = rospy.ServiceProxy("/glue/enable", SetBool)
status = rospy.Publisher("/status", String, queue_size=1)


def find(request):
    glue(True)
    status.publish("found")
    return TriggerResponse(True, "")


rospy.Service("/find_part", Trigger, find)
rospy.spin()
"""


@pytest.mark.slow
def test_what_a_node_beside_the_controller_sends_is_not_counted(cell, quick):
    find = "from std_srvs.srv import Trigger", "rospy.wait_for_service('/find_part')"
    asked = (*STEPS[:-1], *find, "rospy.ServiceProxy('/find_part', Trigger)()", STEPS[-1])
    cell.write("package.xml", "<package><name>cell</name></package>\n")
    cell.write("controller.py", quick(*asked))
    cell.write("finder.py", BESIDE)
    assert drafted(cell, "--write").code == 0
    text = cell.read("cell.yaml").decode()
    assert "{called: /glue/enable, exactly: 2}" in text
    assert "{sent: /status, exactly: 1}" in text
    of_fields = "  - {called: /glue/enable, with: {data: true}, exactly: 1}\n"
    cell.write("cell.yaml", text.replace("  # assumed", "  # was assumed") + of_fields)
    run = cell.run("run", "controller.py", "--scenario", "cell.yaml", "--json")
    assert run.json["verdict"]["reasons"] == []
    assert any("finder.py" in line for line in run.json["trace"]["assumptions"])


def test_lines_of_the_user_stay_with_their_comments(cell):
    own = "success:\n  # FAT-7\n  - {called: /glue/enable, times: 2}  # at least\n"
    cell.write("cell.yaml", CELL + own)
    assert drafted(cell, "--write").code == 0
    text = cell.read("cell.yaml").decode()
    assert text.startswith(CELL + own)
    found = YAML(typ="safe").load(text)["success"]
    assert [next(iter(each)) for each in found] == ["called", "object", "sent", "joints"]


def test_a_faulted_or_stuck_run_drafts_nothing(cell, quick):
    missed = CELL + "success:\n  - {called: /glue/enable, exactly: 3}\n"
    cell.write("cell.yaml", missed)
    outcome = drafted(cell, "--write")
    assert outcome.code == 1
    assert "nothing is drafted" in outcome.err
    assert cell.read("cell.yaml").decode() == missed
    cell.write("cell.yaml", CELL)
    cell.write("controller.py", quick("rospy.wait_for_service('/nobody')"))
    outcome = drafted(cell, "--write", "--json")
    assert outcome.code == 4
    assert outcome.json["drafted"] == []
    assert outcome.json["written"] is None
    assert cell.read("cell.yaml").decode() == CELL


def test_without_a_scenario_one_is_begun(example, quick):
    example.write("controller.py", quick("home(arm)"))
    assert example.run("success", "controller.py", "--write").code == 0
    text = example.read("controller.scenario.yaml").decode()
    assert text.startswith("success:\n  - joints:  # assumed: the arm rests there")
    refused = example.run("success", "controller.py", "-o", "mission.yaml")
    assert refused.code == 2
    assert "--output says where --write writes" in refused.err


def test_objects_that_were_placed_are_drafted_where_they_ended(example, pick_and_place):
    example.write("pick_and_place.py", pick_and_place.replace(b"TUBES = 10\n", b"TUBES = 1\n"))
    outcome = example.run("success", "pick_and_place.py", "--json")
    assert outcome.code == 0, outcome.err
    by_name = {
        each["value"]["object"]: each["value"]
        for each in outcome.json["drafted"]
        if "object" in each["value"]
    }
    assert by_name.pop("tube_1") == {"object": "tube_1", "at": "target_rack_slot_1"}
    assert len(by_name) == 9
    assert all(each["moved"] is False for each in by_name.values())


PART = ObjectOutcome("part", (0.5, 0.2, 0.03), (0.5, 0.008, 0.03), 0.0, 0.0, "tray", "")
GOAL = Goal("slot_1", (0.5, 0.0, 0.03))


@pytest.mark.parametrize(
    ("found", "goals", "drafted"),
    [
        (
            PART,
            (),
            {"at": [0.5, 0.008, 0.03], "within": 0.005, "tilt": 0.1, "rests_on": "tray"},
        ),
        (PART, (GOAL,), {"at": "slot_1"}),
        (
            replace(PART, tilt_deg=90.0, rests_on="tray+lid"),
            (GOAL,),
            {"at": [0.5, 0.008, 0.03], "within": 0.005},
        ),
        (replace(PART, held_in="hand", rests_on=""), (GOAL,), {"held_by": "hand"}),
        (replace(PART, end_m=(0.5, 0.198, 0.03)), (GOAL,), {"moved": False}),
    ],
    ids=["placed", "at a goal", "on its side", "held", "stayed"],
)
def test_an_object_is_drafted_where_it_ended(found, goals, drafted):
    (condition,) = drafted_conditions(Outcome(objects=(found,)), goals, is_over=True)
    assert condition.value == {"object": "part", **drafted}


@pytest.mark.parametrize(
    ("end_m", "held_in", "words"),
    [
        (PART.end_m, "", "the run moved it by 192 mm"),
        (PART.end_m, "hand", "the run moved it by 192 mm and it is held at the end"),
        (PART.begin_m, "hand", "it is held at the end"),
        (PART.begin_m, "", "it stayed where it was"),
    ],
)
def test_a_drafted_condition_of_an_object_says_what_the_run_showed(end_m, held_in, words):
    found = replace(PART, end_m=end_m, held_in=held_in)
    (condition,) = drafted_conditions(Outcome(objects=(found,)), (), is_over=True)
    assert condition.words == words


def test_uses_of_the_cell_are_counted_but_those_of_a_stream():
    uses = [CellUse(i, "message", "/done", "") for i in range(3)]
    outcome = Outcome(cell=(*uses, CellUse(3, "goal", "/base", "")), streams=("/beat",))
    found = [each.value for each in drafted_conditions(outcome, (), is_over=True)]
    assert found == [
        {"called": "/base", "exactly": 1},
        {"sent": "/done", "exactly": 3},
        {"sent": "/beat"},
    ]


def test_the_last_rest_of_each_arm_is_drafted_if_the_controller_was_done():
    arms = (Arm(("left_1",)), Arm(("right_1",)))
    rests = tuple(rest_of(arms[i % 2], (0.1 * i,), order=i, number=i % 2) for i in range(4))
    outcome = Outcome(arms=arms, rests=rests)
    found = [each.value for each in drafted_conditions(outcome, (), is_over=True)]
    assert found == [{"joints": {"left_1": 0.2}}, {"joints": {"right_1": pytest.approx(0.3)}}]
    assert drafted_conditions(outcome, (), is_over=False) == ()
    known = (Condition("joints", joints={"left_1": 0.5}),)
    (rest,) = drafted_conditions(outcome, (), known, is_over=True)
    assert "right_1" in rest.value["joints"]
