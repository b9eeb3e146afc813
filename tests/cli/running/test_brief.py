"""What a run prints on a terminal fits a screen; `-v` and a pipe have all of it."""

import os
import pty
import re
import subprocess
from argparse import Namespace

import pytest

from tests.conftest import program
from tracerisk.cli.running.shown import _caution, _following
from tracerisk.common.text.paper import Paper
from tracerisk.common.traced.findings import NOTHING_TO_GRASP, Finding
from tracerisk.common.verdict import Reason, Verdict
from tracerisk.prm.hybrid.solve import solve
from tracerisk.report.terminal import render_assessment, render_brief
from tracerisk.trace import RunEnd, Trace

_ESCAPES = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


@pytest.fixture(scope="module")
def assessed(tmp_path_factory, annotated_source):
    from tracerisk import api

    functions = {
        f"step_{number}": (
            f"step_{number + 1} 1" if number < 29 else "done 1",
            f"motor = {number + 1}e-7 x7; gripper = 1e-7; power = 1e-5 of2; control = 1e-9",
        )
        for number in range(30)
    }
    source = annotated_source(**functions).encode()
    return solve(api.build({"cell.py": source}, name="cell.py"))


@pytest.mark.parametrize("width", [60, 80, 120])
def test_thirty_functions_fit_a_screen(assessed, width):
    findings = [f"finding {number}" for number in range(9)]
    text = render_brief(assessed, findings=findings, following=["Next: look."], paper=Paper(width))
    lines = text.rstrip().splitlines()
    assert len(lines) <= (22 if width >= 80 else 25)
    assert all(len(line) <= width for line in lines)
    assert "8 of 30 functions, by share" in text
    assert "step_29" in text
    assert "step_1 " not in text
    assert "and 6 more findings" in text
    assert "Parts that matter most: motor" in text
    assert lines[-1] == "Next: look."


def test_what_follows_the_first_line_of_a_finding_is_set_in(assessed):
    finding = "cell.py:7: " + "the gripper closed on nothing " * 4
    text = render_brief(assessed, findings=[finding], paper=Paper(80))
    first, *others = text[text.index("- cell.py:7") :].split("\n")[:2]
    assert len(first) <= 80
    assert all(line.startswith("  ") for line in others)


def test_its_figures_are_those_of_the_whole(assessed):
    whole = render_assessment(assessed, paper=Paper(80))
    brief = render_brief(assessed, paper=Paper(80))
    assert brief.splitlines()[:2] == whole.splitlines()[:2]
    figure = re.search(r"step_29\s+(\S+)", brief)
    assert figure is not None
    assert figure[1] in whole


def on_a_terminal(folder, *words, codes=(0,), width=80):
    ours, theirs = pty.openpty()
    environment = {**os.environ, "COLUMNS": str(width), "TERM": "xterm"}
    process = subprocess.Popen(
        [*program(environment), *words],
        cwd=folder,
        stdout=theirs,
        stderr=subprocess.DEVNULL,
        env=environment,
    )
    os.close(theirs)
    parts = []
    while True:
        try:
            data = os.read(ours, 65536)
        except OSError:
            break
        if not data:
            break
        parts.append(data)
    os.close(ours)
    assert process.wait() in codes
    return _ESCAPES.sub("", b"".join(parts).decode()).replace("\r\n", "\n")


def test_a_run_on_a_terminal_is_brief_and_says_what_next(example, quick):
    example.write("controller.py", quick())
    planned = on_a_terminal(example.folder, "run", "controller.py", "--check", codes=(1,))
    assert "`tracerisk run controller.py` writes the blocks" in " ".join(planned.split())
    assert "commit the blocks" not in " ".join(planned.split())
    text = on_a_terminal(example.folder, "run", "controller.py")
    assert "commit the blocks" in " ".join(text.split())
    assert len(text.splitlines()) <= 25
    assert "Next: of `tracerisk run controller.py`, `-v` prints" in " ".join(text.split())
    assert "Assumptions" not in text
    whole = on_a_terminal(example.folder, "run", "controller.py", "-v")
    assert "Assumptions" in whole
    piped = example.run("run", "controller.py")
    assert "Assumptions" in piped.out


def test_the_columns_that_are_asked_for_hold_for_all_lines(example, quick):
    # The terminal itself says that it has none, as those of scripts do.
    example.write("controller.py", quick())
    for width in (60, 80):
        lines = on_a_terminal(example.folder, "doctor", "controller.py", width=width).splitlines()
        (line,) = (each for each in lines if each.startswith("physics: "))
        assert line.endswith(" built and stepped")
        assert 40 < len(line) <= width


def test_a_faulted_run_says_that_it_wants_mending(example, quick):
    example.write("controller.py", quick("raise SystemError('no tube')"))
    text = on_a_terminal(example.folder, "run", "controller.py", codes=(1, 4))
    assert "Next: mend what the verdict names" in " ".join(text.split())
    assert "commit the blocks" not in text


@pytest.mark.parametrize(("is_good", "what"), [(True, "went wrong"), (False, "was cut short")])
def test_only_a_run_that_did_not_end_by_itself_was_cut_short(is_good, what):
    end = RunEnd("ended" if is_good else "raised", "x", 19.1)
    verdict = Verdict("faulted", (Reason("planning-failed", "faulted", "no plan"),))
    trace = Trace("c.py", "panda", "empty", end, (), (), (), verdict=verdict)
    options = Namespace(controller="c.py", check=False, diff=False)
    assert _caution(trace).startswith(f"That is of what ran: the run {what},")
    (line,) = _following(options, trace, is_brief=True)
    assert line.endswith("then `tracerisk run c.py -v`, which prints all findings.")
    (line,) = _following(options, trace, is_brief=False)
    assert line.endswith("then `tracerisk run c.py` again.")


def test_a_run_names_all_that_is_to_be_done_next_causes_first():
    reasons = (
        Reason("error-logged", "faulted", "it logged ERROR"),
        Reason("robot-assumed", "partial", "the gripper is assumed", object="gripper"),
    )
    empty = Finding(NOTHING_TO_GRASP, "gripper closed on nothing", 4.0)
    end = RunEnd("exited", "x", 19.1)
    verdict = Verdict("faulted", reasons)
    trace = Trace("c.py", "ur5e", "empty", end, (), (), (), findings=(empty,), verdict=verdict)
    options = Namespace(controller="c.py", check=False, diff=False)
    lines = _following(options, trace, is_brief=False)
    words = ["name the robot", "put objects", "mend what else the verdict names"]
    assert all(word in line for word, line in zip(words, lines, strict=True))


@pytest.mark.parametrize(("code", "is_gap"), [("never-ran", True), ("unmet-need", False)])
def test_what_never_ran_is_said_to_pass_check(code, is_gap):
    verdict = Verdict("partial", (Reason(code, "partial", "x"),))
    end = RunEnd("ended", "x", 1.0)
    trace = Trace("c.py", "panda", "empty", end, (), (), (), verdict=verdict)
    options = Namespace(controller="c.py", check=False, diff=False)
    text = " ".join(_following(options, trace, is_brief=False))
    assert ("`tracerisk check c.py` passes that" in text) is is_gap


def test_doctor_on_a_terminal_shows_what_was_set(example, quick):
    example.write("controller.py", quick())
    example.write("pyproject.toml", "[tool.tracerisk]\nseed = 3\n")
    text = on_a_terminal(example.folder, "doctor", "controller.py")
    assert "  seed = 3  (pyproject.toml:2, all controllers)" in text
    assert "(default)" not in text
    assert "by default: " in text
    assert "(default)" in example.run("doctor", "controller.py").out
