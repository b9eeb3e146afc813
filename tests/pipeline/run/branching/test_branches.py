"""Branches of one run equal runs from the beginning, and lose nothing but themselves."""

import random
import subprocess
import textwrap
from pathlib import Path

import pytest

from tracerisk.api import load_settings
from tracerisk.common import trace_json
from tracerisk.errors import InputError
from tracerisk.pipeline.run.branching import branches as branches_module
from tracerisk.pipeline.run.branching import watch as watch_module
from tracerisk.pipeline.run.branching.branches import Branch, run_branches
from tracerisk.pipeline.run.ended_run import RunOptions
from tracerisk.pipeline.run.fault_run import nominal_run, run_with_faults
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.twin.faults.fault import Fault, modes_of

SAMPLES = Path(__file__).parents[4] / "sample_controllers"
SLOW = pytest.mark.slow
OF_THE_RUN = ("request.json", "wall_time.json")
"""The files of a recording that name its folder, or the time that it took."""
# What it does when it is held back depends on the joint that is.
ODD = """\
import ctypes, os, subprocess, sys, tempfile, threading, time
import moveit_commander, rospy

def hang():
    for _ in iter(int, 1):
        pass

def crash():
    ctypes.string_at(0)

def fork():
    subprocess.Popen(["sleep", "98765"])
    os.fork()

def fill():
    with open("filler.bin", "wb", buffering=0) as file:
        while True:
            file.write(b"x" * 2**20)
            for _ in range(300_000):
                pass

def leave():
    os._exit(3)

def write():
    with open("notes.txt", "a") as file:
        file.write("held back\\n")
    rospy.loginfo(open("notes.txt").read())

ODDITIES = [hang, crash, fork, fill, leave, write]

def move(arm):
    wanted = [value + 0.15 for value in arm.get_current_joint_values()]
    arm.go(wanted, wait=True)
    off = [abs(a - b) for a, b in zip(arm.get_current_joint_values(), wanted)]
    if max(off) > 0.05:
        ODDITIES[off.index(max(off))]()

def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("odd")
    BEFORE
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(1.0)
    move(arm)

if __name__ == "__main__":
    main()
"""


def jam(joint: int, index: int | None = None, time_s: float = 0.2) -> Branch:
    fault = Fault(f"panda_joint{joint}", "jam", time_s)
    return Branch(joint if index is None else index, (fault,))


def prepared(path: Path, **options):
    controller = load_controller(str(path))
    settings = load_settings(controller, options)
    return controller, settings, nominal_run(controller, settings)


def odd(folder: Path, before: str = "pass", **options):
    path = folder / "odd.py"
    path.write_text(textwrap.dedent(ODD).replace("BEFORE", before))
    return prepared(path, **options)


def recorded(folder: Path) -> dict[str, bytes]:
    return {
        each.name: each.read_bytes() for each in folder.iterdir() if each.name not in OF_THE_RUN
    }


def check_equal(controller, settings, nominal, wanted, folder: Path) -> None:
    """Check that each branch left what its run from the beginning leaves, byte for byte."""
    kept = folder / "branches"
    results = list(run_branches(controller, settings, nominal, wanted, keep=kept))
    assert [each.branch.index for each in results] == [each.index for each in wanted]
    assert [each.reason for each in results] == [""] * len(wanted)
    for result in results:
        index, faults = result.branch.index, result.branch.faults
        full = run_with_faults(
            controller, settings, nominal, faults, RunOptions(folder / f"full{index}")
        )
        assert trace_json.dumps(result.run.trace) == trace_json.dumps(full.trace)
        assert recorded(kept / str(index)) == recorded(folder / f"full{index}")
        if not faults:
            assert trace_json.dumps(result.done.trace) == trace_json.dumps(nominal.trace)


def drawn(nominal, count: int, seed: int = 7) -> list[Branch]:
    """Draw branches with a fault each, and one without."""
    chance = random.Random(seed)
    units = [(unit, mode) for unit, modes in modes_of(nominal.robot).items() for mode in modes]
    end_s = nominal.trace.end.simulated_s - 0.1
    found = [Branch(0, (), round(chance.uniform(0.0, end_s), 3))]
    for index in range(1, count + 1):
        unit, mode = chance.choice(units)
        found.append(Branch(index, (Fault(unit, mode, round(chance.uniform(0.0, end_s), 3)),)))
    return found


