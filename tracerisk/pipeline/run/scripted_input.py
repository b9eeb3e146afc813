"""A standard input that says scripted answers, then Enter."""

from __future__ import annotations

import builtins
import contextlib
import io
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from types import ModuleType
from typing import NoReturn

from tracerisk.common.replaced_names import replaced
from tracerisk.instrument.recorder import Recorder
from tracerisk.ros.controller.needs import Need, asking_place
from tracerisk.ros.drafts.answers.known_answers import KnownAnswers
from tracerisk.ros.imports.once_loaded import once_loaded
from tracerisk.ros.keyboard.scripted_keys import STDIN, ScriptedKeys
from tracerisk.ros.time.scheduler import Scheduler

_ASKED_IN_VAIN = 200
_TAKES_NO_ENTER = 3
_SEEN_NS = 100_000_000
_TYPED_NS = 1_000_000_000  # from one answer to the next, as from one key to the next
_LOOKS = 3  # a subscription that is not connected yet gets its message a little later
_MOST_TIMES = 10  # that a user goes on where a question is whether to
_GO_ON = re.compile(r"y|yes|ok|c|continue|go|n|next|proceed", re.IGNORECASE)
_MOST_REST_NS = 60_000_000_000  # that a user waits for the arm to come to rest
_FOR_ENTER = re.compile(
    r"\b(press|hit|push)\b.*\b(enter|return|any key)\b|\benter to\b"
    r"|[\[<(`'\"](enter|return)[\]>)`'\"]",
    re.IGNORECASE | re.DOTALL,
)


@contextlib.contextmanager
def scripted_input(stream: Answers) -> Iterator[None]:
    """Give `input()` and reads of the standard input the answers in turn, then Enter."""
    real_input, real_stdin = builtins.input, sys.stdin

    def scripted(prompt: object = "", /) -> str:
        print(prompt, end="", flush=True)  # noqa: T201 - the controller's own output
        stream.prompt = str(prompt).strip()
        return stream.readline().rstrip("\n")

    builtins.input, sys.stdin = scripted, stream
    try:
        with stream.keys.served(), _served_screen(stream.keys):
            yield
    finally:
        builtins.input, sys.stdin = real_input, real_stdin


@contextlib.contextmanager
def _served_screen(keys: ScriptedKeys) -> Iterator[None]:
    """Stand in for the screen of `curses` once a program loads that, which a Python may lack."""

    def serve(_: ModuleType) -> None:
        from tracerisk.ros.keyboard.screen import screen_functions

        undo.enter_context(replaced(screen_functions(keys)))

    with contextlib.ExitStack() as undo, once_loaded("curses", serve):
        yield


