"""The process of a controller that runs on real rospy, traced, under the Python of ROS.

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
from pathlib import Path
from typing import Any

from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import Location, TraceRiskError
from tracerisk.instrument.import_finder import ControllerFinder, controller_imports
from tracerisk.instrument.loader import prepared_controller
from tracerisk.instrument.tracer import Tracer
from tracerisk.ros.live.link import Link, end_with
from tracerisk.ros.live.rospy_hooks import install

_DRAINED_S = 0.2


def main() -> None:
    """Run the controller that the command line describes in JSON, and report how it ended."""
    asked = json.loads(sys.argv[1])
    link = Link(socket.socket(fileno=asked["descriptor"]))
    tracer = Tracer(lambda ref, line: report(_ran(ref, line)))

    def report(header: dict[str, Any]) -> None:
        try:
            link.send(header)
        except OSError:
            # The twin's side is gone: the run is over.
            os._exit(1)

    tracer.on_source = lambda file, source: report(
        {"is": "source", "file": file, "latin1": source.decode("latin-1")}
    )
    tracer.on_iteration = lambda file, line: report(
        {"is": "looped", "file": file, "line": line, "thread": threading.get_ident()}
    )
    end_with(link, 1)
    rospy: Any = importlib.import_module("rospy")
    install(tracer, report, asked["private"])
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
            code = _run(run, tracer, report, rospy)
    except TraceRiskError as error:
        place = error.location
        data = None if place is None else [place.file, place.line, place.column]
        name = type(error).__name__
        report({"is": "refused", "error": name, "message": error.message, "location": data})
        code = int(error.exit_code)
    sys.exit(code)


def _run(run: Any, tracer: Tracer, report: Any, rospy: Any) -> int:
    def end(cause: str, message: str, place: Location | None = None) -> None:
        data = None if place is None else [place.file, place.line, place.column]
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
        end("not_importable" if missing else "raised", words, tracer.where_failed(error))
        return 1
    # A real process lasts as long as threads that are no daemons; what was published goes out.
    for thread in threading.enumerate():
        if thread is not threading.current_thread() and not thread.daemon:
            # As a main thread that spins: actionlib's servers wait for goals in such threads.
            report({"is": "spins"})
            thread.join()
    end("ended", "the controller ended")
    if rospy.core.is_initialized():
        time.sleep(_DRAINED_S)
    return 0


def _ran(ref: FunctionRef, line: int) -> dict[str, Any]:
    return {"is": "ran", "file": ref.file, "name": ref.name, "line": line}


if __name__ == "__main__":
    main()
