"""The tests of ROS's own Python libraries, run on the stand-ins.

    python benchmarks/upstream_tests.py [--rclpy DIR] [--geometry2 DIR] [--message-filters DIR]
        [--launch DIR] [--test-msgs DIR ...] [--ros-comm DIR] [--actionlib DIR]
        [--geometry2-noetic DIR] [--only TEXT] [--jobs N] [--json FILE] [--markdown]

Each DIR is a checkout of the repository of that name; `--test-msgs` are those of
`ros2/rcl_interfaces` and `ros2/test_interface_files`, from whose texts the messages of the tests
of ROS 2 are made. Those of ROS 1 are made from the texts beside its tests, and a test that a
launch file starts runs beside the nodes of that file. Nothing of a checkout is built or changed.

Each file runs in a process of its own, in simulated time, without a twin. Prints a table: of each
file how many of its tests pass, and how many fail, then every failure, and what is out of scope.
`upstream_scope.csv` holds the tests that need what no stand-in has, with the reason, and the
failures that are known, with theirs. The exit code is 1 where a test fails that is not known to.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import quick
from upstream_rostest import StartedTest, interfaces_of, packages_of, started_tests

QUICK_CHECKOUT = {
    "rclpy/test/test_quick.py": """\
import rclpy


def test_it_is_not_up_yet():
    assert not rclpy.ok()
"""
}

HERE = Path(__file__).resolve().parent
SCOPE = HERE / "upstream_scope.csv"
LONGEST_S = 180
"""The machine's time after which a process that has said nothing is ended [s]."""
MOST_PROCESSES = 40
"""After how many ends of a file's processes its remaining tests count as failed."""


@dataclass(frozen=True)
class Suite:
    """A folder of tests."""

    repository: str
    """The repository that holds it."""
    folder: str
    """Its folder there."""
    files: tuple[str, ...]
    """Patterns of its files."""
    ros: int = 2
    """Which ROS it tests."""


SUITES = {
    "rclpy": Suite("rclpy", "rclpy/test", ("test_*.py",)),
    "tf2_py": Suite("geometry2", "tf2_py/test", ("test_*.py",)),
    "tf2_ros_py": Suite("geometry2", "tf2_ros_py/test", ("test_*.py",)),
    "tf2_geometry_msgs": Suite("geometry2", "tf2_geometry_msgs/test", ("test_*.py",)),
    "tf2_sensor_msgs": Suite("geometry2", "tf2_sensor_msgs/test", ("test_*.py",)),
    "test_tf2": Suite("geometry2", "test_tf2/test", ("test_*.py",)),
    "message_filters": Suite("message_filters", "test", ("*.py",)),
    "launch": Suite("launch", "launch/test/launch", ("**/test_*.py",)),
    "noetic/rospy": Suite("ros_comm", "test/test_rospy/test", ("**/test_*.py",), 1),
    "noetic/rosgraph": Suite("ros_comm", "tools/rosgraph/test", ("test_*.py",), 1),
    "noetic/rosbag": Suite("ros_comm", "test/test_rosbag/test", ("test_*.py",), 1),
    "noetic/message_filters": Suite("ros_comm", "utilities/message_filters/test", ("*.py",), 1),
    "noetic/actionlib": Suite(
        "actionlib", "actionlib/test", ("test_*.py", "*_test.py", "ex*.py"), 1
    ),
    "noetic/tf2_geometry_msgs": Suite(
        "geometry2_noetic", "tf2_geometry_msgs", ("scripts/test.py",), 1
    ),
    "noetic/tf2_kdl": Suite("geometry2_noetic", "tf2_kdl", ("scripts/test.py",), 1),
    "noetic/tf2_sensor_msgs": Suite("geometry2_noetic", "tf2_sensor_msgs/test", ("test_*.py",), 1),
    "noetic/test_tf2": Suite("geometry2_noetic", "test_tf2/test", ("test_*.py",), 1),
}
OF_ROS1 = {suite.repository for suite in SUITES.values() if suite.ros == 1}
REPOSITORIES = sorted({suite.repository for suite in SUITES.values()})
ENVIRONMENT = {"PYTHONDONTWRITEBYTECODE": "1", "ROS_ROOT": "/opt/ros/noetic/share/ros"}
"""Of each process; the second as a setup file of ROS 1 has it."""
ALIASES = {"test_rclpy": "", "test_tf2_py": "", "test_tf2_py._tf2_py": "tf2_py"}


@dataclass(frozen=True)
class Rule:
    """What is known of tests: that they are out of scope, or that they fail."""

    test: str
    """A pattern of shells: `rclpy/test_node.py::TestNode::test_*`."""
    kind: str
    """`out` of scope, or `fails`."""
    reason: str
    """Why, in words."""


