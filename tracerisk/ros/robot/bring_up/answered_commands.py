"""Commands of ROS that programs start, answered without a process: `xacro`, and those that list.

No ROS is installed, so the program would end with an exception for want of the command.
"""

from __future__ import annotations

import contextlib
import io
import os
import shlex
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from tracerisk.common.replaced_names import replaced
from tracerisk.errors import TraceRiskError
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.robot.bring_up.list_commands import listing
from tracerisk.twin.urdf.semantic_text import srdf_text
from tracerisk.twin.urdf.text import urdf_text
from tracerisk.twin.urdf.xacro_files import expand_xacro

_STARTS = (("xacro",), ("rosrun", "xacro", "xacro"), ("ros2", "run", "xacro", "xacro"))
_MOVING = ("revolute", "continuous", "prismatic")
_MOST_SHOWN = 4
_TEXT = ("text", "universal_newlines", "encoding", "errors")


@contextlib.contextmanager
def answered_commands(runtime: Runtime) -> Iterator[None]:
    """Answer the commands while this is open, however `subprocess` or `os` starts them."""

    class Popen(subprocess.Popen[Any]):
        """A process, or the answer of a command in its place."""

        def __new__(cls, args: Any, *_: Any, **how: Any) -> Any:
            answer = _answer(args, runtime)
            if answer is None:
                return super().__new__(cls)
            return _AnsweredProcess(args, answer(), how)

    real_popen = os.popen

    def popen(command: str, *rest: Any, **how: Any) -> Any:
        answer = _answer(command, runtime)
        if answer is None:
            return real_popen(command, *rest, **how)
        return io.StringIO(answer())

    with replaced([(subprocess, "Popen", Popen), (os, "popen", popen)]):
        yield


def _answer(args: Any, runtime: Runtime) -> Callable[[], str] | None:
    """Return what makes the output of a command that is answered here; `None` for any other."""
    words = _words(args)
    for start in _STARTS:
        if tuple(words[: len(start)]) == start:
            return partial(_expanded, words[len(start) :], runtime)
    return listing(words, runtime)


def _words(args: Any) -> list[str]:
    """Return a command and its arguments; none where they are no words."""
    try:
        given = (
            shlex.split(args)
            if isinstance(args, str)
            else [os.fspath(argument) for argument in args]
        )
    except (TypeError, ValueError):
        return []
    words = [name.decode(errors="replace") if isinstance(name, bytes) else name for name in given]
    if words:
        words[0] = words[0].rpartition("/")[2]
    return words


def _expanded(words: Sequence[str], runtime: Runtime) -> str:
    """Return what xacro would write for its arguments.

    Of a file that cannot be expanded here, it is the robot that is simulated, with a finding.
    """
    given = dict(word.split(":=", 1) for word in words if ":=" in word)
    files = [word for word in words if ":=" not in word and not word.startswith("-")]
    output = next((words[at + 1] for at in range(len(words) - 1) if words[at] == "-o"), None)
    path = Path(next((file for file in files if file != output), ""))
    robot, assumed = runtime.twin.robot, ""
    try:
        text = expand_xacro(path, runtime.findable, arguments=given).decode()
    except (TraceRiskError, OSError) as error:
        reason = error.message if isinstance(error, TraceRiskError) else str(error)
        text = srdf_text(robot) if ".srdf" in path.name else urdf_text(robot)
        assumed = f"xacro {path.name} is answered with {robot.name}, which is simulated: {reason}"
    else:
        others = sorted(_moving(text) - {joint.name for joint in robot.joints})
        if others:
            assumed = (
                f"xacro makes a robot of {path.name} with {', '.join(others[:_MOST_SHOWN])}, and "
                f"{robot.name} is simulated, which has no such joint"
            )
    if assumed:
        runtime.recorder.finding("answer_assumed", assumed, object_name=path.name)
    if output is None:
        return text
    Path(output).write_text(text, encoding="utf-8")
    return ""


def _moving(text: str) -> set[str]:
    """Return the joints of a description that move; none of another document."""
    try:
        top = ET.fromstring(text)
    except ET.ParseError:
        return set()
    moving = [element for element in top.findall("joint") if element.get("type") in _MOVING]
    return {element.get("name", "") for element in moving}


class _AnsweredProcess:
    """A process that has ended well, with what it wrote."""

    pid = 0
    returncode = 0
    stdin = None

    def __init__(self, args: Any, text: str, how: dict[str, Any]) -> None:
        self.args = args
        is_text = any(how.get(name) for name in _TEXT)
        self._said: str | bytes = text if is_text else text.encode()
        self._quiet: str | bytes = "" if is_text else b""
        make: Any = io.StringIO if is_text else io.BytesIO
        target: Any = how.get("stdout")
        self.stdout = make(self._said) if target == subprocess.PIPE else None
        self.stderr = make(self._quiet) if how.get("stderr") == subprocess.PIPE else None
        if hasattr(target, "write"):
            target.write(self._said if "b" in getattr(target, "mode", "") else text)

    def communicate(self, *_: Any, **__: Any) -> tuple[Any, Any]:
        """Return what it wrote, on pipes alone."""
        said = None if self.stdout is None else self._said
        return said, None if self.stderr is None else self._quiet

    def wait(self, *_: Any, **__: Any) -> int:
        """Return its exit code."""
        return 0

    poll = wait

    def kill(self) -> None:
        """Do nothing: it has ended."""

    terminate = kill

    def __enter__(self) -> _AnsweredProcess:
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the block."""
