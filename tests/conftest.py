"""What the tests of several rooms share: the sample controller and one way to run the command."""

from __future__ import annotations

import gc
import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from tests import other_system, slow
from tests.browser import browser as browser
from tests.browser import chromium as chromium
from tests.commands import Commands
from tests.reports import pytest_runtest_protocol as pytest_runtest_protocol
from tracerisk.common.sandbox.fork_server import READ_ONCE, several_come
from tracerisk.common.sandbox.ros_prefix import without_ros
from tracerisk.pipeline.workspace.prefixes import PREFIX_VARIABLES, SOURCES_VARIABLE

# Hundreds of processes import the same modules: what one has compiled, the others read.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# A shell in which a ROS is sourced shows no test another workspace, nor modules of it.
for _name in (*PREFIX_VARIABLES, SOURCES_VARIABLE, "ROS_DISTRO", "ROS_VERSION"):
    os.environ.pop(_name, None)
if "PYTHONPATH" in os.environ:
    _kept = without_ros(os.environ.pop("PYTHONPATH").split(os.pathsep))
    os.environ.update({"PYTHONPATH": os.pathsep.join(_kept)} if _kept else {})
sys.path[:] = without_ros(sys.path)
AT_START = dict(os.environ)
RECURSION_LIMIT = sys.getrecursionlimit()

# A shell that starts them in the background has interrupts ignored, by all that they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# What fails a test is what it finds, not how busy the machine is.
settings.register_profile(
    "any_machine", deadline=None, suppress_health_check=[HealthCheck.too_slow], max_examples=20
)
# Where a test gives no number, `--all` tries ten times as many, and `--hypothesis-profile thorough`
# a hundred times.
settings.register_profile("all", settings.get_profile("any_machine"), max_examples=200)
settings.register_profile("thorough", settings.get_profile("any_machine"), max_examples=2000)
settings.load_profile("any_machine")

SAMPLES = Path(__file__).parent.parent / "sample_controllers"
SYSTEM = Path("/usr/bin/python3")
ROS1 = "import rospy, actionlib, rosmaster, std_msgs, roscpp"


QUICK = """\
import os, sys, time
import moveit_commander, rospy
from geometry_msgs.msg import Pose

def home(arm):
    arm.set_named_target("ready")
    arm.go(wait=True)

def act(arm):
    joints = arm.get_current_joint_values()
    joints[0] += 0.05
    arm.go(joints, wait=True)
    ACT

def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("quick")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(1.0)
    act(arm)

if __name__ == "__main__":
    main()
"""


def quick_controller(*statements: str) -> str:
    """A controller that turns the first joint a little, and then does the statements in `act`."""
    return QUICK.replace("ACT", "\n    ".join(statements or ("pass",)))


SLOW_S = 3600
"""After this time a slow test has hung [s]; others have the limit of `pyproject.toml`."""

LONGEST = ("test_benchmarks.py", "test_replay_browser.py")
"""Files that begin first, each on a core of its own, so that no core waits for them at the end."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Choose the quick cases, and order all as every worker does, whichever folder came first."""
    slow.take_some(items, config.getoption("--share"))
    # Other interpreters have fewer plugins.
    for item in items if config.pluginmanager.hasplugin("timeout") else ():
        if item.get_closest_marker("slow") is not None:
            item.add_marker(pytest.mark.timeout(SLOW_S))
    items.sort(key=lambda item: (item.path.name not in LONGEST, item.path))


def _from_another_folder_on(worker: str, workers: int) -> list[str]:
    """What to collect, in an order of the worker's own: what one compiles, the others read."""
    tests = Path(__file__).parent
    folders = sorted(str(path) for path in tests.iterdir() if path.is_dir())
    first = len(folders) * int(worker.removeprefix("gw")) // workers
    files = sorted(str(path) for path in tests.glob("test_*.py"))
    return [*folders[first:], *folders[:first], *files]


@dataclass(frozen=True)
class Outcome:
    """What one call of the command left."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        return json.loads(self.out)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Return one more than there are cores: a third of the time, a test waits for something."""
    return (os.cpu_count() or 1) + 1


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Look for no garbage while tests are collected: there are thousands, and all stay."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_collection_finish() -> None:
    """Look through no collected test later either."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 50, 100)


def pytest_sessionfinish() -> None:
    """Look through nothing once more where the process ends anyway."""
    gc.freeze()


_SERVED_AT: list[str] = []
"""Where this worker's commands are run, with those of the other workers."""


