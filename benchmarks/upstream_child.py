"""Run one file of tests of a ROS library on the stand-ins, in simulated time.

The process that `upstream_tests.py` starts for a file: it reads what to do as JSON from its
argument, runs pytest as a controller's main program would run, and writes a line of JSON for each
test to the file that it is given. A test in which nothing can happen any more ends the process,
for the threads that it leaves cannot be had back; whoever started it goes on behind that test.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
import traceback
from collections.abc import Callable
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, TextIO

import pytest

from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.parameter_files import Parameter, into_tree
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import RunOver, Scheduler

LONGEST_NS = 3_600_000_000_000
"""The simulated time of all tests of a file together [ns]."""


class StillWorld:
    """A world in which nothing is but time."""

    time_ns = 0
    busy = False

    def advance(self, until_ns: int) -> int:
        """Let the time be `until_ns` [ns]."""
        self.time_ns = max(self.time_ns, until_ns)
        return self.time_ns


class Reporter:
    """The plugin of pytest that writes a line for each test: its name, outcome and cause."""

    def __init__(self, stream: TextIO, is_over: Callable[[], bool], done: list[str]) -> None:
        self._stream = stream
        self._is_over = is_over
        self._done = set(done)
        self._failed: dict[str, str] = {}

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out the tests that an earlier process has done."""
        items[:] = [item for item in items if named(item.nodeid) not in self._done]

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Note a file that cannot be imported."""
        if report.failed:
            self._write("", "failed", last_line(report.longreprtext))

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """Note which test begins: if it never ends, it is known which it was."""
        self._write(named(nodeid), "begun", "")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Keep the first failure of a test, and write its outcome when it is torn down."""
        name = named(report.nodeid)
        if report.failed:
            self._failed.setdefault(name, last_line(report.longreprtext))
        elif report.skipped:
            where = report.longrepr
            text = str(where[-1]) if isinstance(where, tuple) else str(where)
            self._failed.setdefault(name, f"skipped: {text}")
        if report.when == "teardown":
            cause = self._failed.pop(name, None)
            outcome = "passed" if cause is None else "failed"
            if cause is not None and cause.startswith("skipped: "):
                outcome = "skipped"
            self._write(name, outcome, cause or "")
            if self._is_over():
                self._stream.flush()
                os._exit(3)

    def _write(self, name: str, outcome: str, cause: str) -> None:
        self._stream.write(json.dumps([name, outcome, cause]) + "\n")
        self._stream.flush()


def named(nodeid: str) -> str:
    """Return a test's name without its file."""
    return nodeid.partition("::")[2]


def last_line(text: str) -> str:
    """Return the line of a failure that says what it was, with the place in the tests."""
    lines = [line for line in text.splitlines() if line.startswith("E  ")]
    result = lines[0][1:].strip() if lines else text.strip().splitlines()[-1] if text else ""
    places = [line for line in text.splitlines() if ".py:" in line and ": " in line]
    return f"{result} ({places[-1].strip()})" if places else result


def serve_build_products(aliases: dict[str, str], folders: dict[str, str]) -> None:
    """Put in place what a build of the library makes for its tests.

    `aliases` name the test build of a compiled module, `folders` a message package that has
    modules of its own beside its messages.
    """
    loading: Any = ModuleType("rpyutils")
    loading.add_dll_directories_from_env = lambda _: contextlib.nullcontext()
    sys.modules["rpyutils"] = loading
    for name, real in aliases.items():
        sys.modules[name] = stand_for(name, real)
    for package, folder in folders.items():
        for file in sorted(Path(folder).glob("[a-z]*.py")):
            name = f"{package}.{file.stem}"
            spec = spec_from_file_location(name, file)
            if spec is not None and spec.loader is not None:
                sys.modules[name] = module_from_spec(spec)
                spec.loader.exec_module(sys.modules[name])


def stand_for(name: str, real: str) -> ModuleType:
    """Return a module that has what another has, which is imported when it is asked for."""
    module: Any = ModuleType(name)
    if real:
        module.__getattr__ = lambda attribute: getattr(import_module(real), attribute)
    return module  # type: ignore[no-any-return]


def launch_tests(job: dict[str, Any]) -> None:
    """Run the tests of `launch` on what stands in for it where launch files are read."""
    from tracerisk.pipeline.launch_files.child import _serve

    _serve({}, [], [])
    sys.path += job["paths"]
    with Path(job["report"]).open("a", encoding="utf-8") as stream:
        reporter = Reporter(stream, lambda: False, job["done"])
        pytest.main([*options(job), job["file"]], plugins=[reporter])


