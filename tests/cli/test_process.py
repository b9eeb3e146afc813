"""The command as a process: pipes, signals, neighbours, and what it imports."""

import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.conftest import program
from tests.machine_load import descendants
from tests.slow import slow_but
from tracerisk.cli import main
from tracerisk.errors import InputError

LONG = """\
open({mark!r}, "w").write(str(os.getpid()))
    while True: home(arm); act(arm)"""
"""Statements that tell the process they run in, and then move the arm until they are stopped."""


def until(condition: Callable[[], bool], limit_s: float = 60.0) -> None:
    end = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < end, "it did not come about"
        os.sched_yield()


def is_alive(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


@contextlib.contextmanager
def started(example, *arguments: str, is_afresh: bool = False) -> Iterator[subprocess.Popen[bytes]]:
    """The command in a process group of its own."""
    environment = {**os.environ, "TMPDIR": str(example.folder / "tmp")}
    process = subprocess.Popen(
        [*program(environment, is_afresh=is_afresh), *arguments],
        cwd=example.folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
        start_new_session=True,
        # A shell that runs the tests in the background has them ignore Ctrl-C.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def simulating(request, example, quick, tmp_path_factory):
    """A command whose controller runs, the processes it has started, and the folder before."""
    mark = tmp_path_factory.mktemp("mark") / "process"
    # Anywhere else, what a controller writes is gone after the run.
    example.write("pyproject.toml", f"[tool.tracerisk]\nwritable = ['{mark.parent}']\n")
    source = quick().replace("    act(arm)\n", f"    {LONG.format(mark=str(mark))}\n")
    example.write("controller.py", source)
    before = example.files()
    (example.folder / "tmp").mkdir()
    arguments = ("run", "controller.py", "--duration", "100000")
    is_afresh = getattr(request, "param", True)
    with started(example, *arguments, is_afresh=is_afresh) as process:
        until(lambda: mark.exists() and mark.read_text() != "")
        controller = int(mark.read_text())
        theirs = descendants(process.pid)
        assert controller in theirs or not is_afresh
        yield process, {*theirs, controller}, before


@pytest.mark.parametrize(
    "simulating", [False, pytest.param(True, marks=pytest.mark.slow)], indirect=True
)
def test_ctrl_c_ends_the_command_and_the_controller(simulating, example):
    process, theirs, before = simulating
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert err.decode().splitlines() == ["tracerisk: interrupted"]
    assert not any(map(is_alive, theirs))
    assert example.files() == before, "no source, no lock, no temporary file"


@pytest.mark.parametrize(
    "simulating", [False, pytest.param(True, marks=pytest.mark.slow)], indirect=True
)
def test_termination_ends_the_controller_too(simulating, example):
    process, theirs, before = simulating
    process.terminate()
    process.communicate(timeout=30)
    assert process.returncode == 128 + signal.SIGTERM
    assert not any(map(is_alive, theirs))
    assert example.files() == before


@pytest.mark.parametrize(
    ("end", "raised"),
    [
        # So does an extension module, in which no Python error may stay.
        (KeyboardInterrupt(), ImportError("initialization failed")),
        (SystemExit(143), ImportError("initialization failed")),
        (SystemExit(143), InputError("unreadable")),
    ],
)
def test_an_import_that_a_signal_breaks_is_an_interruption(end, raised, monkeypatch, capsys):
    def verb(_: object) -> int:
        try:
            raise end
        except BaseException as error:
            raise raised from error

    monkeypatch.setattr("tracerisk.cli.set_up.robots.run", verb)
    _check_interrupted(end, capsys)


def _check_interrupted(end, capsys):
    if isinstance(end, KeyboardInterrupt):
        assert main(["robots"]) == 130
        assert capsys.readouterr().err == "tracerisk: interrupted\n"
    else:
        with pytest.raises(SystemExit) as ended:
            main(["robots"])
        assert ended.value.code == 143
        assert capsys.readouterr().err == ""


@pytest.mark.parametrize("end", [KeyboardInterrupt(), SystemExit(143)])
def test_one_that_comes_while_a_verb_is_imported_is_an_interruption(end, monkeypatch, capsys):
    def parse(_: object) -> None:
        try:
            raise end
        except BaseException as error:
            # What Python makes of it in the body of a class.
            raise RuntimeError("Error calling __set_name__") from error

    monkeypatch.setattr("tracerisk.cli.parser.parse", parse)
    _check_interrupted(end, capsys)


# A signal in the callback of a weak reference, as each import has one: Python drops what it raises.
DROPPED = """
import signal, sys, time, weakref
import tracerisk.cli.set_up.robots as verb
from tracerisk.cli import main

class Imported: pass

def run(options):
    item = Imported()
    reference = weakref.ref(item, lambda _: signal.raise_signal({number}))
    del item
    time.sleep(20)
    return 0

verb.run = run
sys.argv = ["tracerisk", "robots"]
sys.exit(main())
"""


@pytest.mark.parametrize(
    ("number", "code", "said"),
    [(signal.SIGINT, 130, "tracerisk: interrupted\n"), (signal.SIGTERM, 143, "")],
)
def test_a_signal_ends_a_command_wherever_it_comes(number, code, said):
    done = subprocess.run(
        [sys.executable, "-c", DROPPED.format(number=int(number))],
        capture_output=True,
        text=True,
        timeout=15,
    )
    assert (done.returncode, done.stderr) == (code, said)


def test_a_command_that_is_killed_leaves_no_controller_behind(simulating):
    process, theirs, _ = simulating
    process.kill()
    process.wait(timeout=30)
    until(lambda: not any(map(is_alive, theirs)))


@pytest.mark.slow
def test_two_runs_of_two_controllers_in_one_folder_both_reach_the_lock(example, two_steps):
    example.write("one.py", two_steps)
    example.write("two.py", two_steps)
    (example.folder / "tmp").mkdir()
    with started(example, "run", "one.py") as one, started(example, "run", "two.py") as two:
        _, one_err = one.communicate(timeout=120)
        _, two_err = two.communicate(timeout=120)
    assert (one.returncode, two.returncode) == (0, 0), one_err + two_err
    before = example.files()
    assert before["one.py"] == before["two.py"]
    lock = before["tracerisk.lock"].decode()
    assert '"one.py": {' in lock
    assert '"two.py": {' in lock


def test_two_runs_of_one_controller_at_once_give_what_one_gives(annotated_run, example, two_steps):
    run, _ = annotated_run
    example.write("controller.py", two_steps)
    (example.folder / "tmp").mkdir()
    arguments = ("run", "controller.py")
    with started(example, *arguments) as one, started(example, *arguments) as two:
        _, one_err = one.communicate(timeout=120)
        _, two_err = two.communicate(timeout=120)
    assert (one.returncode, two.returncode) == (0, 0), one_err + two_err
    for name in ("controller.py", "tracerisk.lock"):
        assert example.read(name) == run.read(name)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("body", ["script", "module"])
def test_a_run_whose_source_another_annotates_before_it_is_imported_gives_what_one_gives(
    annotated_run, example, two_steps, monkeypatch, body
):
    from tracerisk import api
    from tracerisk.pipeline.run import controller_run

    if body == "module":
        example.write("controller.py", "import steps\n\nsteps.main()\n")
        path = example.write("steps.py", two_steps)
        assert example.run("run", "controller.py").code == 0
        whole = example.files()
        example.write("steps.py", two_steps)
        (example.folder / "tracerisk.lock").unlink()
    else:
        whole = annotated_run[0].files()
        path = example.write("controller.py", two_steps)
    begin = controller_run._run_child

    def late(*arguments, **named):
        path.write_bytes(whole[path.name])
        return begin(*arguments, **named)

    monkeypatch.setattr(controller_run, "_run_child", late)
    controller = api.load_controller(example.folder / "controller.py")
    settings = api.load_settings(controller)
    trace = api.trace_controller(controller, settings)
    hardware = api.load_hardware(settings, trace.robot)
    api.annotate(controller, trace, hardware, settings).write()
    for name in (path.name, "tracerisk.lock"):
        assert example.files()[name] == whole[name]


@pytest.mark.slow
def test_many_runs_checks_and_refreshes_at_once_leave_everything_whole(
    annotated_run, example, two_steps
):
    run, _ = annotated_run
    names = [f"c{number}.py" for number in range(4)]
    for name in names:
        example.write(name, two_steps)
    (example.folder / "tmp").mkdir()
    asked = [("run", name) for name in names for _ in range(5)]
    asked += [("check", name) for name in names for _ in range(12)] + [("check",)] * 2
    asked += [("refresh", name) for name in names] + [("refresh",)]
    random.Random(7).shuffle(asked)
    with contextlib.ExitStack() as stack:
        begun = [stack.enter_context(started(example, *words, "--quiet")) for words in asked]
        ends = [process.communicate(timeout=1800) for process in begun]
    # A check that came first found what was not annotated yet; none found anything broken.
    for words, process, (_, reported) in zip(asked, begun, ends, strict=True):
        allowed = (0,) if words[0] == "run" else (0, 1, 2)
        assert process.returncode in allowed, (words, reported)
        assert b"Traceback" not in reported
    assert {example.read(name) for name in names} == {run.read("controller.py")}
    assert example.run("check").code == 0
    left = {path.name for path in example.folder.iterdir()}
    assert left == {*names, "tmp", "tracerisk.lock", ".tracerisk_cache"}
    assert list((example.folder / "tmp").iterdir()) == []
    assert list(example.folder.rglob("*.tmp")) == []


def test_a_run_keeps_what_another_wrote_into_the_lock_meanwhile(example, two_steps):
    from tracerisk import api
    from tracerisk.adder.lock.lock import ControllerLock, Lock
    from tracerisk.adder.lock.reading import read_lock
    from tracerisk.common import trace_json

    path = example.write("controller.py", two_steps)
    assert example.run("trace", "controller.py", "-o", "trace.json").code == 0

    trace = trace_json.loads(example.read("trace.json").decode(), "trace.json")
    controller = api.load_controller(path)
    settings = api.load_settings(controller)
    hardware = api.load_hardware(settings, trace.robot)
    annotated = api.annotate(controller, trace, hardware, settings)
    other = Lock().with_controller("other.py", ControllerLock("f", {"other.py": {}}))
    example.write("tracerisk.lock", other.dumps())
    annotated.write()
    lock = read_lock(example.folder / "tracerisk.lock")
    assert sorted(lock.controllers) == ["controller.py", "other.py"]
    assert lock.controllers["other.py"] == other.controllers["other.py"]


def test_a_source_that_someone_changes_during_a_run_is_not_overwritten(example, two_steps):
    from tracerisk import api
    from tracerisk.common import trace_json
    from tracerisk.errors import InputError

    path = example.write("controller.py", two_steps)
    assert example.run("trace", "controller.py", "-o", "trace.json").code == 0
    trace = trace_json.loads(example.read("trace.json").decode(), "trace.json")
    controller = api.load_controller(path)
    settings = api.load_settings(controller)
    annotated = api.annotate(controller, trace, api.load_hardware(settings, trace.robot), settings)
    example.write("controller.py", two_steps + "# saved in an editor\n")
    with pytest.raises(InputError, match="was changed by someone else meanwhile"):
        annotated.write()
    assert example.read("controller.py").decode() == two_steps + "# saved in an editor\n"
    assert not (example.folder / "tracerisk.lock").exists()


@pytest.mark.parametrize(
    "call",
    slow_but(
        ["solve model.json", "run -h"],
        ["solve model.json", "solve model.json --json", "build controller.py", "--help", "run -h"],
    ),
)
def test_a_reader_that_goes_away_is_no_error(call, annotated):
    read_end, write_end = os.pipe()
    os.close(read_end)
    done = subprocess.run(
        [sys.executable, "-m", "tracerisk", *call.split()],
        cwd=annotated.folder,
        stdout=write_end,
        stderr=subprocess.PIPE,
        check=False,
    )
    os.close(write_end)
    assert done.returncode == 0
    assert b"Traceback" not in done.stderr
    assert b"BrokenPipe" not in done.stderr


def test_a_closed_standard_output_is_no_error(annotated):
    done = subprocess.run(
        ["sh", "-c", f"exec {sys.executable} -m tracerisk solve model.json >&-"],
        cwd=annotated.folder,
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, b"")


HEAVY = {"mujoco", "dm_control", "libcst", "mink", "rosbags"}

LISTING = """\
import sys
from tracerisk.cli import main
try:
    code = main({arguments!r})
except SystemExit as end:
    code = end.code
assert code == 0, code
print(*sorted(sys.modules), file=sys.stderr)
"""


def modules_of(example, code: str) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=example.folder, capture_output=True, check=True
    )
    return set(done.stderr.decode().split())


TREE = """\
<opsa-mef>
  <define-fault-tree name="pumps">
    <define-gate name="top"><and><basic-event name="a"/><basic-event name="b"/></and></define-gate>
    <define-basic-event name="a"><float value="0.01"/></define-basic-event>
    <define-basic-event name="b"><float value="0.02"/></define-basic-event>
  </define-fault-tree>
</opsa-mef>
"""


def test_a_fault_tree_is_solved_without_what_few_model_files_hold(example):
    example.write("tree.xml", TREE)
    loaded = modules_of(example, LISTING.format(arguments=["solve", "tree.xml"]))
    logic = "tracerisk.prm.other_models.logic"
    assert f"{logic}.model" in loaded
    rare = {f"{logic}.{name}" for name in ("mission_parts", "phased", "common_cause")}
    assert not loaded & (rare | HEAVY)


RARE_IN_A_RUN = {
    *("numpy.ma", "ctypes.util"),
    *("tracerisk.instrument.native.binaries", "tracerisk.ros.drafts.drafting"),
}
"""What a run of Python that lacks nothing has no use for."""


def test_a_run_loads_only_what_it_needs(example, two_steps):
    example.write("controller.py", two_steps)
    loaded = modules_of(example, LISTING.format(arguments=["run", "controller.py", "-q"]))
    assert "tracerisk.pipeline.trace.run_trace" in loaded
    assert not loaded & RARE_IN_A_RUN


def test_no_verb_on_a_controller_loads_what_only_models_of_other_tools_need(annotated):
    calls = [
        "run controller.py",
        "check",
        "refresh",
        "build controller.py",
        "solve --importance --pairs controller.py",
        "solve --uncertainty --error-factor 3 --samples 20 controller.py",
        "report controller.py -o report.html",
        "overrides",
    ]
    code = f"""\
import sys
from tracerisk.cli import main
for call in {calls!r}:
    assert main(call.split()) == 0, call
print(*sorted(sys.modules), file=sys.stderr)
"""
    loaded = modules_of(annotated, code)
    assert {"tracerisk.prm.hybrid.solve", "tracerisk.prm.questions.uncertainty"} <= loaded
    assert {name for name in loaded if name.startswith("tracerisk.prm.other_models")} == set()


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "call",
    slow_but(
        ["solve controller.py", "run -h"],
        ["solve model.json", "solve controller.py", "build controller.py", "--help", "run -h"],
    ),
)
def test_verbs_without_a_simulation_import_no_simulator_and_no_libcst(call, annotated):
    modules = modules_of(annotated, LISTING.format(arguments=call.split()))
    assert "tracerisk.cli" in modules
    assert not HEAVY & modules