@lru_cache(maxsize=1)
def _commands() -> Commands:
    if _SERVED_AT:
        return Commands(_SERVED_AT[0], AT_START)
    return Commands.started(quick_controller(), AT_START)


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Run the commands of all workers by one process, that of the process that starts them."""
    if sys.platform == "linux":
        node.workerinput["commands"] = [_commands().path]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--system",
        choices=("windows", "macos"),
        help="run commands that need no run of a controller as if on this system",
    )
    parser.addoption("--all", action="store_true", help="take the slow cases too")
    parser.addoption(
        "--share",
        type=int,
        default=1,
        help="take so many times as many cases of each test of which some are slow (default: 1)",
    )
    parser.addoption(
        "--skips",
        type=Path,
        help="write the names of the tests that were skipped to this file, one a line",
    )


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    """Write which tests were skipped, for a run that has what they need."""
    path = config.getoption("--skips")
    if path is not None:
        skipped = {report.nodeid for report in terminalreporter.stats.get("skipped", ())}
        path.write_text("".join(f"{name}\n" for name in sorted(skipped)), encoding="utf-8")


_ELSEWHERE: list[str] = []
"""The other system that `--system` names."""
ON_LINUX_ALONE = frozenset(
    {"run", "trace", "attach", "scenario", "success", "refresh", "evidence", "sweep", "mutate"}
)
"""The verbs that are run as on Linux, whatever `--system` says."""


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--all"):
        config.option.markexpr = ""
        settings.load_profile("all")
    slow.taken_by(config.option.markexpr)
    _ELSEWHERE.extend(filter(None, [config.getoption("--system")]))
    config.option.loadscopereorder = False  # of pytest-xdist: files come in the order given here
    of_worker = getattr(config, "workerinput", {})
    _SERVED_AT.extend(of_worker.get("commands", ()))
    if of_worker and config.args == config.getini("testpaths"):
        config.args = _from_another_folder_on(of_worker["workerid"], of_worker["workercount"])


def _are_quick_in(environment: Mapping[str, str]) -> bool:
    """Whether commands that are forked are as those that are started there."""
    return not _ELSEWHERE and sys.platform == "linux" and _commands().can_run(environment)


def program(
    environment: Mapping[str, str], *, is_afresh: bool = False, verb: str = "run"
) -> list[str]:
    """The words that start `tracerisk` in a shell of an environment; forked, or afresh."""
    if not is_afresh and _are_quick_in(environment):
        return [_commands().program]
    return [sys.executable, *_elsewhere(verb)]


def _elsewhere(*arguments: str) -> list[str]:
    """The words that have Python begin a command, on the system that `--system` names."""
    if _ELSEWHERE and arguments and arguments[0] not in ON_LINUX_ALONE:
        return [other_system.__file__, *_ELSEWHERE]
    return ["-m", "tracerisk"]


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call() -> None:
    """Leave out the one variable in which tests differ: runs are forked where none does."""
    os.environ.pop("PYTEST_CURRENT_TEST", None)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    """Put back what an import of an earlier test has set for good, as that of scikit-learn does.

    Otherwise each command and run of all later tests would start afresh, for seconds. A controller
    that a test left suspended keeps its deeper stack from no other test, either.
    """
    sys.setrecursionlimit(RECURSION_LIMIT)
    for name in [*os.environ]:
        if name.startswith(READ_ONCE) and name not in AT_START:
            del os.environ[name]


@pytest.fixture(scope="session", autouse=True)
def one_server_of_runs() -> None:
    """Have the runs that tests make in this process forked by one server."""
    several_come()


@pytest.fixture(scope="session", autouse=True)
def no_packages_beside(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Have no package of a test look for others among the folders of all tests."""
    (tmp_path_factory.getbasetemp() / "COLCON_IGNORE").touch()


class Example:
    """Files in a folder of their own, and the command run on them as a user would."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(self, name: str, text: str | bytes) -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    def read(self, name: str) -> bytes:
        return (self.folder / name).read_bytes()

    def files(self) -> dict[str, bytes]:
        """All files but those of caches, which are the machine's and no part of a project."""
        return {
            path.relative_to(self.folder).as_posix(): path.read_bytes()
            for path in sorted(self.folder.rglob("*"))
            if path.is_file() and not {"__pycache__", ".tracerisk_cache"} & set(path.parts)
        }

    def run(
        self,
        *arguments: str,
        environment: dict[str, str] | None = None,
        python: str | Path = sys.executable,
        script: Path | None = None,
        is_afresh: bool = False,
    ) -> Outcome:
        """Run the command, or a script of Python; forked where it can be, or afresh."""
        environment = {**os.environ, **(environment or {})}
        is_forked = python == sys.executable and not is_afresh
        if is_forked and _are_quick_in(environment):
            code, out, err = _commands().run(self.folder, arguments, environment, script=script)
            return Outcome(code, out.decode(), err.decode())
        done = subprocess.run(
            [python, *(_elsewhere(*arguments) if script is None else [script]), *arguments],
            cwd=self.folder,
            capture_output=True,
            env=environment,
            timeout=300,
            check=False,
        )
        return Outcome(done.returncode, done.stdout.decode(), done.stderr.decode())


