"""A refresh that is killed at any moment, and two refreshes at once."""

import contextlib
import json
import os
import random
import re
import signal
import time
from pathlib import Path

import pytest

from tracerisk.cli import main
from tracerisk.errors import InputError, TraceRiskError
from tracerisk.pipeline.check.check import check_controllers
from tracerisk.pipeline.check.finding import Checked
from tracerisk.pipeline.freshness.known_controllers import controllers_in
from tracerisk.pipeline.workspace.project import Projects

STEPS = "def home(arm):\n    arm.go()\n\n\ndef place(arm):\n    arm.go()\n"
LOG = """\
Function:home()
ActiveComponents:motor
Function:place()
ActiveComponents:motor

CallSequence:home(),place()
"""
FIRST = "9.5e-08"


def set_figure(figure: str) -> None:
    Path("arm.yaml").write_text(
        f"components:\n  motor: {{probability: {{value: {figure}, per: visit}}, "
        "quantity: 7, twin: {joints: '*'}}\n"
    )


@pytest.fixture
def project(request, tmp_path, monkeypatch):
    """Annotated controllers whose traces are kept, so that a refresh needs no simulation."""
    monkeypatch.chdir(tmp_path)
    set_figure(FIRST)
    Path("run.log").write_text(LOG)
    Path("pyproject.toml").write_text("")
    for number in range(getattr(request, "param", 5)):
        Path(f"c{number:02}.py").write_text(f"# Controller {number}.\n{STEPS}")
        options = ("--log", "run.log", "--hardware", "arm.yaml", "--quiet")
        assert main(["annotate", f"c{number:02}.py", *options]) == 0
    return tmp_path


def sources() -> dict[str, str]:
    """Return what the controllers hold, without the digests, which change with the figures."""
    texts = {path.name: path.read_text() for path in sorted(Path().glob("c*.py"))}
    return {name: re.sub(r"(RiskAnnotation) \S+", r"\1", text) for name, text in texts.items()}


def with_figure(texts: dict[str, str], before: str, now: str) -> dict[str, str]:
    return {name: text.replace(f"= {before}\n", f"= {now}\n") for name, text in texts.items()}


def start(verb: str, *names: str, after: int | None = None) -> int:
    """Start the command in a process of its own, its modules loaded already; return its number.

    With `after`, it begins when something comes from that pipe.
    """
    pid = os.fork()
    if pid == 0:
        code = 5
        with contextlib.suppress(BaseException):
            if after is not None:
                os.read(after, 1)
            code = main([verb, *names, "--quiet"])
        os._exit(code)
    return pid


def is_over(pid: int) -> bool:
    return os.waitpid(pid, os.WNOHANG) != (0, 0)


def kill_after(pid: int, seconds: float) -> bool:
    """Kill a process after a time; return whether it was still running."""
    time.sleep(seconds)
    os.kill(pid, signal.SIGKILL)
    _, status = os.waitpid(pid, 0)
    return os.WIFSIGNALED(status)


def edited() -> list[str]:
    """What `check` takes for a person's edit, or cannot read."""
    projects = Projects()
    found = check_controllers(controllers_in(Path(), projects), projects)
    errors = [str(each) for each in found if isinstance(each, TraceRiskError)]
    findings = [f for each in found if isinstance(each, Checked) for f in each.findings]
    return errors + [str(each) for each in findings if each.kind != "stale"]


