"""`run --fault`: the same run with a unit that fails, which writes nothing that stays."""

import numpy as np
import pytest

from tracerisk.twin.recording.samples import read_samples

JAMMED = ("--fault", "panda_joint1:jam@0.3")


@pytest.fixture
def moving(example, quick):
    """A folder with a controller that has turned `panda_joint1` after about a second."""
    example.write("controller.py", quick())
    return example


@pytest.fixture(scope="module")
def jammed(tmp_path_factory, example_in, quick):
    """Such a folder after a run with a fault, with its report and recording, and the outcome."""
    folder = example_in(tmp_path_factory.mktemp("jammed"))
    folder.write("controller.py", quick())
    more = ("--report", "out.html", "--keep", "kept")
    outcome = folder.run("run", "controller.py", *JAMMED, *more)
    assert outcome.code == 0, outcome.err
    return folder, outcome


def test_a_run_with_a_fault_prints_its_effect(jammed):
    _, outcome = jammed
    lines = outcome.out.splitlines()
    assert lines[0] == (
        "run with a fault: panda_joint1 jam at 0.300 s; risk blocks and lock stay unchanged"
    )
    assert lines[1] == "without the fault: partial, 2 of 3 functions with commands ran"
    assert any(line.startswith("with the fault: faulted") for line in lines)
    (reported,) = (
        at for at, line in enumerate(lines) if line.startswith("reported to the controller")
    )
    assert "s after the fault" in lines[reported]
    assert "joint 'panda_joint1' is" in lines[reported + 1]
    assert "controller.py on panda" in outcome.err, "the run without is told as soon as it is over"


def test_it_leaves_blocks_lock_and_kept_trace_of_an_earlier_run(annotated):
    cache = annotated.folder / ".tracerisk_cache"
    annotated.run("run", "controller.py", "--quiet")
    before = annotated.files()
    kept = {path.name: path.read_bytes() for path in cache.iterdir()}
    outcome = annotated.run("run", "controller.py", *JAMMED)
    assert outcome.code == 0, outcome.err
    assert annotated.files() == before
    assert {path.name: path.read_bytes() for path in cache.iterdir()} == kept
    assert annotated.run("check", "controller.py").code == 0


def test_a_report_is_written_where_one_is_asked_for(jammed):
    folder, _ = jammed
    page = folder.read("out.html").decode()
    assert "A run with a fault: panda_joint1 jam at 0.300 s." in page
    assert "fault: panda_joint1 jam at 0.300 s, as asked for" in page
    assert 'id="replay' in page
    assert "Probability" not in page, "a run with a fault has no figure of risk"


def test_what_is_kept_is_the_recording_of_the_run_with_the_fault(jammed):
    folder, _ = jammed
    samples = read_samples(folder.folder / "kept")
    position = samples.position[:, samples.header.joints.index("panda_joint1")]
    begin = round(0.3 / samples.step_s)
    assert np.ptp(position[:begin]) > 1e-3
    assert np.ptp(position[begin + 1 :]) < 1e-4


@pytest.mark.slow
def test_it_writes_neither_blocks_nor_lock_nor_a_kept_trace_and_json_says_the_same(moving):
    before = moving.files()
    first, second = (moving.run("run", "controller.py", *JAMMED, "--json") for _ in range(2))
    assert moving.files() == before
    assert not (moving.folder / ".tracerisk_cache").exists()
    assert first.out == second.out
    jam = {"mode": "jam", "time_s": 0.3, "unit": "panda_joint1", "lasts_s": None}
    assert first.json["faults"] == [jam]
    assert first.json["reported"][0]["after_s"] > 0.0
    assert first.json["nominal"]["verdict_line"].startswith("partial")
    assert first.json["verdict"]["kind"] == "faulted"


def test_a_fault_that_nothing_needs_changes_nothing(moving):
    outcome = moving.run("run", "controller.py", "--fault", "panda_hand:stuck@0.3")
    assert "reported to the controller: no failure beyond those without the fault" in outcome.out
    assert "other changes" not in outcome.out


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("panda_joint1", "expected UNIT:MODE@SECONDS, such as"),
        ("panda_joint1:broken@1", "unknown mode 'broken'; allowed: absent, dead, frozen, jam"),
        ("panda_joint1:jam@soon", "'soon' is not a time in seconds from 0"),
        ("panda_joint9:jam@0.3", "has no unit 'panda_joint9' that can fail; did you mean"),
        # tests/twin/faults/test_faults.py has the same words.
        pytest.param(
            "panda_joint1:opens@0.3",
            "has no mode 'opens'; allowed: dead, jam",
            marks=pytest.mark.slow,
        ),
        ("panda_joint1:jam@30", "the run without a fault ends at"),
    ],
)
def test_a_bad_fault_lists_what_is_allowed(moving, fault, message):
    outcome = moving.run("run", "controller.py", "--fault", fault)
    assert outcome.code == 2
    assert message in outcome.err


@pytest.mark.parametrize(
    "option", [("--check",), ("--trace", "t.json"), ("--log", "l.txt"), ("--fail-on", "finding")]
)
def test_options_of_blocks_and_figures_do_not_go_with_it(moving, option):
    outcome = moving.run("run", "controller.py", *JAMMED, *option)
    assert outcome.code == 2
    assert f"{option[0]} does not go with --fault" in outcome.err


def test_a_controller_that_fails_without_a_fault_is_reported_as_ever(example, quick):
    example.write("controller.py", quick().replace("    act(arm)\n", "    raise OSError(5)\n"))
    given = ("run", "controller.py", "--no-draft")
    outcome = example.run(*given, *JAMMED)
    assert outcome.code == example.run(*given).code != 0
    assert "OSError" in outcome.err