@pytest.mark.parametrize(
    ("name", "count"),
    [
        # That each byte is the same, a controller that is shorter shows below.
        pytest.param("surface_scan.py", 6, marks=SLOW),
        pytest.param("careful_pick.py", 6, marks=SLOW),
        pytest.param("glue_bead.py", 6, marks=SLOW),
        pytest.param("machine_tending.py", 6, marks=SLOW),
        pytest.param("part_sorting/src/part_sorting/scripts/sort_parts.py", 3, marks=SLOW),
        pytest.param("pick_and_place.py", 3, marks=SLOW),
        pytest.param("shelf_stocking.py", 6, marks=SLOW),
    ],
)
def test_a_branch_equals_a_run_from_the_beginning(name, count, tmp_path):
    controller, settings, nominal = prepared(SAMPLES / name)
    check_equal(controller, settings, nominal, drawn(nominal, count), tmp_path)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The odd controller that does nothing odd before it moves, and its run."""
    return odd(tmp_path_factory.mktemp("plain"))


def test_a_branch_may_leave_at_the_first_step_and_at_the_last(plain, tmp_path):
    controller, settings, nominal = plain
    end_s = nominal.trace.end.simulated_s
    wanted = [
        jam(6, 0, 0.0),
        jam(5, 2, end_s - 0.002),
        Branch(3, (*jam(1, time_s=0.3).faults, *jam(6, time_s=0.2).faults)),
        Branch(4),
    ]
    check_equal(controller, settings, nominal, wanted, tmp_path)


def test_a_branch_has_read_the_files_of_its_run(tmp_path):
    (tmp_path / "plan.txt").write_text("1")
    read = "open(os.path.join(os.path.dirname(os.path.abspath(__file__)), 'plan.txt')).read()"
    controller, settings, nominal = odd(tmp_path, read, sandbox="off")
    assert nominal.trace.inputs == ("plan.txt",)
    for result in run_branches(controller, settings, nominal, [Branch(0), jam(5)]):
        assert result.reason == ""
        assert result.done.trace.inputs == ("plan.txt",)


def test_a_run_that_claims_branches_without_end_ends_all_the_same(tmp_path):
    claims = (
        'import json; plan = json.load(open(sys.orig_argv[-1]))["plan"];'
        ' plan and open(plan["folder"] + "/log/branches.jsonl", "a").write('
        'json.dumps({"index": 6, "process": os.getpid()}) + "\\n[]\\n{\\n")'
        " and ctypes.CDLL(None).sleep(98)"
    )
    controller, settings, nominal = odd(tmp_path, claims, stall_limit_s=1.0)
    (result,) = run_branches(controller, settings, nominal, [jam(6)])
    assert result.reason.startswith("on greenlets the run is another: nothing has moved")


def test_a_branch_that_does_harm_loses_only_itself(tmp_path, monkeypatch):
    monkeypatch.setattr(watch_module, "_MOST_WRITTEN", 40 * 1024**2)
    controller, settings, nominal = odd(tmp_path, stall_limit_s=2.0)
    wanted = [Branch(0), *map(jam, range(1, 7))]
    found = list(run_branches(controller, settings, nominal, wanted, at_once=2))
    without, hung, crashed, forked, filled, left, wrote = found
    assert [each.reason for each in (without, hung, forked, filled, left, wrote)] == [""] * 6
    assert trace_json.dumps(without.done.trace) == trace_json.dumps(nominal.trace)
    end = hung.done.trace.end
    assert end.cause == "wall_limit"
    assert "iter(int, 1)" in "".join(ODD.splitlines()[end.location.line - 2 : end.location.line])
    assert "--stall-limit" in end.message
    assert crashed.reason.startswith(
        "its branch died: the controller's process was ended by SIGSEGV"
    )
    assert crashed.done.trace.end.cause == "died"
    assert "os.fork" in forked.done.trace.end.message
    assert subprocess.run(["pgrep", "-f", "sleep 98765"], check=False).returncode == 1
    assert filled.done.trace.end.message == "it has written more than 40 MB"
    assert left.done.trace.end.message == "the controller called os._exit(3)"
    assert wrote.done.trace.end.cause == "ended"
    assert not (tmp_path / "notes.txt").exists()


@pytest.mark.slow
def test_branches_that_take_little_each_do_not_end_their_run_together(tmp_path):
    hoard = "global held; held = b'x' * 500_000_000; ctypes.CDLL(None).sleep(6)"
    source = ODD.replace("BEFORE", "pass").replace(
        "    for _ in iter(int, 1):\n        pass", f"    {hoard}"
    )
    (tmp_path / "odd.py").write_text(source)
    controller, settings, nominal = prepared(tmp_path / "odd.py", memory_limit_mb=1300)
    wanted = [jam(1, index) for index in range(3)]
    found = list(run_branches(controller, settings, nominal, wanted, at_once=4))
    assert [result.reason for result in found] == [""] * 3


def test_a_file_that_is_open_is_each_branchs_own(tmp_path):
    before = 'global log; log = open("log.txt", "a+"); log.write("begun\\n"); log.flush()'
    text = 'log.write("held\\n"); log.flush(); log.seek(0); rospy.logerr(repr(log.read()))'
    source = ODD.replace("BEFORE", before)
    (tmp_path / "odd.py").write_text(
        source.replace("def hang():", f"def hang():\n    {text}\n    return")
    )
    controller, settings, nominal = prepared(tmp_path / "odd.py")
    wanted = [jam(1, 1), jam(1, 2, 0.3), jam(1, 3, 0.3)]
    for result in run_branches(controller, settings, nominal, wanted):
        assert result.reason == ""
        errors = [each.message for each in result.done.trace.findings]
        assert any(r"begun\nheld\n'" in each for each in errors), errors


@pytest.mark.parametrize(
    ("before", "reason"),
    [
        pytest.param(
            "global pair; import socket; pair = socket.socketpair()",
            "has a socket open",
            marks=SLOW,
        ),
        # Refused as in `test_forking.py`.
        pytest.param(
            "global pair; pair = os.pipe()", "has an open pipe or event queue", marks=SLOW
        ),
        pytest.param(
            "global file; file = tempfile.NamedTemporaryFile()", "has temporary files", marks=SLOW
        ),
        pytest.param(
            "import subprocess; subprocess.Popen(['sleep', '98'])",
            "a program that the controller has started goes on",
            marks=SLOW,
        ),
        (
            "C = ctypes.CDLL(None); C.pthread_create(ctypes.byref(ctypes.c_ulong()), None, C.sleep, 98)",
            "runs its own threads",
        ),
    ],
)
def test_a_controller_that_cannot_be_forked_runs_from_the_beginning(before, reason, tmp_path):
    controller, settings, nominal = odd(tmp_path, before)
    (result,) = run_branches(controller, settings, nominal, [jam(6)])
    assert reason in result.reason
    assert not result.is_branched
    full = run_with_faults(controller, settings, nominal, jam(6).faults)
    assert trace_json.dumps(result.run.trace) == trace_json.dumps(full.trace)


def test_without_greenlets_every_run_is_from_the_beginning(plain, monkeypatch):
    monkeypatch.setattr(branches_module.dependencies, "is_installed", lambda _: False)
    controller, settings, nominal = plain
    (result,) = run_branches(controller, settings, nominal, [jam(6)])
    assert (result.is_branched, result.reason) == (False, "the package greenlet is not installed")
    assert result.done is not None


@pytest.mark.slow
def test_a_run_that_is_another_on_greenlets_is_not_used(tmp_path):
    controller, settings, nominal = odd(
        tmp_path, "time.sleep(float(len(sys.modules.get('greenlet', '')  and 'ab')))"
    )
    (result,) = run_branches(controller, settings, nominal, [jam(6)])
    assert result.reason.startswith("on greenlets the run is another")
    full = run_with_faults(controller, settings, nominal, jam(6).faults)
    assert trace_json.dumps(result.run.trace) == trace_json.dumps(full.trace)


def test_what_is_asked_amiss_is_refused(plain):
    controller, settings, nominal = plain
    for wanted, reported in (
        ([jam(6), jam(6)], "same index"),
        ([jam(6, time_s=1000.0)], "1000"),
        ([Branch(0, (Fault("elbow", "jam", 0.1),))], "elbow"),
    ):
        with pytest.raises(InputError, match=reported):
            run_branches(controller, settings, nominal, wanted)
    with pytest.raises(InputError, match="at once"):
        run_branches(controller, settings, nominal, [jam(6)], at_once=0)