@pytest.mark.parametrize(
    ("kills", "project", "seed"),
    [(10, 6, 1), pytest.param(300, 50, 2, marks=pytest.mark.slow)],
    indirect=["project"],
    ids=str,
)
def test_a_kill_leaves_each_file_old_or_new_and_the_next_run_heals_the_rest(
    kills: int, seed: int, project
) -> None:
    chance = random.Random(seed)
    template = with_figure(sources(), FIRST, "FIGURE")
    set_figure("1e-09")
    began = time.monotonic()
    assert os.waitpid(start("refresh"), 0)[1] == 0
    whole = time.monotonic() - began
    before, was_running, mixed = sources(), 0, 0
    for number in range(1, 10 * kills + 1):
        # No two in a row are near enough to be noise.
        figure = f"{(11 + 7 * number % 89) / 10:g}e-08"
        set_figure(figure)
        if kill_after(start("refresh"), chance.uniform(0, whole)):
            was_running += 1
        else:
            # The first one was slower, on a busy machine.
            whole *= 0.9
        after, new = sources(), with_figure(template, "FIGURE", figure)
        is_new = {name: after[name] == new[name] for name in after}
        assert all(is_new[name] or after[name] == before[name] for name in after)
        mixed += any(is_new.values()) and not all(is_new.values())
        assert edited() == []
        before = after
        if number % 10 == 0:
            assert main(["refresh", "--quiet"]) == 0
            before = sources()
            assert before == new
            assert main(["check", "--quiet"]) == 0
            lock = json.loads(Path("tracerisk.lock").read_bytes())
            assert not [name for name, each in lock["controllers"].items() if "previous" in each]
            assert [path for path in Path().iterdir() if path.suffix == ".tmp"] == []
            if number >= kills and was_running > kills / 2 and mixed > kills / 4:
                break
    else:
        pytest.fail(f"of {number} kills, {was_running} hit a refresh and {mixed} hit its writes")


def test_two_refreshes_at_once_leave_what_one_would(project) -> None:
    template = with_figure(sources(), FIRST, "FIGURE")
    for figure in ("1e-09", "2e-09"):
        set_figure(figure)
        pids = [start("refresh"), start("refresh")]
        assert [os.waitpid(pid, 0)[1] for pid in pids] == [0, 0]
        assert sources() == with_figure(template, "FIGURE", figure)
        assert main(["check", "--quiet"]) == 0


def test_a_check_between_the_writes_of_a_refresh_waits_and_takes_nothing_for_an_edit(
    project,
) -> None:
    from tracerisk.pipeline.history.file_lock import one_writer

    old = Path("c00.py").read_text()
    set_figure("1e-09")
    assert main(["refresh", "--quiet"]) == 0
    new = Path("c00.py").read_text()
    # One that is forked while the lock is held would hold it too.
    after, begin = os.pipe()
    check = start("check", "c00.py", after=after)
    with one_writer(Path()):
        # The lock is written by now, and the source is not.
        Path("c00.py").write_text(old)
        os.write(begin, b".")
        time.sleep(0.5)
        assert not is_over(check)
        Path("c00.py").write_text(new)
    assert os.waitpid(check, 0)[1] == 0


def test_a_refresh_waits_for_one_that_writes(project) -> None:
    from tracerisk.pipeline.history.file_lock import one_writer

    set_figure("1e-09")
    before = sources()
    after, begin = os.pipe()
    second = start("refresh", "c00.py", after=after)
    with one_writer(Path()):
        os.write(begin, b".")
        time.sleep(0.5)
        assert not is_over(second)
        assert sources() == before
    assert os.waitpid(second, 0)[1] == 0
    assert sources()["c00.py"] == before["c00.py"].replace(FIRST, "1e-09")


def test_a_file_that_changes_under_a_refresh_is_not_overwritten(project) -> None:
    from tracerisk.pipeline.check.refresh import refresh_controller

    set_figure("1e-09")
    done = refresh_controller(Path("c00.py"), Projects())
    with Path("c00.py").open("a") as stream:
        stream.write("# A person's line.\n")
    before, lock = sources(), Path("tracerisk.lock").read_bytes()
    assert done.annotated is not None
    with pytest.raises(InputError, match=r"c00\.py: was changed by someone else meanwhile"):
        done.annotated.write()
    assert (sources(), Path("tracerisk.lock").read_bytes()) == (before, lock)


def test_blocks_that_another_run_wrote_meanwhile_are_no_edit(project) -> None:
    from tracerisk import api
    from tracerisk.common.trace_log import read_log

    stale = api.load_controller("c00.py")
    settings = api.load_settings(stale, {"hardware": "arm.yaml"})
    trace = read_log(LOG, "run.log", controller="c00.py")
    set_figure("1e-09")
    assert main(["refresh", "--quiet"]) == 0
    hardware = api.load_hardware(settings, "")
    done = api.annotate(stale, trace, hardware, settings, given={"hardware": "arm.yaml"})
    assert not done.is_changed
    Path("c00.py").write_text(Path("c00.py").read_text() + "import os\n")
    with pytest.raises(InputError, match=r"c00\.py: was changed by someone else meanwhile"):
        api.annotate(stale, trace, hardware, settings)
