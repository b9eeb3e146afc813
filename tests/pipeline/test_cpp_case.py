"""The published case study on a C++ controller: annotated from its log, checked, reviewed."""

from dataclasses import replace

import pytest

from tests.pipeline.test_published_case import HARDWARE, LOG, PUBLISHED, printed
from tracerisk.adder.sources.insert import insert_blocks
from tracerisk.common import dependencies, trace_json
from tracerisk.common.traced.findings import Finding
from tracerisk.common.verdict import Reason, Verdict
from tracerisk.errors import DependencyError
from tracerisk.pipeline.scenarios.trace_controller import nothing_commanded
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.trace import LIVE

pytest.importorskip("tree_sitter_cpp", reason="the extra cpp is not installed")

CONTROLLER = """\
#include <moveit/move_group_interface/move_group_interface.h>

using moveit::planning_interface::MoveGroupInterface;

class Cell
{
public:
  void init();
  void pick_position(const geometry_msgs::Pose& tube);
  void pick()
  {
    hand_.setNamedTarget("close");
    hand_.move();
  }
  void place_position(const geometry_msgs::Pose& slot);
  void place();

private:
  MoveGroupInterface arm_{ "panda_arm" }, hand_{ "hand" };
};

void Cell::init()
{
  arm_.setNamedTarget("ready");
  arm_.move();
}

void Cell::pick_position(const geometry_msgs::Pose& tube)
{
  arm_.setPoseTarget(tube);
  arm_.move();
}

void Cell::place_position(const geometry_msgs::Pose& slot)
{
  arm_.setPoseTarget(slot);
  arm_.move();
}

void Cell::place()
{
  hand_.setNamedTarget("open");
  hand_.move();
}

int main(int argc, char** argv)
{
  ros::init(argc, argv, "cell");
  Cell cell;
  do { cell.init(); cell.pick_position({}); cell.pick(); cell.place_position({}); cell.place(); }
  while (ros::ok());
}
"""
ANNOTATE = ("annotate", "cell.cpp", "--log", "run.log", "--hardware", "hardware.yaml")


@pytest.fixture
def case(repository):
    repository.write("cell.cpp", CONTROLLER)
    repository.write("run.log", LOG)
    repository.write("hardware.yaml", HARDWARE)
    assert repository.run(*ANNOTATE).code == 0
    return repository


def test_the_ten_published_figures_come_out_of_a_cpp_file(case):
    text = case.read("cell.cpp").decode()
    at = text.index(
        "name = electric_motor",
        text.index("void Cell::place_position(const geometry_msgs::Pose& slot)\n{"),
    )
    pinned = "probability := 1.30644e-07  ! computed 9.5e-08; payload"
    changed = text[:at] + text[at:].replace("probability = 9.5e-08", pinned, 1)
    case.write("cell.cpp", changed)
    again = case.run(*ANNOTATE)
    assert again.code == 0, again.err
    assert pinned in case.read("cell.cpp").decode()
    solved = case.run(
        "solve", "cell.cpp", "--json", "--profile", "Cell::place:Cell::init=0.9,done=0.1"
    )
    assert solved.code == 0, solved.err
    found = printed(solved.json["assessment"])
    assert found == {f"Cell::{name}": figures for name, figures in PUBLISHED.items()}
    pins = case.run("overrides", "cell.cpp")
    assert "1.30644e-07" in pins.out
    assert "payload" in pins.out


def test_a_check_is_fine_until_the_code_says_something_else(case):
    assert case.run("check", "cell.cpp").code == 0
    text = case.read("cell.cpp").decode()
    spaced = text.replace("  arm_.move();", "  arm_.move();  // goes there\n\n")
    case.write("cell.cpp", spaced)
    assert case.run("check", "cell.cpp").code == 0
    case.write("cell.cpp", text.replace('"ready"', '"home"'))
    stale = case.run("check", "cell.cpp")
    assert stale.code == 1
    assert "stale: cell.cpp has changed" in stale.out


def test_blocks_that_no_lock_knows_are_reported(case):
    case.write("copy.cpp", case.read("cell.cpp").decode())
    outcome = case.run("check", "copy.cpp")
    assert outcome.code == 1
    assert "tracerisk.lock knows nothing of its 5 risk blocks" in outcome.out
    assert "`tracerisk annotate copy.cpp --trace TRACE`" in outcome.out


def test_an_edited_value_is_reported(case):
    text = case.read("cell.cpp").decode()
    case.write("cell.cpp", text.replace("quantity = 7", "quantity = 6", 1))
    edited = case.run("check", "cell.cpp")
    assert edited.code == 3
    assert "edited: Cell::pick.electric_motor.quantity is 6" in edited.out


def test_strip_gives_back_the_bytes_and_refuses_to_lose_a_pin(case):
    text = case.read("cell.cpp").decode()
    case.write("cell.cpp", text.replace("quantity = 7", "quantity := 8  ! one more", 1))
    refused = case.run("strip", "cell.cpp")
    assert refused.code != 0
    assert "would be lost" in refused.err
    case.write("cell.cpp", text)
    assert case.run("strip", "cell.cpp").code == 0
    assert case.read("cell.cpp").decode() == CONTROLLER


