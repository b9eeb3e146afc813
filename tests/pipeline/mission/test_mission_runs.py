"""A run is judged by the mission that its scenario declares, wherever its verdict shows."""

import json

import pytest

MISSION = "success:\n  - {joints: {panda_joint1: 0.5}}\n"


@pytest.fixture
def missing(example, quick):
    """A controller that ends elsewhere than its scenario declares, in a folder of its own."""
    example.write("controller.py", quick("home(arm)", "arm.go(joints, wait=True)"))
    example.write("cell.yaml", MISSION)
    example.write("pyproject.toml", '[tool.tracerisk]\nscenario = "cell.yaml"\n')
    return example


def test_a_missed_mission_is_faulted_with_its_line_wherever_the_verdict_shows(missing):
    outcome = missing.run("run", "controller.py", "--json")
    assert outcome.code == 1
    verdict = outcome.json["verdict"]
    (reason,) = [each for each in verdict["reasons"] if each["code"] == "mission-missed"]
    assert verdict["kind"] == reason["verdict"] == "faulted"
    assert reason["words"] == "the arm ends 0.45 from panda_joint1 = 0.5 (at most 0.02 allowed)"
    assert (reason["location"]["file"], reason["location"]["line"]) == ("cell.yaml", 2)
    assert reason["object"] == "joints panda_joint1 0.5 within 0.02"
    lock = json.loads(missing.read("tracerisk.lock"))
    assert "mission-missed" in json.dumps(lock)
    for verb in (("check", "controller.py"), ("trace", "controller.py")):
        told = missing.run(*verb)
        assert told.code == 1
        assert "panda_joint1 = 0.5" in told.out + told.err


def test_an_accepted_miss_leaves_the_run_complete(missing):
    accept = (
        "accept:\n  - {code: mission-missed, object: joints panda_joint1 0.5 within 0.02, "
        "words: the rest is a matter of taste}\n"
    )
    missing.write("cell.yaml", MISSION + accept)
    outcome = missing.run("run", "controller.py")
    assert outcome.code == 0
    assert "complete" in outcome.err + outcome.out
    assert "success: 0 of 1 condition met" in outcome.err


def test_a_mission_that_is_met_is_said_and_listed_in_the_report(missing):
    met = MISSION.replace("0.5", "0.05") + "  - {within_s: 30}\n"
    missing.write("cell.yaml", met)
    outcome = missing.run("run", "controller.py", "--report", "r.html")
    assert "success: 2 of 2 conditions met" in outcome.err
    page = missing.read("r.html").decode()
    assert "What the mission has to bring about" in page
    assert "over within 30 s" in page


def test_an_assumed_line_is_partial_where_it_is_missed_and_nothing_where_it_is_met(missing):
    missing.write("cell.yaml", MISSION.replace("}}", "}}  # assumed: as drafted"))
    outcome = missing.run("run", "controller.py", "--json")
    assert outcome.code == 0
    (reason,) = outcome.json["verdict"]["reasons"]
    assert (outcome.json["verdict"]["kind"], reason["code"]) == ("partial", "input-assumed")
    assert "nobody has confirmed this line of success" in reason["words"]
    missing.write("cell.yaml", "success:\n  - {joints: {panda_joint1: 0.05}}  # assumed\n")
    assert missing.run("run", "controller.py", "--json").json["verdict"]["reasons"] == []


def test_a_name_that_does_not_exist_is_an_error(missing):
    missing.write("cell.yaml", "success:\n  - {joints: {panda_joint_1: 0.5}}\n")
    outcome = missing.run("run", "controller.py")
    assert outcome.code == 2
    assert "cell.yaml:2" in outcome.err
    assert "unknown joint 'panda_joint_1' of robot 'panda'; did you mean" in outcome.err
    missing.write("cell.yaml", "success:\n  - {object: flor, moved: false}\n")
    outcome = missing.run("run", "controller.py")
    assert outcome.code == 2
    assert "unknown object 'flor' of the run; did you mean 'floor'?" in outcome.err


@pytest.mark.slow
def test_a_tube_in_the_wrong_slot_misses_its_goal(example, pick_and_place):
    source = pick_and_place.replace(b"TUBES = 10\n", b"TUBES = 1\n")
    call = b"place_position(arm, number)"
    assert call in source.split(b"def main")[1]
    example.write("pick_and_place.py", source)
    goal = "success:\n  - {object: tube_1, at: target_rack_slot_1}\n  - {object: tube_1}\n"
    example.write("cell.yaml", goal)
    good = example.run("run", "pick_and_place.py", "--scenario", "cell.yaml")
    assert good.code == 0, good.err
    head, main = source.split(b"def main")
    wrong = main.replace(call, b"place_position(arm, number + 1)")
    example.write("pick_and_place.py", head + b"def main" + wrong)
    outcome = example.run("run", "pick_and_place.py", "--scenario", "cell.yaml", "--json")
    assert outcome.code == 1
    missed = [e for e in outcome.json["verdict"]["reasons"] if e["code"] == "mission-missed"]
    (reason,) = missed
    assert reason["object"] == "tube_1"
    assert "from target_rack_slot_1 (at most 10 mm allowed)" in reason["words"]
    assert reason["location"]["line"] == 2


CALLS = """\
services:
  - {name: /glue/enable, type: std_srvs/SetBool, reply: {success: true}}
actions:
  - {name: /move_base, type: move_base_msgs/MoveBase}
success:
  - {called: /glue/enable, exactly: 2}
  - {called: /glue/enable, with: {data: true}, exactly: 1}
  - {sent: /status, with: {data: done}}
  - steps:
      - {called: /glue/enable, with: {data: true}}
      - {called: /move_base, with: {target_pose: {header: {frame_id: map}}}}
      - {reached: {panda_joint1: 0.05}}
      - {called: /glue/enable, with: {data: false}}
"""


def test_calls_of_the_cell_are_counted_with_their_fields_and_their_order(example, quick):
    before = (
        "from std_srvs.srv import SetBool",
        "from std_msgs.msg import String",
        "import actionlib",
        "from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal",
        "status = rospy.Publisher('/status', String, queue_size=1)",
        "base = actionlib.SimpleActionClient('/move_base', MoveBaseAction)",
        "base.wait_for_server()",
        "goal = MoveBaseGoal()",
        "goal.target_pose.header.frame_id = 'map'",
        "glue = rospy.ServiceProxy('/glue/enable', SetBool)",
    )
    steps = ("glue(True)", "base.send_goal_and_wait(goal)", "arm.go(wait=True)", "glue(False)")
    done = "status.publish('done')"
    example.write("cell.yaml", CALLS)

    def reasons(*statements):
        source = quick(*before, *statements)
        moved = "    arm.go(joints, wait=True)\n"
        assert moved in source
        # The motion comes where the statements say.
        source = source.replace(moved, "").replace(
            "arm.go(wait=True)\n    glue(", moved.strip() + "\n    glue("
        )
        example.write("controller.py", source)
        outcome = example.run("run", "controller.py", "--scenario", "cell.yaml", "--json")
        found = outcome.json["verdict"]["reasons"]
        return [e["words"] for e in found if e["code"] == "mission-missed"]

    assert reasons(*steps, done) == []
    swapped = reasons("glue(False)", *steps[1:3], "glue(True)", done)
    assert len(swapped) == 1
    assert swapped[0].startswith("step 2 (called /move_base with target_pose.header.frame_id map")
    assert reasons(*steps) == [
        "/status was published to 0 times with data = done (at least 1 time asked)"
    ]
