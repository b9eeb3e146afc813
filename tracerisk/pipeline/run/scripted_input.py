"""A standard input that says scripted answers, then Enter."""

from __future__ import annotations

import builtins
import contextlib
import io
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import NoReturn

from tracerisk.instrument.recording import Recorder
from tracerisk.ros.controller.needs import Need, asking_place

_STDIN = 0
_ASKED_IN_VAIN = 200
_TAKES_NO_ENTER = 3


@contextlib.contextmanager
def scripted_input(
    answers: Sequence[str],
    recorder: Recorder,
    touch: Callable[[], None],
    miss: Callable[[Need], None],
    give_up: Callable[[str], None],
    assume: Callable[[], Sequence[str]] = tuple,
    progress: Callable[[], object] = lambda: None,
) -> Iterator[None]:
    """Give `input()` and reads of the standard input the answers in turn, then Enter.

    Each answer is noted in the recording. `touch` is called at each Enter: a loop that asks and
    asks is a busy wait, and must end. `miss` is called with each question that got Enter, and
    `give_up` ends the run at one that is asked again and again.

    A question that comes again and again with no `progress` between does not take Enter: it gets
    what `assume` returns for it, in turn, and each is an assumption.
    """
    stream = _Answers(answers, recorder, touch, miss, give_up, assume, progress)
    real_input, real_stdin = builtins.input, sys.stdin

    def scripted(prompt: object = "", /) -> str:
        print(prompt, end="", flush=True)  # noqa: T201 - the controller's own output
        stream.prompt = str(prompt).strip()
        return stream.readline().rstrip("\n")

    builtins.input, sys.stdin = scripted, stream
    try:
        yield
    finally:
        builtins.input, sys.stdin = real_input, real_stdin


class _Answers(io.TextIOBase):
    """The answers line by line.

    What waits for a line or a key gets Enter when they are used up; what reads to the end of
    the input finds it there, as behind a pipe.
    """

    def __init__(
        self,
        answers: Sequence[str],
        recorder: Recorder,
        touch: Callable[[], None],
        miss: Callable[[Need], None],
        give_up: Callable[[str], None],
        assume: Callable[[], Sequence[str]],
        progress: Callable[[], object],
    ) -> None:
        self.prompt = ""
        self._assume = assume
        self._progress = progress
        self._assumed: dict[str, list[str]] = {}
        self._miss = miss
        self._give_up = give_up
        self._last_asked: tuple[str, object] = ("", None)
        self._times = 0
        self._answers = list(answers)
        self._line = ""
        self._recorder = recorder
        self._touch = touch

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return "utf-8"

    def readable(self) -> bool:
        return True

    def fileno(self) -> int:
        return _STDIN

    def seekable(self) -> bool:
        return False

    def readline(self, size: int | None = -1, /) -> str:  # type: ignore[override]
        if not self._line:
            self._next_answer()
        return self._take(size)

    def read(self, size: int | None = -1, /) -> str:
        if size is None or size < 0:
            return "".join(self)
        return self.readline(size)

    def __next__(self) -> str:  # type: ignore[override]
        if not self._line and not self._answers:
            raise StopIteration
        return self.readline()

    def detach(self) -> NoReturn:
        raise io.UnsupportedOperation("the answers are text and have no bytes below them")

    def _next_answer(self) -> None:
        answer = self._answers.pop(0) if self._answers else self._unscripted()
        self._recorder.note("input", answer=answer)
        self._line = f"{answer}\n"

    def _unscripted(self) -> str:
        """Return Enter, or an answer that the code knows where Enter leads nowhere."""
        asked = repr(self.prompt) if self.prompt else "a read of the standard input"
        now = asked, self._progress()
        self._times = self._times + 1 if now == self._last_asked else 1
        self._last_asked = now
        if self._times == _TAKES_NO_ENTER and asked not in self._assumed:
            self._assumed[asked] = list(self._assume())
        self._touch()
        if self._assumed.get(asked):
            answer = self._assumed[asked].pop(0)
            self._recorder.finding(
                "answer_assumed",
                f"{asked} does not take Enter: {answer!r} is assumed, as its code would take it; "
                "--answer gives another",
                asking_place(),
                object_name=asked,
            )
            return answer
        self._miss(Need("input", asked))
        if self._times == _ASKED_IN_VAIN:
            self._give_up(
                f"the answer to {asked} was asked for {_ASKED_IN_VAIN} times and was only "
                "Enter each time"
            )
        return ""

    def _take(self, size: int | None) -> str:
        end = len(self._line) if size is None or size < 0 else size
        taken, self._line = self._line[:end], self._line[end:]
        return taken
