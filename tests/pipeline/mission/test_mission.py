"""What `success` of a scenario declares, judged of a run that is made by hand."""

import math
from dataclasses import replace

import pytest

from tests.pipeline.mission.made_mission import FACTS, PANDA, SCENE, track
from tracerisk.errors import ScenarioError
from tracerisk.pipeline.mission.asked_calls import AskedCall
from tracerisk.pipeline.mission.judged import missed
from tracerisk.pipeline.mission.named_objects import check_names, check_objects
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.scenario import Scenario


@pytest.mark.parametrize(
    "entry",
    [
        "{object: part}",
        "{object: part, at: slot_1}",
        "{object: part, at: [0.5, 0.0, 0.03]}",
        "{object: part, at: tray, within: 0.05}",
        "{object: part, at: [0.0, 0.008, 0.03], of: tray, within: 0.001}",
        "{object: part, at: [0.0, -0.008, 0.03], of: pallet, within: 0.001}",
        "{object: part, tilt: 0.05, rests_on: tray}",
        "{object: part, moved: true}",
        "{object: lid, moved: false}",
        "{joints: {panda_joint1: 0.79}}",
        "{reached: {panda_joint1: 0.0, panda_joint2: 0.0}}",
        "{passed: {panda_joint1: 0.4}}",
        "{visited: place}",
        "{visited: place, exactly: 1}",
        "{called: /glue/enable, times: 2}",
        "{called: glue/enable, exactly: 2}",
        "{called: /glue/enable, with: {on: true, setting: {flow: 0.3}}, exactly: 1}",
        "{called: /glue/disable, exactly: 0}",
        "{sent: /status, times: 5}",
        "{within_s: 2.0}",
        "{steps: [{called: /glue/enable}, {object: part, held_by: hand}, "
        "{object: part, rests_on: tray}, {called: /glue/enable, with: {on: false}}]}",
        "{steps: [{reached: {panda_joint1: 0}}, {passed: {panda_joint1: 0.4}}, "
        "{joints: {panda_joint1: 0.8}}]}",
        "{steps: [{called: /glue/enable}, {called: /glue/enable}]}",
    ],
)
def test_what_the_run_brought_about_is_met(read, entry):
    assert missed(read(entry), FACTS) == ()


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("{object: part, within: 0.005}", "part ends 8 mm from slot_1, the nearest goal (at most"),
        ("{object: part, at: slot_2}", "part ends 32 mm from slot_2 (at most 10 mm allowed)"),
        ("{object: part, at: tray}", "part ends 31 mm from tray (at most 10 mm allowed)"),
        ("{object: part, at: [0.5, 0.0, 0.06]}", "31 mm from (0.5, 0, 0.06) (at most 10 mm allow"),
        ("{object: part, at: [0, 0.008, 0.03], of: pallet}", "16 mm from its place on pallet (at"),
        ("{object: lid, tilt: 0.1}", "lid ends leaning 40.1 degrees (at most 5.73 allowed)"),
        ("{object: part, rests_on: floor}", "part rests on tray at the end, not on floor"),
        ("{object: part, rests_on: table}", "part rests on tray at the end, not on table"),
        ("{object: part, held_by: hand}", "part is not held by hand at the end"),
        ("{object: part, moved: false}", "part ends 192 mm from where it began (at most 5 mm all"),
        ("{object: lid, moved: true}", "lid ends 0 mm from where it began (more than 5 mm asked)"),
        ("{object: bolt, moved: true}", "there was no object 'bolt' in the run: bolt moved by"),
        ("{joints: {panda_joint1: 0.5}}", "the arm ends 0.3 from panda_joint1 = 0.5 (at most 0.0"),
        ("{reached: {panda_joint1: 0.6}}", "never stops at the declared pose; it comes nearest at"),
        ("{passed: {panda_joint1: 1.0}}", "never passes the declared pose; it comes nearest at 1."),
        ("{visited: place, times: 2}", "place succeeded 1 time (at least 2 times asked)"),
        ("{called: /glue/enable, exactly: 3}", "/glue/enable was called 2 times (3 times asked)"),
        ("{called: /glue/enable, exactly: 1}", "/glue/enable was called 2 times (1 time asked)"),
        ("{called: /glue/enable, with: {on: 7}}", "was called 0 times with on = 7 (at least 1 ti"),
        ("{sent: /status, times: 6}", "/status was published to 5 times (at least 6 times asked)"),
        ("{within_s: 1.9}", "the run ends at 2 s (at most 1.9 s allowed)"),
        (
            "{steps: [{object: part, held_by: hand}, {called: /glue/enable, with: {on: true}}]}",
            "step 2 (called /glue/enable with on True 1 time) does not come after step 1 (part "
            "held by hand), which came at 0.5 s: it came last at 0.2 s",
        ),
        (
            "{steps: [{called: /glue/enable, times: 2}, {called: /glue/enable}]}",
            "step 2 (called /glue/enable 1 time) does not come after step 1",
        ),
        ("{steps: [{visited: place}, {visited: wipe}]}", "step 2 (visited wipe 1 time) never came"),
    ],
)
def test_what_it_did_not_is_missed_with_what_was_found_and_asked(read, entry, words):
    (found,) = missed(read(entry), FACTS)
    assert words in found.words
    assert found.condition.location.line == 2