def test_a_run_of_sources_that_are_found_before_loads_no_libcst(example, quick):
    helper = "import sys\n\n\ndef loaded():\n    return 'libcst' in sys.modules\n"
    example.write("helper.py", helper)
    example.write("controller.py", quick("import helper", "print('libcst', helper.loaded())"))
    (example.folder / "tmp").mkdir()
    with started(example, "run", "controller.py", is_afresh=True) as process:
        shown = b"".join(process.communicate())
    assert process.returncode == 0
    assert b"libcst False" in shown


NOT_FOR_CHECK = {
    *("asyncio", "concurrent", "ctypes", "email", "http", "importlib.metadata", "logging"),
    *("multiprocessing", "numpy", "platform", "rich", "ruamel", "socket", "ssl", "subprocess"),
    *("tempfile", "urllib.request", "xml", "yaml"),
    # Together as long as all of the check; of these `dataclasses` and `re` alone are worth it.
    *("argparse", "difflib", "gettext", "hashlib", "locale", "shutil", "threading", "tomllib"),
    "traceback",
    *("tracerisk.adder.annotate", "tracerisk.adder.sources.insert", "tracerisk.common.sandbox"),
    *(
        "tracerisk.common.sandbox.limited_process",
        "tracerisk.prm",
        "tracerisk.report",
        "tracerisk.ros",
    ),
    *("tracerisk.twin", "tracerisk.instrument.transform", "tracerisk.pipeline.review"),
    *("tracerisk.trace", "tracerisk.common.outcome", "tracerisk.common.worlds"),
    *("tracerisk.common.limits", "tracerisk.common.text.paper"),
    "tracerisk.cli.parser",
    *(
        "tracerisk.adder.merge.merge",
        "tracerisk.adder.sources.c_source",
        "tracerisk.instrument.source.c_tokens",
    ),
    *(
        "tracerisk.adder.sources.write",
        "tracerisk.common.evidence.cells",
        "tracerisk.common.hardware.source_files",
    ),
    *("tracerisk.pipeline.history.file_lock", "tracerisk.pipeline.workspace.workspace"),
}
"""What a check of a file that is up to date has no use for: most of its time is imports."""


