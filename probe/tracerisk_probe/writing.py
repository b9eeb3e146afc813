"""What is recorded, on its way to a file and to a topic.

A command costs its caller a stack and a queue; a thread makes JSON of it, writes and publishes.
"""

from __future__ import annotations

import collections
import json
import os
import queue
import sys
import threading
import time
from typing import Any, Callable, Sequence

from tracerisk_probe.stacks import Frame

FORMAT = "tracerisk-probe/1"
TOPIC = "/tracerisk/commands"
MOST_WAITING = 100_000
"""How many objects may wait to be written; more are dropped, and their count is written."""
WAIT_FOR_READER_S = 5.0
"""How long the first commands wait for somebody to subscribe to the topic [s]."""
_POLL_S = 0.05

Publish = Callable[[str], None]


class Topic:
    """Where objects are published, once a node of ROS is up."""

    def __init__(self) -> None:
        self._waiting: collections.deque[str] = collections.deque(maxlen=MOST_WAITING)
        self._publish: Publish | None = None
        self._has_reader: Callable[[], bool] = lambda: True
        self._give_up_at = 0.0
        self.is_used = False

    def open(self, publish: Publish, has_reader: Callable[[], bool]) -> None:
        """Publish by `publish` from now on, what waits first, once `has_reader` says so."""
        self._publish = publish
        self._has_reader = has_reader
        self._give_up_at = time.monotonic() + WAIT_FOR_READER_S
        self.is_used = True

    def close(self) -> None:
        """Publish no more: the node goes."""
        self.send(at_once=True)
        self._publish = None

    def put(self, text: str) -> None:
        """Keep a text until it is sent."""
        self._waiting.append(text)

    def send(self, *, at_once: bool = False) -> None:
        """Publish what waits, if there is a node, and somebody to read or no time left."""
        if self._publish is None or not self._waiting:
            return
        if not at_once and time.monotonic() < self._give_up_at and not self._has_reader():
            return
        self._give_up_at = 0.0
        while self._waiting:
            try:
                self._publish(self._waiting.popleft())
            except Exception as error:  # noqa: BLE001 -- the node's end is no error of the controller
                self._publish = None
                _report(f"nothing more is published: {type(error).__name__}: {error}")
                return


class Output:
    """Writes objects as lines of JSON to a file, if there is one, and to the topic.

    `before_sending` (an attribute) is called by the writing thread, to look for a node.
    """

    def __init__(self, path: str | None, topic: Topic | None) -> None:
        self.path = path
        self._queue: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._descriptor = -1
        if path is not None:
            flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND
            self._descriptor = os.open(path, flags | getattr(os, "O_CLOEXEC", 0), 0o644)
        self.topic = topic
        self.before_sending: Callable[[], None] = lambda: None
        self._dropped = 0
        self._reported = 0
        self._last: dict[str, Any] = {}
        self._start()
        os.register_at_fork(after_in_child=self._forked)

    def put(self, fields: dict[str, Any], stack: Sequence[Frame] = ()) -> None:
        """Have an object written; returns at once."""
        if self._queue.qsize() >= MOST_WAITING:
            self._dropped += 1
            return
        self._say_dropped(fields)
        self._queue.put((fields, stack))
        self._last = fields

    def flush(self, timeout_s: float = 2.0) -> None:
        """Return when all that was put is written, or time is over."""
        if threading.current_thread() is self._thread or not self._thread.is_alive():
            return
        self._say_dropped(self._last)
        done = threading.Event()
        self._queue.put(done)
        done.wait(timeout_s)

    def _say_dropped(self, at: dict[str, Any]) -> None:
        """Have it written how many objects were dropped, at the time of another object."""
        count = self._dropped - self._reported
        if not count:
            return
        self._reported += count
        _report(f"{count} objects were dropped: they came faster than they were written")
        said: dict[str, Any] = {name: at[name] for name in ("t", "pid") if name in at}
        self._queue.put(({**said, "kind": "dropped", "count": count}, ()))

    def _start(self) -> None:
        self._thread = threading.Thread(target=self._run, name="tracerisk-probe", daemon=True)
        # Not by a `start` that hands stacks on.
        getattr(threading.Thread.start, "__wrapped__", threading.Thread.start)(self._thread)

    def _forked(self) -> None:
        self._queue = queue.SimpleQueue()
        self.topic = None  # the node is the parent's
        self._start()

    def _run(self) -> None:
        waiting = self._queue
        while waiting is self._queue:
            try:
                item = waiting.get(timeout=_POLL_S if self.topic is not None else None)
            except queue.Empty:
                item = None
            if isinstance(item, tuple):
                self._write(*item)
            if self.topic is not None:
                self.before_sending()
                self.topic.send(at_once=isinstance(item, threading.Event))
            if isinstance(item, threading.Event):
                item.set()

    def _write(self, fields: dict[str, Any], stack: Sequence[Frame]) -> None:
        if stack:
            fields["root"] = stack[0].root or "thread"
            fields["stack"] = [f"{each.file}:{each.name}" for each in stack]
            fields["at"] = [[each.activation, each.line, *each.at] for each in stack]
        text = json.dumps(fields, separators=(",", ":"), default=str)
        if self.topic is not None:
            self.topic.put(text)
        if self._descriptor >= 0:
            line = memoryview(f"{text}\n".encode())
            try:
                while line:
                    line = line[os.write(self._descriptor, line) :]
            except OSError as error:
                self._descriptor = -1
                _report(f"{self.path}: nothing more is written: {error.strerror}")


def _report(message: str) -> None:
    sys.stderr.write(f"tracerisk-probe: {message}\n")
