"""docs/errors.md has a section for each code, with a message as the command prints it."""

import json
import re
import shlex
import subprocess
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import get_args

import pytest

from tracerisk import errors
from tracerisk.common.sandbox.kernel.features import Support
from tracerisk.errors import ExitCode, TraceRiskError
from tracerisk.pipeline.check.finding import FindingKind
from tracerisk.trace import GOOD_ENDS, EndCause, RunEnd

TEXT = (Path(__file__).parents[1] / "docs" / "errors.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^### `([\w-]+)`\n(.*?)(?=^##|\Z)", TEXT, re.MULTILINE | re.DOTALL))

HARDWARE = """\
components:
  gripper: {probability: {value: 1e-07, per: visit}, twin: {gripper: true}}
"""
LOG = "Function:home()\nActiveComponents:gripper\n\nCallSequence:home()\n"
DATA = {"run.log": LOG, "arm.yaml": HARDWARE}
CELL = "def home(arm):\n    arm.go()\n"
BLOCK = """\
def home(arm):
    # | RiskAnnotation
    # | @Function {
    # |   name = home
    # |   callSequence = 1
    # |   next = done 1
    # | }
    # | @Component {
    # |   name = gripper
    # |   probability = 1e-07
    # |   quantity = 1
    # |   redundancy = false
    # | }
    arm.go()
"""
ANNOTATE = "annotate cell.py --log run.log --hardware arm.yaml --quiet"
# For each code: files, and a command that does not take them.
STATIC: dict[str, tuple[dict[str, str], str]] = {
    "usage": ({}, "run cell.py --robt panda"),
    "input": ({}, "check cell.py"),
    "settings": (
        {"cell.py": BLOCK, "pyproject.toml": "[tool.tracerisk]\nmax_failure_probabilty = 1e-5\n"},
        "doctor cell.py",
    ),
    "source": ({"cell.py": BLOCK.replace("(arm)", "(arm", 1)}, "build cell.py"),
    "block": ({"cell.py": BLOCK.replace("quantity = 1", "quantity = none")}, "build cell.py"),
    "rewrite": (
        {"cell.py": CELL.replace("arm.go", "# | a | b |\n    arm.go"), **DATA},
        ANNOTATE,
    ),
    "too-large": (
        {
            "chain.tra": "dtmc\n0 999999999999 1\n",
            "chain.lab": "#DECLARATION\ninit\n#END\n0 init\n",
        },
        "solve chain.tra",
    ),
    "hardware": (
        {"cell.py": CELL, **DATA, "arm.yaml": HARDWARE.replace("1e-07", "1.5")},
        ANNOTATE,
    ),
    "robot": ({}, "robots pandda"),
    "scenario": (
        {"cell.py": CELL, "cell.yaml": "servces: []\n"},
        "run cell.py --robot panda --scenario cell.yaml",
    ),
    "driver": (
        {
            "cell.driver.yaml": "driver: cell\nservices:\n  go:\n"
            "    {type: std_srvs/Trigger, moves: {}}\n"
        },
        "drivers check cell.driver.yaml",
    ),
    "log": (
        {"cell.py": CELL, **DATA, "run.log": "Function home()\n"},
        ANNOTATE,
    ),
    "model": (
        {"trees.dft": 'toplevel "A";\n"A" and "B" "C";\n"B" lambda=0.1;\n'},
        "solve trees.dft",
    ),
    "lock": ({"cell.py": BLOCK, "tracerisk.lock": "{\n"}, "check cell.py"),
}

POST = '[tool.tracerisk]\nscenario = "world.yaml"\nfail_on = "unexpected_contact"\n'

# What a check does not let pass: what becomes of an annotated source, and of its settings.
PINNED = ("probability = 1e-07", "probability := 2e-07  ! computed 1e-07")
_REST = "\n    # |   quantity = 1\n    # |   redundancy = false\n    # | }\n    arm.go("
# The code has changed too, and there is no git: another branch may have come in.
MIXED = (f"probability = 1e-07{_REST}", f"probability = 2e-07{_REST}1")
CHECKS: dict[str, tuple[tuple[str, str], str]] = {
    "stale": (("arm.go()", "arm.go(wait=True)"), ""),
    "edited": (("probability = 1e-07", "probability = 2e-07"), ""),
    "undecided": (MIXED, ""),
    "missing": (("", ""), ""),
    "orphaned": (("def home(", "def go_home("), ""),
    "over_threshold": (("", ""), "max_failure_probability = 1e-9"),
    "unjustified": (PINNED, "require_reason = true"),
    "unknown": (("", ""), ""),
    "gone": (("", ""), ""),
    "unsolvable": (("next = done 1", "next := home 1"), ""),
    "world": (("", ""), "require_worlds = ['discovery']"),
}