def options(job: dict[str, Any]) -> list[str]:
    """Return the options of pytest: nothing of what the checkout or this project sets."""
    return [
        *("-q", "--tb=short", "--noconftest", "-c", os.devnull, "--rootdir", job["root"]),
        *("-p", "no:cacheprovider", "-p", "no:xdist", "-p", "no:randomly"),
    ]


def serve_rostest(run_tests: Callable[[], None]) -> None:
    """Put the modules in place by which programs of ROS 1 run their tests."""
    rostest: Any = ModuleType("rostest")
    rosunit: Any = ModuleType("rosunit")
    rostest.run = rostest.rosrun = rostest.unitrun = rosunit.unitrun = lambda *_, **__: run_tests()
    rostest.is_publisher = lambda topic, node: node in of_topic(topic, 0)
    rostest.is_subscriber = lambda topic, node: node in of_topic(topic, 1)
    sys.modules.update(rostest=rostest, rosunit=rosunit)


def of_topic(topic: str, role: int) -> list[str]:
    """Return the nodes that the master knows as a topic's publishers (0) or subscribers (1)."""
    masterapi = import_module("rosgraph.masterapi")
    known = dict(masterapi.Master("/tests").getSystemState()[role])
    return list(known.get(topic, []))


def run_program(job: dict[str, Any], runtime: Runtime, run_tests: Callable[[], None]) -> None:
    """Run a program of tests as its launch file starts it; it runs its tests itself, if it can."""
    ran: list[bool] = []

    def once() -> None:
        if not ran:
            ran.append(True)
            run_tests()

    serve_rostest(once)
    started = job["started"]
    if started is not None and started["beside"]:
        from tracerisk.common.text.read_back import read_back
        from tracerisk.instrument.recorder import Recorder
        from tracerisk.pipeline.run.companions.companion_run import Companions
        from tracerisk.pipeline.trace.run_files import Companion

        companions = tuple(read_back(Companion, item) for item in started["beside"])
        Companions(companions, runtime, Recorder(io.BytesIO(), clock=lambda: 0)).start()
    sys.argv = list(runtime.argv)
    text = Path(job["file"]).read_bytes()
    names = {"__name__": "__main__", "__file__": job["file"]}
    if b"__main__" in text:
        try:
            exec(compile(text, job["file"], "exec"), names)
        except (Exception, SystemExit):  # noqa: BLE001 - collecting its tests shows what is wrong
            traceback.print_exc()
    once()


def main() -> None:
    """Do what the argument says."""
    job = json.loads(sys.argv[1])
    if job["library"] == "launch":
        launch_tests(job)
        return
    scheduler = Scheduler(StillWorld(), duration_ns=LONGEST_NS)
    graph = Graph(scheduler)
    started = job["started"] or {"arguments": [], "parameters": []}
    parameters = tuple(Parameter(**item) for item in started["parameters"])
    into_tree(parameters, graph.parameters)
    argv = (job["file"] if job["ros"] == 1 else "pytest", *started["arguments"])
    rules = DistroRules("jazzy" if job["ros"] == 2 else "noetic")
    runtime = Runtime(scheduler, graph, argv=argv, parameters=parameters, distro=rules)
    folders = {
        name: Path(path)
        for name, path in job["interfaces" if job["ros"] == 2 else "interfaces1"].items()
    }
    interfaces = Interfaces2(folders, rules=rules) if job["ros"] == 2 else Interfaces(folders)

    def run_tests() -> None:
        reporter = Reporter(stream, lambda: scheduler.over is not None, job["done"])
        # A program of ROS 1 runs classes: what is called as a test besides is none.
        only = ("-o", "python_functions=no_function") if job["ros"] == 1 else ()
        pytest.main([*options(job), *only, job["file"]], plugins=[reporter])

    def tests() -> None:
        if job["ros"] == 1:
            sys.path += [item for item in job["paths"] if item not in sys.path]
            run_program(job, runtime, run_tests)
            # Its node would live on.
            stream.flush()
            os._exit(0)
        serve_build_products(job["aliases"], job["modules"])
        run_tests()

    with (
        Path(job["report"]).open("a", encoding="utf-8") as stream,
        activate(runtime),
        StandInFinder(interfaces),
        virtual_time(scheduler),
    ):
        with contextlib.suppress(RunOver):
            scheduler.run_main(tests)
        stream.flush()
        os._exit(0)


if __name__ == "__main__":
    main()
