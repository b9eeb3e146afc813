"""What a search for a draft runs, what it leaves out again, and where it ends."""

from collections import Counter
from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.config import Settings
from tracerisk.pipeline.robot import kept_choices
from tracerisk.pipeline.run import attempts
from tracerisk.pipeline.scenarios import rounds
from tracerisk.pipeline.scenarios.entries import Attempt, Entries
from tracerisk.pipeline.scenarios.rounds import draft_scenario
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.drafts.draft import Draft

HEAD = """\
import sys
import moveit_commander, rospy
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool, Trigger

rospy.init_node("cell")
arm = moveit_commander.MoveGroupCommander("panda_arm")


def turn(angle):
    joints = arm.get_current_joint_values()
    joints[0] += angle
    arm.go(joints, wait=True)


"""
LIBRARY = """\
import rospy
from std_srvs.srv import SetBool, Trigger


class Cell:
    def __init__(self):
        self.clients = [rospy.ServiceProxy(f"/io/{n}", Trigger) for n in range(45)]
        self.lamp = rospy.ServiceProxy("/lamp", SetBool)
"""
ONE_OF_MANY = (
    HEAD.replace("import sys", "import sys\nfrom library import Cell")
    + "cell = Cell()\ncell.clients[7]()\nturn(0.1)\n"
)
WAITED_FOR = ONE_OF_MANY.replace("cell.clients[7]()", "cell.clients[7].wait_for_service()")
OWN_UNUSED = (
    HEAD + "lamp = rospy.ServiceProxy('/lamp', SetBool)\nrospy.ServiceProxy('/start', Trigger)()\n"
    "if len(sys.argv) > 9:\n    lamp(True)\nturn(0.1)\n"
)
OTHER_BRANCH = (
    HEAD + "rospy.wait_for_message('/go', Bool)\nif len(sys.argv) > 9:\n"
    "    rospy.wait_for_message('/late', String)\n    rospy.get_param('/late')\nturn(0.1)\n"
)


def _drafted(folder: Path, source: str) -> rounds.ScenarioDraft:
    (folder / "c.py").write_text(source)
    (folder / "library.py").write_text(LIBRARY)
    return draft_scenario(load_controller(folder / "c.py"), Settings(), None)


@pytest.mark.parametrize(
    ("source", "keys"),
    [
        (ONE_OF_MANY, {"/io/7"}),
        pytest.param(WAITED_FOR, {"/io/7"}, marks=pytest.mark.slow),
        pytest.param(OWN_UNUSED, {"/start"}, marks=pytest.mark.slow),
        (OTHER_BRANCH, {"/go"}),
    ],
    ids=["called", "waited for", "own client not called", "branch that did not run"],
)
def test_only_what_a_run_makes_use_of_is_drafted(tmp_path, source, keys):
    draft = _drafted(tmp_path, source)
    assert {each.key for each in draft.given} == keys
    assert draft.trace is not None
    assert draft.trace.verdict.kind == "partial"
    assert {each.object for each in draft.trace.verdict.reasons} == keys


def test_a_marked_entry_that_no_run_uses_is_no_reason_and_an_unmarked_one_is(example):
    example.write("c.py", HEAD + "rospy.ServiceProxy('/start', Trigger)()\nturn(0.1)\n")
    example.write(
        "s.yaml",
        "services:\n"
        "  - name: /start  # assumed\n    type: std_srvs/Trigger\n"
        "  - name: /lamp  # assumed: a guess\n    type: std_srvs/SetBool\n"
        "publish:\n  - topic: /part\n    type: std_msgs/String  # assumed\n    message: {data: a}\n"
        "parameters:\n  ~speed: 0.1\n  ~far: 0.1  # assumed\n",
    )
    ran = example.run("run", "c.py", "--check", "--json", "--scenario", "s.yaml")
    reasons = {(each["code"], each["words"][:40]) for each in ran.json["verdict"]["reasons"]}
    assert reasons == {
        ("input-assumed", "services /start of the scenario is assum"),
        ("unused-input", "in the scenario, but nobody asked for pa"),
    }
    unused = [each for each in ran.json["trace"]["findings"] if each["kind"] == "unused"]
    assert {each["object"] for each in unused} == {
        "", "services /lamp", "publish /part", "parameters ~far"
    }  # fmt: skip