# What the function `act` does after a motion (or what is done in its place), and the options.
RUNS: dict[str, tuple[str, str]] = {
    "run-raised": ('ACT raise RuntimeError("tube lost")', ""),
    "run-exited": ("ACT sys.exit(3)", ""),
    "run-died": ("ACT os.kill(os.getpid(), 9)", ""),
    "run-no-motion": ("while not rospy.is_shutdown(): pass", "--duration 3"),
    "run-deadlock": ('ACT rospy.wait_for_service("/find_tube")', ""),
    "run-wall-limit": ("ACT for _ in iter(int, 1): pass", "--stall-limit 1"),
    "run-memory-limit": ("ACT hoard = bytearray(4_000_000_000)", "--memory-limit 2500"),
    "run-not-importable": ("ACT import my_vision", ""),
    "no-command": ("pass", ""),
}


@pytest.fixture
def call(tmp_path, monkeypatch, capfd):
    """Runs a command in a folder of its own; returns its exit code and what it printed."""
    from tracerisk.cli import main

    monkeypatch.chdir(tmp_path)

    def run(command: str) -> tuple[int, str]:
        try:
            code = main(shlex.split(command))
        except SystemExit as ended:
            code = int(ended.code or 0)
        out, err = capfd.readouterr()
        return code, out + err

    return run


def assert_reported(code: str, out: str, folder: Path) -> None:
    """The message in the section of a code is what was printed, `...` standing for anything."""
    (message,) = re.findall(r"^```text\n(.*?)\n```$", SECTIONS[code], re.MULTILINE | re.DOTALL)
    assert len(message) > 30
    pattern = ".*".join(re.escape(part) for part in message.split("..."))
    found = out.replace(str(folder), "/home/me/cell")
    assert re.search(f"^{pattern}$", found, re.MULTILINE), found


def put(files: Mapping[str, str]) -> None:
    for name, text in files.items():
        Path(name).write_text(text, encoding="utf-8")


def edit(old: str, new: str) -> None:
    text = Path("cell.py").read_text()
    assert old in text
    Path("cell.py").write_text(text.replace(old, new, 1))


@pytest.mark.parametrize("code", STATIC)
def test_what_is_given_wrongly_is_reported_so(code, call, tmp_path):
    files, command = STATIC[code]
    put(files)
    exit_code, out = call(command)
    assert exit_code == ExitCode.BAD_INPUT
    assert f"[{code}]" in out
    assert_reported(code, out, tmp_path)
    if not command.startswith("check"):  # which tells of several
        assert f'"code": "{code}"' in call(f"{command} --json")[1]


def test_a_sandbox_that_is_required_in_vain_is_reported_so(call, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "tracerisk.common.sandbox.process.support", lambda: Support(0, seccomp=False)
    )
    put({"cell.py": CELL})
    exit_code, out = call("run cell.py --robot panda --sandbox require")
    assert exit_code == ExitCode.BAD_INPUT
    assert_reported("sandbox", out, tmp_path)


def test_a_reason_without_an_edit_that_says_so_is_reported_so(call, tmp_path):
    put({"cell.py": BLOCK.replace("quantity = 1", "quantity = 1  ! one is in use")})
    exit_code, out = call("build cell.py")
    assert exit_code == ExitCode.EDIT_IN_THE_WAY
    assert_reported("reason", out, tmp_path)


def test_an_edit_in_the_way_is_reported_so(call, tmp_path):
    put({"cell.py": CELL, **DATA})
    assert call(ANNOTATE) == (ExitCode.FINE, "")
    edit("= 1e-07", "= 2e-07")
    exit_code, out = call(ANNOTATE)
    assert exit_code == ExitCode.EDIT_IN_THE_WAY
    assert_reported("edit", out, tmp_path)


