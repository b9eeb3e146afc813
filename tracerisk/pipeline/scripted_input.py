"""A standard input that says scripted answers, then Enter."""

from __future__ import annotations

import builtins
import contextlib
import io
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import NoReturn

from tracerisk.instrument.recording import Recorder
from tracerisk.ros.needs import Need

_STDIN = 0
_ASKED_IN_VAIN = 200


@contextlib.contextmanager
def scripted_input(
    answers: Sequence[str],
    recorder: Recorder,
    touch: Callable[[], None],
    miss: Callable[[Need], None],
    give_up: Callable[[str], None],
) -> Iterator[None]:
    """Give `input()` and reads of the standard input the answers in turn, then Enter.

    Each answer is noted in the recording. `touch` is called at each Enter: a loop that asks and
    asks is a busy wait, and must end. `miss` is told of each question that got Enter, and
    `give_up` ends the run at one that is asked again and again.
    """
    stream = _Answers(answers, recorder, touch, miss, give_up)
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
    ) -> None:
        self.prompt = ""
        self._miss = miss
        self._give_up = give_up
        self._last_asked, self._times = "", 0
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
        if not self._answers:
            asked = repr(self.prompt) if self.prompt else "a read of the standard input"
            self._miss(Need("input", asked))
            self._times = self._times + 1 if asked == self._last_asked else 1
            self._last_asked = asked
            if self._times == _ASKED_IN_VAIN:
                self._give_up(
                    f"the answer to {asked} was asked for {_ASKED_IN_VAIN} times and was only "
                    "Enter each time"
                )
            self._touch()
        answer = self._answers.pop(0) if self._answers else ""
        self._recorder.note("input", answer=answer)
        self._line = f"{answer}\n"

    def _take(self, size: int | None) -> str:
        end = len(self._line) if size is None or size < 0 else size
        taken, self._line = self._line[:end], self._line[end:]
        return taken