def test_the_workspace_is_read_once_for_all_runs(tmp_path, monkeypatch):
    counts: Counter[str] = Counter()
    for name in ("choose_launch", "choose_launched_robot"):
        monkeypatch.setattr(kept_choices, name, _counted(kept_choices, name, counts))
    monkeypatch.setattr(attempts, "run_controller", _counted(attempts, "run_controller", counts))
    draft = _drafted(
        tmp_path, HEAD + "cell = rospy.get_param('/' + 'cell')\nrospy.get_param(cell)\nturn(0.1)\n"
    )
    assert len(draft.given) == 2
    assert counts == {"choose_launch": 1, "choose_launched_robot": 1, "run_controller": 3}


FRAMES = (
    HEAD.replace("import sys", "import sys, tf")
    + "places = tf.TransformListener()\nrospy.sleep(1.0)\nturn(0.1)\n"
    "places.lookupTransform('panda_link0', 'pickup', rospy.Time(0))\nturn(0.1)\n"
    "places.lookupTransform('panda_link0', 'place', rospy.Time(0))\nturn(0.1)\n"
    "places.lookupTransform('panda_link0', 'panda_hand', rospy.Time(0))\n"
)


@pytest.mark.slow
def test_all_frames_that_a_script_names_are_drafted_together(tmp_path, monkeypatch):
    counts: Counter[str] = Counter()
    monkeypatch.setattr(attempts, "run_controller", _counted(attempts, "run_controller", counts))
    draft = _drafted(tmp_path, FRAMES)
    assert [each.key for each in draft.given] == ["pickup", "place"]
    assert draft.trace.verdict.kind == "partial"
    assert counts == {"run_controller": 2}


def _counted(module, name, counts):
    called = getattr(module, name)

    def counting(*args, **kwargs):
        counts[name] += 1
        return called(*args, **kwargs)

    return counting


FRUITLESS = {
    "a fault that no value mends": (
        HEAD + "for name in 'abcdefghi':\n    rospy.Subscriber('/' + name, String, print)\n"
        "rospy.wait_for_message('/job', String)\nrospy.sleep(2.0)\nraise ValueError('no job')\n"
    ),
    "words of a command line": (
        HEAD + "for word in 'abcdefghi':\n    if len(sys.argv) > 1 and sys.argv[1] == word:\n"
        "        pass\n"
        + "".join(f"if len(sys.argv) > 1 and sys.argv[1] == '{n}':\n    pass\n" for n in range(9))
    ),
}


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("source", FRUITLESS.values(), ids=FRUITLESS)
def test_a_search_that_comes_nowhere_ends(tmp_path, monkeypatch, source):
    counts: Counter[str] = Counter()
    monkeypatch.setattr(attempts, "run_controller", _counted(attempts, "run_controller", counts))
    draft = _drafted(tmp_path, source)
    assert not draft.trace.functions
    assert counts["run_controller"] <= 7


@pytest.mark.slow
def test_a_run_of_a_search_has_what_is_left_of_its_computing(tmp_path):
    busy = (
        HEAD + "rospy.wait_for_message('/go', Bool)\nn = 0\nwhile not rospy.is_shutdown():\n    "
        "n += 1\n"
    )
    (tmp_path / "c.py").write_text(busy)
    found = draft_scenario(load_controller(tmp_path / "c.py"), Settings(), None, own_s=0.05)
    assert found.cut == "the search was ended after 0.05 s (--search-limit)"
    assert [each.key for each in found.given] == ["/go"]


def test_answers_that_a_run_assumes_are_drafted(tmp_path):
    menu = (
        "while True:\n    said = input('Which? ')\n    if said == 'go':\n        turn(0.1)\n"
        "    elif said == 'end':\n        break\n"
    )
    draft = _drafted(tmp_path, HEAD + menu)
    assert [each.need.kind for each in draft.given] == ["input"]
    answers = [line.split()[1] for line in draft.text.splitlines() if line.startswith("  - ")]
    assert answers == ["go", "end"]