@dataclass(eq=False, repr=False)
class Answers(io.TextIOBase):
    """The answers line by line.

    What waits for a line or a key gets Enter when they are used up; what reads to the end of the
    input finds it there, as behind a pipe.

    Each answer is noted in the recording. A question that gets Enter is a need that is not met,
    and one that is asked again and again ends the run: as a loop that commands nothing any more
    where it was answered before, and something was commanded. A controller that reads keys gets
    each answer as one.

    A question whose code knows answers with which it goes on gets these, each once and what leaves
    it last; so does one that comes again and again without progress, for it does not take Enter.
    Each is an assumption. A user who has given all of them, and has seen the arm move, is done.
    """

    answers: Sequence[str]
    """The answers in the order in which they are given."""
    recorder: Recorder
    """The recording in which each answer is noted."""
    scheduler: Scheduler
    """The scheduler that ends the run and notes unmet needs."""
    script: str
    """The controller's file, in which the keys that it reads are compared."""
    assume: Callable[[], KnownAnswers]
    """Returns the answers that the code knows at the place that asks."""
    progress: Callable[[], object]
    """Returns a value that changes whenever the controller has made progress."""
    firsts_come_ns: Callable[[], int] = lambda: 0
    """Returns when what the controller listens to has said something: answers come after that."""
    is_moving: Callable[[], bool] = lambda: False
    """Returns whether a motion is under way, after which the next answer comes."""
    prompt: str = field(default="", init=False)
    """The text of the last question; empty for none."""
    _asked_of: dict[str, _Question] = field(default_factory=dict, init=False)
    """What is known of each question without a scripted answer."""
    _last_asked: tuple[str, object] = field(default=("", None), init=False)
    """The last question, and the progress when it was asked."""
    _times: int = field(default=0, init=False)
    """How many times in a row the last question came without progress."""
    _was_assumed: bool = field(default=False, init=False)
    """Whether the last answer was assumed: the next comes after what it led to."""
    _line: str = field(default="", init=False)
    """What is left of the answer that is being read."""

    def __post_init__(self) -> None:
        self.keys = ScriptedKeys(self._given, self.scheduler, self.script)
        self.buffer = AnswerBytes(self)
        self._left = list(self.answers)

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Return what a terminal's would be."""
        return "utf-8"

    def readable(self) -> bool:
        """Return that it can be read."""
        return True

    def fileno(self) -> int:
        """Return the descriptor of the standard input, whose keys are scripted too."""
        return STDIN

    def seekable(self) -> bool:
        """Return that it has no places to go to, as a terminal."""
        return False

    def readline(self, size: int | None = -1, /) -> str:  # type: ignore[override]
        """Return the next answer or what is left of it, or a key."""
        if self.keys.is_raw:
            return self.keys.read(1 if size is None or size < 0 else size)
        if not self._line:
            self._next_answer()
        return self._take(size)

    def read(self, size: int | None = -1, /) -> str:
        """Return all answers, or as much as is asked for."""
        if (size is None or size < 0) and not self.keys.is_raw:
            return "".join(self)
        return self.readline(size)

    def __next__(self) -> str:  # type: ignore[override]
        if not self._line and not self._left:
            raise StopIteration
        return self.readline()

    def detach(self) -> NoReturn:
        """Raise, for there is nothing to part from."""
        raise io.UnsupportedOperation("the answers are text and have no bytes below them")

    def _given(self) -> str | None:
        """Return the next of the answers that were given, None where none is left."""
        if not self._left:
            return None
        answer = self._left.pop(0)
        self.recorder.note("input", answer=answer)
        return answer

    def _next_answer(self) -> None:
        for _ in range(_LOOKS if self._left else 0):
            # Who answers has seen what came; the callbacks for it have run.
            if (due_ns := self.firsts_come_ns()) > self.scheduler.now_ns:
                self.scheduler.pass_until(due_ns + _SEEN_NS)
        # Who has scripted answers may mean to give the next one during a motion.
        answer = self._given()
        if answer is not None:
            self.scheduler.needs.meet(Need("input", self._asked))
            self._was_assumed = False
        else:
            answer = self._unscripted()
            self.recorder.note("input", answer=answer)
            self._was_assumed = bool(answer)
        self._line = f"{answer}\n"

    def _see_motions(self) -> None:
        """Wait for what the answer before has set in motion: a user sees it end."""
        self.scheduler.pass_until(self.scheduler.now_ns + _TYPED_NS)
        self.scheduler.wait_until(
            lambda: not self.is_moving(), timeout_ns=_MOST_REST_NS, reason="the arm to rest"
        )

    @property
    def _asked(self) -> str:
        if self.prompt:
            return repr(self.prompt)
        # Each question without words is one of its own.
        place = asking_place()
        line = "" if place is None else f" in line {place.line}"
        return f"a read of the standard input{line}"

    def _unscripted(self) -> str:
        """Return an answer that the code knows, or Enter."""
        asked = self._asked
        question = self._asked_of.setdefault(asked, _Question(self.assume()))
        # Who has answered it by --answer or a scenario has said all.
        was_scripted = self.scheduler.needs.is_met("input", asked)
        takes_enter = was_scripted or question.takes_enter(self.prompt)
        if self._was_assumed or (self.progress() is not None and not takes_enter):
            self._see_motions()
        now = asked, self.progress()
        self._times = self._times + 1 if now == self._last_asked else 1
        self._last_asked = now
        self.scheduler.touch()
        if self._times >= _TAKES_NO_ENTER or not takes_enter:
            answer = question.next_answer(now)
            if answer is None and any(other.may_say_more for other in self._asked_of.values()):
                # A part of what another question leads to.
                answer = question.again()
            if answer is not None:
                # A scenario lacks it still.
                self.scheduler.miss(Need("input", asked))
                self.recorder.finding(
                    "answer_assumed",
                    f"nobody answers {asked}: {question.words} is assumed, as its code would take "
                    "it; --answer gives another",
                    asking_place(),
                    object_name=asked,
                )
                if not self._was_assumed:
                    # Who types it has seen what the program says when it begins.
                    self.scheduler.pass_until(self.scheduler.now_ns + _TYPED_NS)
                return answer
            if question.is_answered and self.progress() is not None:
                words = f"{asked} was given each answer that its code knows"
                self.scheduler.end("idle", words, asking_place())
        self.scheduler.miss(Need("input", asked))
        if self._times == _ASKED_IN_VAIN:
            # A menu that has moved the arm waits for a user who has said all.
            is_over = was_scripted and self.progress() is not None
            self.scheduler.end(
                "idle" if is_over else "deadlock",
                f"the answer to {asked} was asked for {_ASKED_IN_VAIN} times and was only "
                "Enter each time",
            )
        return ""

    def _take(self, size: int | None) -> str:
        end = len(self._line) if size is None or size < 0 else size
        taken, self._line = self._line[:end], self._line[end:]
        return taken