@pytest.fixture(scope="session")
def example_in() -> type[Example]:
    """The class itself, for fixtures that outlive a test."""
    return Example


@pytest.fixture(scope="session")
def quick() -> Callable[..., str]:
    """Makes the source of a controller that takes about a second of simulated time."""
    return quick_controller


@pytest.fixture
def example(tmp_path: Path) -> Example:
    return Example(tmp_path)


@pytest.fixture(scope="session")
def pick_and_place() -> bytes:
    """The sample controller without blocks, whatever a run in the work tree has put in."""
    from tracerisk.adder.sources.insert import strip_blocks

    path = SAMPLES / "pick_and_place.py"
    return strip_blocks(path.read_bytes(), path.name)


class RepositoryExample(Example):
    """A folder that git keeps, without the settings of whoever runs the tests."""

    @classmethod
    def empty(cls, folder: Path) -> RepositoryExample:
        """A new one, in a folder that is there."""
        made = cls(folder)
        made.git("init", "--quiet", "--initial-branch=main")
        return made

    def git(self, *arguments: str) -> str:
        identity = {
            f"GIT_{role}_{what}": value
            for role in ("AUTHOR", "COMMITTER")
            for what, value in (("NAME", "a"), ("EMAIL", "a@example.org"))
        }
        bare = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}
        settings = {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_NOSYSTEM": "1"}
        done = subprocess.run(
            ["git", *arguments],
            cwd=self.folder,
            capture_output=True,
            env={**bare, **identity, **settings},
            check=False,
        )
        assert done.returncode == 0, done.stderr.decode()
        return done.stdout.decode().strip()

    def commit(self) -> str:
        """Commit everything that is there; return the commit."""
        self.git("add", "--all")
        self.git("commit", "--quiet", "--allow-empty", "--message", "change")
        return self.git("rev-parse", "HEAD")


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RepositoryExample:
    """An empty repository; the tests may run in a hook of another one."""
    for name in [name for name in os.environ if name.startswith("GIT_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", os.devnull)
    folder = tmp_path / "repository"
    folder.mkdir()
    return RepositoryExample.empty(folder)


@pytest.fixture(scope="session")
def annotated_source() -> Callable[..., str]:
    """Makes an annotated source from functions told as `name: (next lines, component lines)`.

    A component is told as `gripper = 1e-7`, `motor = 2e-7 x7` (all needed) or `power = 1e-5 of2`
    (one suffices); `:=` pins its probability.
    """

    def component(text: str) -> str:
        name, operator, figure, *units = text.split(" ", 3)
        units = units[0].split() if units else []
        comment = ""
        if "!" in units:
            comment = "  " + " ".join(units[units.index("!") :])
            units = units[: units.index("!")]
        count = next((unit for unit in units if unit[0] in "xo"), "x1")
        quantity = count.removeprefix("x").removeprefix("of")
        redundancy = "true" if count.startswith("of") else "false"
        return f"""\
    # | @Component {{
    # |   name = {name}
    # |   probability {operator} {figure}{comment}
    # |   quantity = {quantity}
    # |   redundancy = {redundancy}
    # | }}
"""

    def make(**functions: tuple[str, str]) -> str:
        found = []
        for rank, (name, (following, components)) in enumerate(functions.items(), start=1):
            steps = "".join(f"    # |   next = {step}\n" for step in following.split(", "))
            entries = "".join(component(each) for each in components.split("; ") if each)
            found.append(
                f"def {name}(arm):\n    # | RiskAnnotation\n    # | @Function {{\n"
                f"    # |   name = {name}\n    # |   callSequence = {rank}\n{steps}    # | }}\n"
                f'{entries}    arm.go("{name}")\n'
            )
        return "\n\n".join(found)

    return make


@pytest.fixture
def master(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A master of ROS 1 on loopback, named in the environment; skips where there is none."""
    if subprocess.run([SYSTEM, "-c", ROS1], capture_output=True, check=False).returncode:
        pytest.skip("rospy, actionlib and rosmaster are not installed")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{port}")
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    started = subprocess.Popen(
        ["/usr/bin/rosmaster", "--core", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline:
        with socket.socket() as asked:
            if asked.connect_ex(("127.0.0.1", port)) == 0:
                break
        time.sleep(0.05)
    yield
    started.terminate()
    started.wait(10)