@pytest.mark.parametrize("code", CHECKS)
def test_what_a_check_finds_is_reported_so(code, call, tmp_path):
    (old, new), settings = CHECKS[code]
    put({"cell.py": CELL, **DATA, "pyproject.toml": f"[tool.tracerisk]\n{settings}\n"})
    assert call(ANNOTATE)[0] == ExitCode.FINE
    if code == "missing":
        put({"cell.py": CELL})
    else:
        edit(old, new)
    if code == "gone":
        Path("cell.py").unlink()
    if code == "unknown":
        Path("tracerisk.lock").unlink()
    exit_code, out = call("check cell.py")
    is_edit = code in ("edited", "undecided")
    assert exit_code == (ExitCode.EDIT_IN_THE_WAY if is_edit else ExitCode.WOULD_CHANGE)
    assert_reported(code, out, tmp_path)


def test_a_lock_that_git_does_not_track_is_reported_so(call, tmp_path):
    put({"cell.py": CELL, **DATA})
    assert call(ANNOTATE)[0] == ExitCode.FINE
    for command in ("git init --quiet", "git add cell.py"):
        subprocess.run(command.split(), check=True)
    exit_code, out = call("check cell.py")
    assert exit_code == ExitCode.WOULD_CHANGE
    assert_reported("untracked", out, tmp_path)


def test_a_redundancy_by_hand_over_units_that_differ_is_reported_so(call, tmp_path, quick):
    put({"cell.py": quick()})
    assert call("run cell.py --quiet")[0] == ExitCode.FINE
    at_motor = "quantity = 7\n    # |   redundancy "
    edit(f"{at_motor}=", f"{at_motor}:=")
    edit(":= false", ":= true  ! computed false; by design")
    exit_code, out = call("check cell.py")
    assert exit_code == ExitCode.WOULD_CHANGE
    assert_reported("unequal", out, tmp_path)


def test_a_value_by_hand_whose_use_moved_is_reported_so(call, tmp_path, quick):
    whole = quick("joints[1] += 0.05", "arm.go(joints, wait=True)", "return arm")
    put({"cell.py": whole})
    assert call("run cell.py --quiet")[0] == ExitCode.FINE
    edit("probability = ", "probability := 3e-05  ! of the supplier, computed ")
    edit("    act(arm)\n\nif", "    rest(act(arm))\n\nif")
    edit("    joints[1] += 0.05\n    arm.go(joints, wait=True)\n", "")
    edit(
        "def main", "def rest(arm):\n    arm.set_named_target('ready')\n    arm.go()\n\n\ndef main"
    )
    _, out = call("refresh cell.py")
    assert "moved: " in out
    exit_code, out = call("check cell.py")
    assert exit_code == ExitCode.WOULD_CHANGE
    assert_reported("moved", out, tmp_path)
    edit("of the supplier", "of the supplier, for each turn")
    assert call("check cell.py")[0] == ExitCode.FINE


def test_a_contact_that_is_to_fail_is_reported_so_and_so_are_pictures_that_nothing_draws(
    call, tmp_path, quick, monkeypatch
):
    put(
        {
            "cell.py": quick().replace("0.05", "0.8"),
            "world.yaml": "objects: [{name: post, box: [0.05, 0.05, 1.4], xyz: [0.26, 0.16, 0.7]}]",
            "pyproject.toml": POST,
        }
    )
    assert call("run cell.py --quiet")[0] == ExitCode.WOULD_CHANGE
    exit_code, out = call("check cell.py")
    assert exit_code == ExitCode.WOULD_CHANGE
    assert_reported("contact", out, tmp_path)
    monkeypatch.setenv("MUJOCO_GL", "none")
    exit_code, out = call("report cell.py --png pictures")
    assert exit_code == ExitCode.BAD_INPUT
    assert_reported("render", out, tmp_path)


def test_a_launch_file_that_is_not_read_in_time_is_reported_so(call, tmp_path):
    put(
        {
            "package.xml": "<package><name>cell</name></package>",
            "cell.py": "import rclpy\nrclpy.init()\n",
            "turn.launch.py": "def generate_launch_description():\n    while True: pass\n",
        }
    )
    exit_code, out = call("run cell.py --stall-limit 0.5 --launch turn.launch.py --json")
    assert exit_code == ExitCode.CONTROLLER_FAILED
    assert_reported("limit", out, tmp_path)
    assert '"code": "limit"' in out