def test_a_search_ends_with_its_wall_time(tmp_path, monkeypatch):
    monkeypatch.setattr(rounds, "_MOST_WALLS", 0.02)
    waits = HEAD + "n = 0\nwhile not rospy.is_shutdown():\n    n += 1\n"
    (tmp_path / "c.py").write_text(waits)
    found = draft_scenario(load_controller(tmp_path / "c.py"), Settings(), None)
    assert found.cut == "the search was ended after 1.2 s of wall time"
    assert found.text


LOOKS_UP = (
    HEAD.replace("import moveit_commander, rospy", "import moveit_commander, rospy, tf2_ros")
    + """\
rospy.ServiceProxy('/start', Trigger)()
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
buffer.lookup_transform('panda_link0', '{frame}', rospy.Time(0), rospy.Duration(1.0))
turn(0.1)
"""
)


@pytest.mark.parametrize(
    ("frame", "meant"),
    slow_but(
        [("panda_hnad", "panda_hand")],
        [
            ("pand_link8", "panda_link8"),
            ("panda_link08", "panda_link8"),
            ("panda_hnad", "panda_hand"),
            ("panda_Link7", "panda_link7"),
        ],
    ),
)
def test_a_frame_whose_name_is_a_slip_is_not_drafted(tmp_path, frame, meant):
    draft = _drafted(tmp_path, LOOKS_UP.format(frame=frame))
    assert [each.key for each in draft.given] == ["/start"]
    (missing,) = draft.missing
    assert (missing.key, missing.words) == (frame, f"likely a mistake for {meant}")
    assert f"# frame {frame}: likely a mistake for {meant}" in draft.text


@pytest.mark.slow
def test_a_frame_that_is_near_none_is_drafted(tmp_path):
    draft = _drafted(tmp_path, LOOKS_UP.format(frame="part_0"))
    assert {each.key for each in draft.given} == {"/start", "part_0"}


def test_a_run_says_which_frame_is_likely_meant(example):
    example.write("c.py", LOOKS_UP.format(frame="pand_link8"))
    ran = example.run("run", "c.py")
    assert ran.code == 4
    assert "frame pand_link8 is likely a mistake for panda_link8 (c.py:19)" in ran.err
    assert b"RiskAnnotation" not in example.read("c.py")


def test_a_parameter_has_another_value_only_where_that_makes_the_run_show_risk(tmp_path):
    (tmp_path / "c.py").write_text(HEAD)
    search = rounds.Rounds(
        load_controller(tmp_path / "c.py"), Settings(), None, None, kept_choices.KeptChoices()
    )
    need = Need("parameter", "mode", "string")
    mode = Draft(need, "mode", "topic", "as the code compares it", None, ("sine",), is_instead=True)
    go = Draft(Need("topic", "/go", "std_msgs/Bool"), "/go", {"topic": "/go"}, "a value")
    search.supply.instead[mode.section, mode.key] = mode
    search.best = Attempt(Entries({(go.section, go.key): go}))
    tried = list(search.supply.with_other_defaults(search.best.entries))
    assert [[each.value for each in entries.drafts.values()] for entries in tried] == [
        [{"topic": "/go"}, "topic"],
        [{"topic": "/go"}, "sine"],
    ]
    assert search._draft(Attempt(tried[0])).given == (go,)


def test_a_parameter_that_the_user_gives_stays(tmp_path):
    (tmp_path / "c.py").write_text(HEAD)
    (tmp_path / "s.yaml").write_text("parameters:\n  mode: zero\n")
    controller, kept = load_controller(tmp_path / "c.py"), kept_choices.KeptChoices()
    mode = Draft(Need("parameter", "/cell/mode"), "/cell/mode", "topic", "", None, is_instead=True)
    base = tmp_path / "s.yaml"
    for settings, given, is_set in (
        (Settings(), base, True),
        (Settings(args=("_mode:=zero",)), None, True),
        (Settings(params=("p.yaml",)), None, True),
        (Settings(), None, False),
    ):
        search = rounds.Rounds(controller, settings, given, None, kept)
        search.supply.note_defaults((mode,))
        assert (mode.key not in [key for _, key in search.supply.instead]) is is_set