@dataclass(frozen=True)
class TestFile:
    """A file of tests."""

    suite: str
    """Whose tests they are."""
    root: Path
    """The folder of the suite."""
    path: Path
    """The file."""
    launch: Path | None = None
    """The launch file that starts it, if one does."""
    started: StartedTest | None = None
    """How that file starts it."""

    @property
    def name(self) -> str:
        """The suite, and where the file is in its folder, or what starts it and its name."""
        if self.launch is not None and self.started is not None:
            return (
                f"{self.suite}/{self.launch.relative_to(self.root).as_posix()}{self.started.name}"
            )
        return f"{self.suite}/{self.path.relative_to(self.root).as_posix()}"


@dataclass(frozen=True)
class Result:
    """What came of a test."""

    test: str
    """The suite, the file and the name: `rclpy/test_node.py::TestNode::test_create`."""
    outcome: str
    """`passed`, `failed`, `skipped` (by itself) or `out` of scope."""
    reason: str
    """Why it is out of scope, was skipped or is known to fail, in words."""
    cause: str
    """What the failure said."""

    @property
    def file(self) -> str:
        """The suite and the file."""
        return self.test.partition("::")[0]


def rules() -> list[Rule]:
    """Return what is known of the tests, as `upstream_scope.csv` holds it."""
    with SCOPE.open(encoding="utf-8", newline="") as stream:
        return [Rule(**row) for row in csv.DictReader(stream)]


def rule_of(test: str, known: Sequence[Rule]) -> Rule | None:
    """Return the first rule that is about a test."""
    return next((rule for rule in known if fnmatchcase(test, rule.test)), None)


def files(checkouts: Mapping[str, Path]) -> Iterator[TestFile]:
    """Yield the files of tests in the checkouts: once for each launch file that starts them."""
    for name, suite in SUITES.items():
        if suite.repository in checkouts:
            root = checkouts[suite.repository] / suite.folder
            launched = list(_launched(name, root, checkouts)) if suite.ros == 1 else []
            for path in sorted({path for file in suite.files for path in root.glob(file)}):
                if path.name != "__init__.py" and not path.name.endswith(".launch.py"):
                    own = [test_file for test_file in launched if test_file.path == path]
                    yield from own or [TestFile(name, root, path)]


def _launched(suite: str, root: Path, checkouts: Mapping[str, Path]) -> Iterator[TestFile]:
    packages = packages_of(sorted(set(checkouts.values())))
    for launch in sorted((*root.rglob("*.test"), *root.rglob("*.launch"))):
        for started_test in started_tests(launch, packages):
            yield TestFile(suite, root, started_test.script, launch, started_test)


def ran(each: TestFile, given: Mapping[str, object], known: Sequence[Rule]) -> list[Result]:
    """Run a file's tests, in as many processes as it takes, and return what came of each."""
    file = each.name
    whole = rule_of(file, known)
    if whole is not None and whole.kind == "out":
        return [Result(file, "out", whole.reason, "")]
    pair: dict[str, tuple[str, str]] = {}
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report"
        for _ in range(MOST_PROCESSES):
            job = {
                "file": str(each.path),
                "root": str(each.root.parent),
                "report": str(report),
                "done": sorted(pair),
                "library": each.suite,
                "paths": [str(each.path.parent), str(each.root), str(each.root.parent)],
                "ros": SUITES[each.suite].ros,
                "started": None if each.started is None else asdict(each.started),
                **given,
            }
            report.write_text("")
            said = processed(job, Path(folder))
            before, begun = len(pair), ""
            for line in report.read_text().splitlines():
                name, outcome, cause = json.loads(line)
                begun = name if outcome == "begun" else ""
                if outcome != "begun":
                    pair[name] = outcome, cause
            if begun:
                pair[begun] = "failed", said
            elif said == "ended":
                break
            elif len(pair) == before:
                pair[""] = "failed", said
                break
    return [
        judged(file if not name else f"{file}::{name}", outcome, cause, known)
        for name, (outcome, cause) in pair.items()
    ]


def processed(job: Mapping[str, object], folder: Path) -> str:
    """Run one process of tests, and say how it went: `ended`, or why it did not."""
    try:
        code = subprocess.run(
            [sys.executable, str(HERE / "upstream_child.py"), json.dumps(job, default=str)],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **ENVIRONMENT, "HOME": str(folder)},
            timeout=LONGEST_S,
            check=False,
        ).returncode
    except subprocess.TimeoutExpired:
        return f"it did not end within {LONGEST_S} s"
    return "ended" if code == 0 else f"its process ended with code {code}"


def judged(test: str, outcome: str, cause: str, known: Sequence[Rule]) -> Result:
    """Return a test's result with what is known of it."""
    rule = rule_of(test, known)
    if rule is not None and rule.kind == "out":
        return Result(test, "out", rule.reason, cause)
    if outcome == "skipped":
        return Result(test, "skipped", cause.removeprefix("skipped: "), cause)
    reason = rule.reason if rule is not None and outcome == "failed" else ""
    return Result(test, outcome, reason, cause)