def test_a_block_follows_its_function_to_a_new_name(case):
    text = case.read("cell.cpp").decode()
    renamed = text.replace("void pick()\n", "void grab()\n").replace("cell.pick()", "cell.grab()")
    case.write("cell.cpp", renamed)
    case.write("run.log", LOG.replace("pick()", "grab()"))
    reported = case.run("check", "cell.cpp")
    assert "the function of the block `Cell::pick` is called `Cell::grab` now" in reported.out
    assert case.run(*ANNOTATE).code == 0
    after = case.read("cell.cpp").decode()
    assert "name = Cell::grab" in after
    assert "next = Cell::grab 1" in after
    assert "Cell::pick 1" not in after


def test_a_diff_says_what_a_change_does_to_the_risk(case):
    case.commit()
    text = case.read("hardware.yaml").decode()
    case.write("hardware.yaml", text.replace("7.344e-08", "7.344e-07"))
    assert case.run(*ANNOTATE).code == 0
    reported = case.run("diff", "HEAD")
    assert "no verdict: a log of C or C++ has none" in reported.out
    assert "cell.cpp: mission failure rises" in reported.out
    assert "through gripper" in " ".join(reported.out.split())


FINDINGS = tuple(Finding("planning_failure", f"no plan to {name}") for name in ("pick", "place"))
LOST = Reason("error-logged", "faulted", "it logged ERROR: lost a tube")


@pytest.fixture
def lived(case, short_trace):
    """Return what annotates the case from a live run of its node with reasons for a verdict."""

    def annotate(*reasons):
        kind = reasons[0].verdict if reasons else "complete"
        trace = replace(
            short_trace,
            assumptions=(LIVE, *short_trace.assumptions),
            verdict=Verdict(kind, reasons),
        )
        text = trace_json.dumps(trace).replace('"pick_and_place.py"', '"cell.cpp"')
        for name in ("init", "pick_position", "pick", "place_position", "place"):
            text = text.replace(f'"name": "{name}"', f'"name": "Cell::{name}"')
        case.write("live.json", text)
        return case.run("annotate", "cell.cpp", "--trace", "live.json")

    return annotate


def test_a_diff_compares_the_verdicts_of_live_runs(case, lived):
    assert lived().code == 0
    case.commit()
    assert lived(LOST).code == 0
    reported = case.run("diff", "HEAD", "--max-increase", "0.1")
    assert reported.code == 1
    said = " ".join(reported.out.split())
    assert said.startswith(f"faulted: {LOST}; ")
    assert "cell.cpp was complete, is faulted; the two runs cannot be compared" in said
    assert f"cell.cpp: its run is faulted: {LOST}; " in reported.err


def test_a_log_takes_the_verdict_of_a_live_run_away_and_it_is_said(case, lived):
    assert lived().code == 0
    case.commit()
    assert case.run(*ANNOTATE).code == 0
    reported = case.run("diff", "HEAD", "--max-increase", "0.1")
    assert reported.code == 1
    given = "`tracerisk annotate cell.cpp --trace TRACE` of a live run gives it one"
    assert f"the verdict of its run is unknown and was known before; {given}" in reported.err
    assert given in " ".join(reported.out.split())


def test_a_run_that_commanded_nothing_names_the_live_command_that_shows_more(case, short_trace):
    controller = load_controller(case.folder / "cell.cpp")
    said = str(nothing_commanded(replace(short_trace, findings=FINDINGS), controller))
    assert "(and 1 more, which `tracerisk trace " in said
    assert "cell.cpp --live -- COMMAND` prints)" in said


def test_the_trace_of_a_run_that_was_stuck_names_the_command_of_another(lived):
    refused = lived(Reason("run-died", "stuck", "./cell was ended by SIGABRT"))
    assert refused.code == 2
    assert "`tracerisk trace cell.cpp -o live.json --live -- COMMAND` makes another" in refused.err


def test_a_log_whose_short_name_fits_several_functions_is_refused(case):
    text = case.read("cell.cpp").decode()
    case.write("cell.cpp", text + "\nvoid Other::place()\n{\n  go();\n}\n")
    refused = case.run(*ANNOTATE)
    assert refused.code == 2
    assert "may be Cell::place or Other::place" in refused.err


@pytest.mark.parametrize("verb", ["run", "trace"])
def test_cpp_is_run_live_alone_and_it_is_said_what_to_do(case, verb):
    refused = case.run(verb, "cell.cpp")
    assert refused.code == 2
    assert "`tracerisk run cell.cpp --live -- COMMAND`" in refused.err
    assert "tracerisk annotate FILE --log LOG" in refused.err


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "verb", [("evidence",), ("mutate",), ("run", "--fault", "panda_hand:stuck@1")]
)
def test_what_repeats_runs_exactly_refuses_cpp(case, verb):
    refused = case.run(*verb, "cell.cpp")
    assert refused.code == 2
    assert "is C or C++, whose node runs live alone" in refused.err


def test_without_the_extra_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setattr(dependencies, "is_installed", lambda name: "tree-sitter" not in name)
    with pytest.raises(DependencyError, match=r"pip install 'tracerisk\[cpp\]'"):
        insert_blocks(CONTROLLER.encode(), {}, "cell.cpp")