class _Question:
    """What a user says to one question, in turn."""

    def __init__(self, known: KnownAnswers) -> None:
        self._known = known
        self._left = [*known.in_turn]
        self._given = 0
        self._seen: object = None

    @property
    def is_answered(self) -> bool:
        """Whether it was given an answer that the code knows."""
        return self._given > 0

    @property
    def words(self) -> str:
        """The answers that it is given, in words."""
        return ", then ".join(map(repr, self._known.in_turn))

    @property
    def may_say_more(self) -> bool:
        """Whether there are answers that it was not given."""
        return bool(self._left)

    def again(self) -> str | None:
        """Return the first of its answers once more, None after many times."""
        if not self._known.going_on or self._given >= _MOST_TIMES:
            return None
        self._given += 1
        return self._known.going_on[0]

    def takes_enter(self, prompt: str) -> bool:
        """Return whether Enter may do: it is asked for, or nothing else is known to go on."""
        return not self._known.going_on or _FOR_ENTER.search(prompt) is not None

    def next_answer(self, seen: object) -> str | None:
        """Return the next answer, None after the last; `seen` changes where one led on.

        Who is asked whether to go on says so again. One answer is given again to a question that
        is asked several times before anything comes of it.
        """
        has_led_on, self._seen = seen != self._seen, seen
        known = self._known
        if len(known.going_on) == 1 and 0 < self._given < _MOST_TIMES:
            is_whether = bool(known.leaving) and _GO_ON.fullmatch(known.going_on[0]) is not None
            if is_whether if has_led_on else not known.leaving:
                return self.again()
        if not self._left:
            return None
        self._given += 1
        return self._left.pop(0)


class AnswerBytes(io.BufferedIOBase):
    """The answers as bytes, for who reads `sys.stdin.buffer`; they are the same answers."""

    def __init__(self, answers: Answers) -> None:
        super().__init__()
        self._answers = answers
        self._left = b""

    def readable(self) -> bool:
        """Return that it can be read."""
        return True

    def fileno(self) -> int:
        """Return the descriptor of the standard input, whose keys are scripted too."""
        return STDIN

    def readline(self, size: int | None = -1, /) -> bytes:
        """Return the next answer or what is left of it."""
        if not self._left:
            self._left = self._answers.readline().encode()
        end = len(self._left) if size is None or size < 0 else size
        taken, self._left = self._left[:end], self._left[end:]
        return taken

    def read(self, size: int | None = -1, /) -> bytes:
        """Return all answers, or as much of the next one as is asked for."""
        if size is None or size < 0:
            taken, self._left = self._left, b""
            return taken + self._answers.read().encode()
        return self.readline(size)

    read1 = read

    def __next__(self) -> bytes:
        if self._left:
            return self.readline()
        return next(self._answers).encode()
