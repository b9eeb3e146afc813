"""The tests of ROS 2's own Python libraries, run on the stand-ins.

    python benchmarks/upstream_tests.py [--rclpy DIR] [--geometry2 DIR] [--message-filters DIR]
        [--launch DIR] [--test-msgs DIR ...] [--only TEXT] [--jobs N] [--json FILE] [--markdown]

Each DIR is a checkout of the repository of that name; `--test-msgs` are those of
`ros2/rcl_interfaces` and `ros2/test_interface_files`, from whose texts the messages of the tests
are made. Nothing of a checkout is built or changed.

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

HERE = Path(__file__).resolve().parent
SCOPE = HERE / "upstream_scope.csv"
LONGEST_S = 180
"""The machine's time after which a process that has said nothing is ended [s]."""
MOST_PROCESSES = 40
"""After how many ends of a file's processes its remaining tests count as failed."""

SUITES = {
    "rclpy": ("rclpy", "rclpy/test", "test_*.py"),
    "tf2_py": ("geometry2", "tf2_py/test", "test_*.py"),
    "tf2_ros_py": ("geometry2", "tf2_ros_py/test", "test_*.py"),
    "tf2_geometry_msgs": ("geometry2", "tf2_geometry_msgs/test", "test_*.py"),
    "tf2_sensor_msgs": ("geometry2", "tf2_sensor_msgs/test", "test_*.py"),
    "test_tf2": ("geometry2", "test_tf2/test", "test_*.py"),
    "message_filters": ("message_filters", "test", "*.py"),
    "launch": ("launch", "launch/test/launch", "**/test_*.py"),
}
"""Of each suite the repository that holds it, its folder there, and its files."""
REPOSITORIES = sorted({repository for repository, _, _ in SUITES.values()})
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

    @property
    def name(self) -> str:
        """The suite, and where the file is in its folder."""
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
    """Yield the files of tests in the checkouts."""
    for suite, (repository, folder, pattern) in SUITES.items():
        if repository in checkouts:
            root = checkouts[repository] / folder
            for path in sorted(root.glob(pattern)):
                if path.name != "__init__.py" and not path.name.endswith(".launch.py"):
                    yield TestFile(suite, root, path)


def ran(
    each: TestFile, messages: Path, fixtures: Path | None, known: Sequence[Rule]
) -> list[Result]:
    """Run a file's tests, in as many processes as it takes, and return what came of each."""
    file = each.name
    whole = rule_of(file, known)
    if whole is not None and whole.kind == "out":
        return [Result(file, "out", whole.reason, "")]
    found: dict[str, tuple[str, str]] = {}
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report"
        for _ in range(MOST_PROCESSES):
            job = {
                "file": str(each.path),
                "root": str(each.root.parent),
                "report": str(report),
                "done": sorted(found),
                "library": each.suite,
                "paths": [str(each.path.parent), str(each.root), str(each.root.parent)],
                "aliases": ALIASES,
                "interfaces": {"test_msgs": str(messages)},
                "modules": {} if fixtures is None else {"test_msgs": str(fixtures)},
            }
            report.write_text("")
            said = processed(job, Path(folder))
            begun = ""
            for line in report.read_text().splitlines():
                name, outcome, cause = json.loads(line)
                begun = name if outcome == "begun" else ""
                if outcome != "begun":
                    found[name] = outcome, cause
            if begun:
                found[begun] = "failed", said
            elif said == "ended":
                break
    return [
        judged(file if not name else f"{file}::{name}", outcome, cause, known)
        for name, (outcome, cause) in found.items()
    ]


def processed(job: Mapping[str, object], folder: Path) -> str:
    """Run one process of tests, and say how it went: `ended`, or why it did not."""
    try:
        code = subprocess.run(
            [sys.executable, str(HERE / "upstream_child.py"), json.dumps(job)],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "HOME": str(folder)},
            timeout=LONGEST_S,
            check=False,
        ).returncode
    except subprocess.TimeoutExpired:
        return f"it did not end within {LONGEST_S} s"
    return "ended" if code == 0 else f"its process ended with {code}"


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
            kind: sum(1 for each in own if each.outcome == kind)
            for kind in ("passed", "failed", "skipped", "out")
        }
        cells = (name, count["passed"] + count["failed"], *count.values())
        yield f"| {' | '.join(map(str, cells))} |" if markdown else _row(cells)
    passed = sum(1 for each in results if each.outcome == "passed")
    of = passed + sum(1 for each in results if each.outcome == "failed")
    if of:
        yield ""
        yield f"{passed} of {of} in scope pass: {passed / of:.1%}"
    for kind, head in (
        ("failed", "Failures"),
        ("out", "Out of scope"),
        ("skipped", "Skipped by themselves"),
    ):
        told = [each for each in results if each.outcome == kind]
        if told:
            yield f"\n{head}:\n"
            yield from _by_reasons(told, markdown=markdown)


def _row(cells: Sequence[object]) -> str:
    first, *others = cells
    return f"{first:<64}" + "".join(f"{cell:>14}" for cell in others)


def _rows(results: Sequence[Result]) -> Iterator[tuple[str, list[Result]]]:
    """Yield each file, each suite of several files, and all together, with its results."""
    for suite in SUITES:
        of_suite = [each for each in results if each.test.startswith(f"{suite}/")]
        names = sorted({each.file for each in of_suite})
        for name in names:
            yield name, [each for each in of_suite if each.file == name]
        if len(names) > 1:
            yield f"all of {suite}", of_suite
    yield "all", list(results)


def _by_reasons(results: Sequence[Result], *, markdown: bool) -> Iterator[str]:
    found: dict[str, list[str]] = {}
    for each in results:
        reason = each.reason or f"not known to fail: {each.cause}"
        found.setdefault(reason, []).append(each.test)
    for reason, tests in found.items():
        if markdown:
            yield f"- {reason[:1].upper()}{reason[1:]}: {', '.join(f'`{each}`' for each in tests)}."
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
    options = parser.parse_args()
    checkouts = {
        repository: getattr(options, repository).resolve()
        for repository in REPOSITORIES
        if getattr(options, repository)
    }
    known = rules()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fixtures = gather_messages([each.resolve() for each in options.test_msgs], folder)
        wanted = [each for each in files(checkouts) if options.only in each.name]
        if not wanted:
            parser.error("no tests in the checkouts that are given: name one with --rclpy DIR, say")
        with ThreadPoolExecutor(options.jobs) as pool:
            told = pool.map(lambda each: ran(each, folder, fixtures, known), wanted)
            results = [each for own in told for each in own]
    print("\n".join(table(results, markdown=options.markdown)))
    if options.json is not None:
        options.json.write_text(json.dumps([asdict(each) for each in results], indent=1) + "\n")
    return int(any(each.outcome == "failed" and not each.reason for each in results))


if __name__ == "__main__":
    sys.exit(main())