def test_a_link_is_where_the_joints_bring_it(read):
    at_end = missed(read("{link: panda_link8, at: [0, 0, 0]}"), FACTS)
    assert "panda_link8 ends" in at_end[0].words
    # With all joints at 0 but the first, the flange is 88 mm before the axis, at 0.926 m.
    x, y = 0.088 * math.cos(0.8), 0.088 * math.sin(0.8)
    assert missed(read(f"{{link: panda_link8, at: [{x:.4f}, {y:.4f}, 0.926]}}"), FACTS) == ()
    before = "{reached: {panda_link8: [0.088, 0, 0.926]}, within: 0.002}"
    assert missed(read(before), FACTS) == ()


def test_what_leans_at_its_goal_or_floats_above_it_is_missed(read):
    (condition,) = read("{object: part}")
    leaning = track((0.5, 0.2, 0.03), (0.5, 0.1, 0.3), (0.5, 0.0, 0.03), rpy=(0.5, 0.0, 0.0))
    high = track((0.5, 0.2, 0.03), (0.5, 0.1, 0.3), (0.5, 0.0, 0.05))
    for there, words in ((leaning, "leans 28.6 degrees at slot_1"), (high, "ends 20 mm above")):
        (found,) = missed([condition], replace(FACTS, tracks={**FACTS.tracks, "part": there}))
        assert words in found.words


def test_a_field_that_a_message_lacks_is_named_with_those_it_has(read):
    lacking = AskedCall("/glue/enable", 0.2, {}, {"onn": ["flow", "on"]})
    (found,) = missed(
        read("{called: /glue/enable, with: {onn: true}}"), replace(FACTS, calls=(lacking,))
    )
    assert "it has no field 'onn', but flow, on" in found.words


def test_of_a_run_that_simulated_nothing_every_state_is_missed(read):
    found = missed(read("{object: part}", "{within_s: 9}"), replace(FACTS, samples=None))
    assert [each.condition.kind for each in found] == ["object"]
    assert "nothing was simulated" in found[0].words


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("{joints: {panda_joint9: 0}}", "unknown joint 'panda_joint9' of robot 'panda'; did you"),
        ("{link: hand, at: [0, 0, 0]}", "unknown link 'hand' of robot 'panda'"),
        ("{object: part, held_by: gripper}", "unknown gripper or link 'gripper' of the robot"),
        ("{passed: {tool: [0, 0, 0]}}", "unknown link 'tool'"),
        ("{steps: [{joints: {j: 0}}, {called: /a}]}", "unknown joint 'j'"),
    ],
)
def test_what_the_robot_lacks_is_an_error_with_what_it_has(read, entry, message):
    with pytest.raises(ScenarioError) as raised:
        check_names(Scenario(success=read(entry)), PANDA, SCENE)
    assert message in raised.value.message
    assert "panda" in raised.value.message
    assert raised.value.location.line == 2


def test_a_goal_is_asked_of_a_scene_that_has_some(read):
    with pytest.raises(ScenarioError, match="scene 'cell' has no goals; say where part is to end"):
        check_names(Scenario(success=read("{object: part}")), PANDA, replace(SCENE, goals=()))


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("{object: prat, moved: true}", "unknown object 'prat' of the run; did you mean 'part'?"),
        ("{object: part, at: slot_9}", "unknown goal, object or frame 'slot_9' of the run; did y"),
        ("{object: part, at: [0, 0, 0], of: palet}", "unknown object or frame 'palet' of the run"),
        (
            "{object: part, rests_on: trey}",
            "unknown object 'trey' of the run; did you mean 'tray'?",
        ),
    ],
)
def test_an_unknown_object_or_frame_is_an_error_with_the_valid_names(read, entry, message):
    with pytest.raises(ScenarioError) as raised:
        check_objects(read(entry), SCENE, FACTS.frames, FACTS.tracks)
    assert message in raised.value.message


def test_a_frame_on_a_moving_link_is_refused(tmp_path):
    path = tmp_path / "cell.yaml"
    path.write_text(
        "frames:\n  - {frame: camera, parent: panda_hand}\n"
        "success:\n  - {object: part, at: camera}\n"
    )
    with pytest.raises(ScenarioError, match="frame 'camera' hangs on 'panda_hand', whose place"):
        check_names(read_scenario(path), PANDA, SCENE)


def test_a_mark_makes_a_condition_assumed_and_no_input(tmp_path):
    path = tmp_path / "cell.yaml"
    path.write_text(
        "answers:\n  - go  # assumed\n"
        "success:\n"
        "  - {object: part, at: tray}\n"
        "  - {object: part, moved: true}  # assumed: as the run of today\n"
    )
    read = read_scenario(path)
    assert [each.is_assumed for each in read.success] == [False, True]
    assert [each.section for each in read.unconfirmed] == ["answers"]
