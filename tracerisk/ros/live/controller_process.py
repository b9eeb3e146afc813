"""The process of a controller that runs on real rospy or rclpy, traced, under the Python of ROS.

What tracerisk needs of its own packages stands at the end of the path: the controller gets the
libraries that it would get without tracerisk.
"""

from __future__ import annotations

import importlib
import json
import os
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import Location, TraceRiskError
from tracerisk.instrument.import_finder import ControllerFinder, controller_imports
from tracerisk.instrument.loader import prepared_controller
from tracerisk.instrument.tracer import Tracer
from tracerisk.ros.live.link import Link, end_with

_DRAINED_S = 0.2


def main() -> None:
    """Run the controller that the command line describes in JSON, and report how it ended."""
    asked = json.loads(sys.argv[1])
    link = Link(socket.socket(fileno=asked["descriptor"]))
    tracer = Tracer(lambda ref, line: report(_ran(ref, line)))

    def report(header: dict[str, Any], body: bytes = b"") -> None:
        try:
            link.send(header, body)
        except OSError:
            # The twin's side is gone: the run is over.
            os._exit(1)

    tracer.on_source = lambda file, source: report(
        {"is": "source", "file": file, "latin1": source.decode("latin-1")}
    )
    tracer.on_iteration = lambda file, line: report(
        {"is": "looped", "file": file, "line": line, "thread": threading.get_ident()}
    )
    end_with(link, 1, _hooked(tracer, report, asked))
    sys.path += asked["paths"]
    sys.dont_write_bytecode = True
    script, root = Path(asked["script"]), Path(asked["root"])
    finder = ControllerFinder(
        tracer, root, packages={name: Path(item) for name, item in asked["packages"].items()}
    )
    try:
        prepared = prepared_controller(
            script, tracer, asked["argv"], root=root, entry=asked["entry"]
        )
        with prepared as run, controller_imports(finder):
            report({"is": "begins", "thread": threading.get_ident()})
            code = _run(run, tracer, report, asked["ros"])
    except TraceRiskError as error:
        place = error.location
        data = None if place is None else [place.file, place.line, place.column]
        name = type(error).__name__
        report({"is": "refused", "error": name, "message": error.message, "location": data})
        code = int(error.exit_code)
    sys.exit(code)


def _hooked(tracer: Tracer, report: Any, asked: dict[str, Any]) -> Callable[[Any], None]:
    """Hook the client library, and return what takes the frames of the twin's side."""
    take = {"calls": lambda header: _report_calls(tracer, report)}  # noqa: ARG005
    if asked["ros"] == 1:
        rospy_hooks: Any = importlib.import_module("tracerisk.ros.live.rospy_hooks")
        rospy_hooks.install(tracer, report, asked["private"])
    else:
        hooks: Any = importlib.import_module("tracerisk.ros.live.ros2.hooks")
        set_time = hooks.install(tracer, report, asked["parameter_file"], asked["domain"])
        take["time"] = lambda header: set_time(header["ns"])
    return lambda header: take[header["do"]](header)


def _report_calls(tracer: Tracer, report: Any) -> None:
    """Report which calls of the controller's files were executed, while threads may go on."""
    while True:
        try:
            report({"is": "calls", "data": tracer.executed_calls()})
        except RuntimeError:  # one of them has just executed another
            continue
        return


def _has_node(ros: int) -> bool:
    """Return whether the controller has begun to be a node, whose messages may be on their way."""
    if ros == 1:
        return bool(importlib.import_module("rospy").core.is_initialized())
    return "rclpy" in sys.modules


def _run(run: Any, tracer: Tracer, report: Any, ros: int) -> int:
    def end(cause: str, message: str, place: Location | None = None) -> None:
        data = None if place is None else [place.file, place.line, place.column]
        _report_calls(tracer, report)
        report({"is": "end", "cause": cause, "message": message, "location": data})

    try:
        run()
    except SystemExit as error:
        code = error.code if isinstance(error.code, int) else 0 if error.code is None else 1
        end("exited" if code else "ended", f"the controller exited with {error.code}")
        return code
    except BaseException as error:  # noqa: BLE001 - the controller's own, reported as it is
        words = "".join(traceback.format_exception_only(error)).strip()
        traceback.print_exception(error)
        missing = isinstance(error, ImportError | SyntaxError)
        if isinstance(error, ImportError):
            words += (
                f"; install it for {sys.executable}, or build its workspace and source that, or "
                "leave out --live: on the stand-ins, many libraries need not be there"
            )
        end("not_importable" if missing else "raised", words, tracer.where_failed(error))
        return 1
    # A real process lasts as long as threads that are no daemons; what was published goes out.
    for thread in threading.enumerate():
        if thread is not threading.current_thread() and not thread.daemon:
            # As a main thread that spins: actionlib's servers wait for goals in such threads.
            report({"is": "spins"})
            thread.join()
    end("ended", "the controller ended")
    if _has_node(ros):
        time.sleep(_DRAINED_S)
    return 0


def _ran(ref: FunctionRef, line: int) -> dict[str, Any]:
    return {"is": "ran", "file": ref.file, "name": ref.name, "line": line}


if __name__ == "__main__":
    main()