def test_a_run_that_a_full_disk_may_have_ended_is_reported_so(call, tmp_path, quick, monkeypatch):
    monkeypatch.setattr("tracerisk.pipeline.run.ended_run._is_full", lambda _: True)
    put({"cell.py": quick("raise OSError")})
    exit_code, out = call("run cell.py --no-draft")
    assert exit_code == ExitCode.CONTROLLER_FAILED
    assert_reported("machine", out, tmp_path)


@pytest.mark.parametrize("code", RUNS)
def test_a_run_that_fails_is_reported_so(code, call, tmp_path, quick):
    act, options = RUNS[code]
    inside = act.startswith("ACT ")
    source = (
        quick(act.removeprefix("ACT ")) if inside else quick().replace("act(arm)\n\n", f"{act}\n\n")
    )
    put({"cell.py": source})
    exit_code, out = call(f"run cell.py --no-draft {options}")
    bad_input = code == "run-not-importable"
    is_faulted = code in ("run-raised", "run-exited")
    bad = ExitCode.WOULD_CHANGE if is_faulted else ExitCode.CONTROLLER_FAILED
    assert exit_code == (ExitCode.BAD_INPUT if bad_input else bad)
    assert_reported(code, out, tmp_path)


LAMP = (
    "ACT try: rospy.wait_for_service('/lamp', 1.0); rospy.ServiceProxy('/lamp', SetBool)\n"
    "    except rospy.ROSException: pass"
)
# What a verdict of the last run does not let pass: what `act` does, and options of the check.
VERDICTS: dict[str, tuple[str, str]] = {
    "faulted": ('ACT rospy.logerr("no tube")', ""),
    "stuck": ("ACT pass", ""),
    "partial": (LAMP, ""),
    "coverage": ("ACT pass", "--min-coverage 0.9"),
}


@pytest.mark.parametrize("code", VERDICTS)
def test_a_verdict_that_does_not_pass_is_reported_so(code, call, tmp_path, quick):
    act, options = VERDICTS[code]
    spare = "\n\ndef spare(arm):\n    arm.go()\n" if code == "coverage" else ""
    source = quick(act.removeprefix("ACT ")) + spare
    put({"cell.py": "from std_srvs.srv import SetBool\n" + source})
    call("run cell.py --quiet")
    if code == "stuck":
        lock = json.loads(Path("tracerisk.lock").read_text())
        kept = lock["controllers"]["cell.py"]["trace"]["verdict"]
        reason = {"code": "run-deadlock", "verdict": "stuck", "function": "act"}
        kept["reasons"] = [{**reason, "words": "a wait that nothing can end"}]
        Path("tracerisk.lock").write_text(json.dumps({**lock}))
    exit_code, out = call(f"check cell.py {options}")
    assert exit_code == ExitCode.WOULD_CHANGE
    assert_reported(code, out, tmp_path)


def codes_of(error: type[TraceRiskError]) -> set[str]:
    own = {error.code} if "code" in vars(error) else set()
    return own.union(*map(codes_of, error.__subclasses__()))


def test_each_code_has_a_section_and_each_section_a_code():
    for name in (
        "adder.lock.lock",
        "adder.sources.read",
        "twin.physics.motion",
        "prm.other_models.logic.checks",
    ):
        import_module(f"tracerisk.{name}")
    raised = codes_of(TraceRiskError) - {TraceRiskError.code}
    ends = {RunEnd(cause, "", None).code for cause in get_args(EndCause) if cause not in GOOD_ENDS}
    assert set(SECTIONS) == raised | ends | set(get_args(FindingKind)) | {"usage"}
    # tests/common/test_dependencies.py, tests/report/png, tests/pipeline: errors of the machine
    others = {
        "edit",
        "reason",
        "unequal",
        "moved",
        "contact",
        "dependency",
        "limit",
        "machine",
        "render",
        "sandbox",
    }
    others.update(("system", "untracked"))  # tests/test_other_systems.py
    assert set(SECTIONS) == {*STATIC, *RUNS, *CHECKS, *VERDICTS, *others}


def test_every_class_of_errors_has_a_code_of_its_own():
    classes = [each for each in vars(errors).values() if isinstance(each, type)]
    codes = [vars(each)["code"] for each in classes if issubclass(each, TraceRiskError)]
    assert len(codes) == len(set(codes)) > 10


def test_every_good_end_is_reported():
    reported = TEXT.partition("## How a run may end well")[2]
    assert set(re.findall(r"^`(\w+)`:", reported, re.MULTILINE)) == GOOD_ENDS