def test_check_imports_only_what_it_needs(annotated):
    modules = modules_of(annotated, LISTING.format(arguments=["check", "controller.py"]))
    assert "tracerisk.pipeline.check.check" in modules
    assert not NOT_FOR_CHECK & modules


NOT_FOR_A_TREE = {
    *("argparse", "decimal", "fractions", "gettext", "json", "locale", "numpy", "pathlib", "rich"),
    *("shutil", "typing", "urllib"),
    *("tracerisk.cli.parser", "tracerisk.config", "tracerisk.pipeline", "tracerisk.trace"),
    "tracerisk.prm.hybrid",
    *("tracerisk.prm.other_models.cut_sets", "tracerisk.prm.other_models.markov"),
}
"""What a small fault tree would spend more time on than on its solution."""

TREE = """\
<opsa-mef>
  <define-fault-tree name="t">
    <define-gate name="top"><or><event name="a"/><event name="b"/></or></define-gate>
    <define-basic-event name="a"><float value="0.1"/></define-basic-event>
    <define-basic-event name="b"><float value="0.2"/></define-basic-event>
  </define-fault-tree>
</opsa-mef>
"""


def test_a_tree_is_solved_without_what_takes_longer_to_import(example):
    (example.folder / "tree.xml").write_text(TREE, encoding="utf-8")
    code = LISTING.format(arguments=["solve", "tree.xml"])
    done = subprocess.run(
        [sys.executable, "-S", "-c", f"import sys; sys.path[:0] = {sys.path!r}\n{code}"],
        cwd=example.folder,
        capture_output=True,
        check=True,
    )
    modules = set(done.stderr.decode().split())
    assert "tracerisk.prm.other_models.logic.trees" in modules
    assert not NOT_FOR_A_TREE & modules