def gather_messages(checkouts: Sequence[Path], folder: Path) -> Path | None:
    """Put the texts of test_msgs into a folder; return where its own modules stand, if any do."""
    fixtures = None
    for checkout in checkouts:
        package = checkout / "test_msgs" if (checkout / "test_msgs").is_dir() else checkout
        for kind in ("msg", "srv", "action"):
            (folder / kind).mkdir(exist_ok=True)
            for text in sorted((package / kind).glob(f"*.{kind}")):
                shutil.copy(text, folder / kind)
        if (package / "src" / "test_msgs").is_dir():
            fixtures = package / "src" / "test_msgs"
    return fixtures


def table(results: Sequence[Result], *, markdown: bool) -> Iterator[str]:
    """Yield the lines of the table, of the failures and of what is out of scope, by reasons."""
    heads = ("file", "in scope", "passed", "failed", "skipped", "out of scope")
    if markdown:
        yield f"| {' | '.join(heads)} |"
        yield f"|---{'|---:' * (len(heads) - 1)}|"
    else:
        yield _row(heads)
    for name, own in _rows(results):
        count = {
            kind: sum(1 for result in own if result.outcome == kind)
            for kind in ("passed", "failed", "skipped", "out")
        }
        cells = (name, count["passed"] + count["failed"], *count.values())
        yield f"| {' | '.join(map(str, cells))} |" if markdown else _row(cells)
    passed = sum(1 for result in results if result.outcome == "passed")
    of = passed + sum(1 for result in results if result.outcome == "failed")
    if of:
        yield ""
        yield f"{passed} of {of} in scope pass: {passed / of:.1%}"
    for kind, head in (
        ("failed", "Failures"),
        ("out", "Out of scope"),
        ("skipped", "Skipped by themselves"),
    ):
        reported = [result for result in results if result.outcome == kind]
        if reported:
            yield f"\n{head}:\n"
            yield from _by_reasons(reported, markdown=markdown)


def _row(cells: Sequence[object]) -> str:
    first, *others = cells
    return f"{first:<64}" + "".join(f"{cell:>14}" for cell in others)


def _rows(results: Sequence[Result]) -> Iterator[tuple[str, list[Result]]]:
    """Yield each file, each suite of several files, and all together, with its results."""
    for suite in SUITES:
        of_suite = [result for result in results if result.test.startswith(f"{suite}/")]
        names = sorted({result.file for result in of_suite})
        for name in names:
            yield name, [result for result in of_suite if result.file == name]
        if len(names) > 1:
            yield f"all of {suite}", of_suite
    yield "all", list(results)


def _by_reasons(results: Sequence[Result], *, markdown: bool) -> Iterator[str]:
    texts: dict[str, list[str]] = {}
    for result in results:
        reason = result.reason or f"not known to fail: {result.cause}"
        texts.setdefault(reason, []).append(result.test)
    for reason, tests in texts.items():
        if markdown:
            yield f"- {reason[:1].upper()}{reason[1:]}: {', '.join(f'`{test}`' for test in tests)}."
        else:
            yield "\n".join((*tests, f"    {reason}"))


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    for repository in REPOSITORIES:
        parser.add_argument(f"--{repository.replace('_', '-')}", type=Path, metavar="DIR")
    parser.add_argument("--test-msgs", type=Path, metavar="DIR", nargs="*", default=[])
    parser.add_argument("--only", default="", help="only files whose name holds this text")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", action="store_true")
    options = quick.parsed(parser, rclpy=lambda: quick.folder(QUICK_CHECKOUT))
    checkouts = {
        repository: getattr(options, repository).resolve()
        for repository in REPOSITORIES
        if getattr(options, repository)
    }
    known = rules()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fixtures = gather_messages([test_msg.resolve() for test_msg in options.test_msgs], folder)
        packages = packages_of([path for name, path in checkouts.items() if name in OF_ROS1])
        given = {
            "aliases": ALIASES,
            "interfaces": {"test_msgs": folder},
            "interfaces1": interfaces_of(packages),
            "modules": {} if fixtures is None else {"test_msgs": fixtures},
        }
        wanted = [file for file in files(checkouts) if options.only in file.name]
        if not wanted:
            parser.error("no tests in the checkouts that are given: name one with --rclpy DIR, say")
        with ThreadPoolExecutor(options.jobs) as pool:
            results_of = pool.map(lambda item: ran(item, given, known), wanted)
            results = [result for own in results_of for result in own]
    print("\n".join(table(results, markdown=options.markdown)))
    if options.json is not None:
        options.json.write_text(json.dumps([asdict(result) for result in results], indent=1) + "\n")
    return int(any(result.outcome == "failed" and not result.reason for result in results))


if __name__ == "__main__":
    sys.exit(main())