@pytest.mark.parametrize(("file", "code"), [("tree.xml", 0), ("none.xml", 2)])
def test_what_is_to_be_done_at_the_end_of_the_process_is_done(example, file, code):
    (example.folder / "tree.xml").write_text(TREE, encoding="utf-8")
    command = (
        f"import sys; sys.path[:0] = {sys.path!r}; sys.argv = ['tracerisk', 'solve', {file!r}]"
    )
    solve = "from tracerisk.cli import main; sys.exit(main())"
    late = "import atexit; atexit.register(lambda: print('at the end'))"
    plain, registered = (
        subprocess.run(
            [sys.executable, "-S", "-c", f"{command}; {solve}"],
            cwd=example.folder,
            capture_output=True,
            text=True,
        )
        for command in (command, f"{command}; {late}")
    )
    assert (plain.returncode, registered.returncode) == (code, code)
    assert registered.stdout == f"{plain.stdout}at the end\n"
    assert registered.stderr == plain.stderr
    assert bool(plain.stderr) == (code == 2)


def test_help_imports_nothing_of_the_stages(example):
    modules = modules_of(example, LISTING.format(arguments=["--help"]))
    ours = {name for name in modules if name.startswith("tracerisk.")}
    words = (
        "cli",
        "cli.parser",
        "cli.verbs",
        "common",
        "common.text",
        "common.text.columns",
        *("api", "common.version"),
    )
    assert ours == {f"tracerisk.{each}" for each in words}


def test_importing_the_package_is_light(example):
    code = "import tracerisk, sys; print(*sorted(sys.modules), file=sys.stderr)"
    modules = modules_of(example, code)
    light = {"api", "common", "common.version"}
    ours = {name for name in modules if name.startswith("tracerisk.")}
    assert ours == {f"tracerisk.{name}" for name in light}
    assert not (HEAVY | {"numpy", "rich", "argparse", "dataclasses"}) & modules
