"""Values that a repository writes for what a controller needs: commands, YAML, launch files, code.

A reader of the repository would take them first: the `rostopic pub` of its readme, the parameters
of its configuration, what a test or another program publishes on the same topic. Nothing is run.
"""

from __future__ import annotations

import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from tracerisk.common.text.bounded import file_text
from tracerisk.common.text.yaml_reader import plain_yaml
from tracerisk.config import PACKAGE_FILE
from tracerisk.instrument.source.literals.answers import ordered_answers, without_emergency
from tracerisk.instrument.source.literals.filled_messages import filled_fields, plain_value
from tracerisk.pipeline.launch.program import Program
from tracerisk.pipeline.scenarios.shell_words import command_words, is_named, positional_words
from tracerisk.pipeline.scenarios.written_frames import (
    COMMAND,
    PROGRAM,
    launched_arguments,
    on_top,
    static_frame,
)
from tracerisk.pipeline.workspace.controller import from_root
from tracerisk.pipeline.workspace.workspace import searched
from tracerisk.ros.controller.needs import Need

_MOST_FILES = 4000
_MOST_BYTES = 512 * 1024
_MOST_IN_TURN = 16  # messages that one file shows
_TEXTS = (".md", ".rst", ".txt", ".sh", ".bash", ".py", ".yml", ".yaml", ".launch", ".xml")
_PUBLISHES = re.compile(
    r"(?:rostopic|ros2\s+topic)\s+pub\b|(?:rosservice|ros2\s+service)\s+call\b|"
    r"ros2\s+action\s+send_goal\b|rosparam\s+set\b|ros2\s+param\s+set\b"
)
_RUNS = re.compile(
    r"(?:rosrun|ros2\s+run|python[23]?(?:\.\d+)?)\s|(?<![\w/.])\./[\w/.-]+\s|"
    r"(?:usage|example|e\.g\.)\s*:\s*(?=[\w./-]+\.py\s)",
    re.IGNORECASE,
)
_PATH = re.compile(r"[\w.-]{1,99}(/[\w.-]{1,99}){1,20}")
_PLACEHOLDER = re.compile(r"^[\[<{].*[\]>}]?$|^\.\.\.$|[<>{}\[\]$|]")


@dataclass(frozen=True, slots=True)
class Written:
    """A value that the repository writes."""

    value: Any
    """The plain value; a mapping of fields for a message."""
    place: str
    """The file and line, `README.md:12`."""
    is_whole: bool = True
    """Whether it is complete; false where a program computes further fields."""
    in_turn: tuple[Any, ...] = ()
    """Of messages on a topic all that the same file shows, in turn; empty for one alone."""


@dataclass(frozen=True, slots=True)
class _Command:
    words: tuple[str, ...]
    """The words of the command line, program included."""
    place: str
    """The file and line, `README.md:12`."""


class WrittenValues:
    """The values written below `top`; those nearest to the controller `program` come first."""

    def __init__(self, top: Path, program: Program) -> None:
        self._top = top
        self._program = program

    def of(self, need: Need) -> Written | None:
        """Return the value that is written for a need, as its entry holds it; None for none.

        Of messages, requests, replies and goals that is the mapping of their fields, of a frame
        the whole entry.
        """
        if need.kind == "parameter":
            written = self._set_parameter(need) or self._configured(need)
            return None if written is None else replace(written, value=self._here(written.value))
        if need.kind in ("topic", "call", "goal"):
            return self._sent(need) or self._made(need)
        return self._published_frame(need.name) if need.kind == "frame" else None

    @cached_property
    def arguments(self) -> tuple[tuple[tuple[str, ...], str], ...]:
        """The command lines with which the controller is started, each with its place."""
        places: dict[tuple[str, ...], str] = {}
        for command in self._commands(_RUNS):
            rest = self._rest(command.words)
            if rest and not any(_PLACEHOLDER.search(name) for name in rest):
                places.setdefault(rest, command.place)
        return tuple(places.items())

    def _rest(self, words: tuple[str, ...]) -> tuple[str, ...]:
        for at, word in enumerate(words[:6]):
            name = Path(word).name
            if words[at - 1 : at] == ("-m",):
                name = name.rpartition(".")[2]
            # `./pick.py` runs it, and so does what stands before its name.
            if name in self._program.names and (at or word.startswith("./")):
                return tuple(text for text in words[at + 1 :])
        return ()

    # Commands

    def _sent(self, need: Need) -> Written | None:
        sent = list(self._sent_all(need))
        if not sent:
            return None
        file = sent[0].place.rpartition(":")[0]
        beside = [written.value for written in sent if written.place.rpartition(":")[0] == file]
        several = _in_turn(beside) if need.kind == "topic" else ()
        return replace(sent[0], in_turn=several if len(several) > 1 else ())

    def _sent_all(self, need: Need) -> Iterator[Written]:
        kinds = {"topic": ("pub",), "call": ("call",), "goal": ("send_goal",)}[need.kind]
        for command in self._commands(_PUBLISHES):
            words = positional_words(command.words)
            if len(words) < 2 or words[0] not in kinds or not is_named(words[1], need.name):
                continue
            rest = words[2:]
            if rest and "/" in rest[0] and not rest[0].startswith(("{", "'", '"')):
                if rest[0].rpartition("/")[2] != need.type_name.rpartition("/")[2]:
                    continue
                rest = rest[1:]
            value = _yaml(" ".join(rest)) if rest else None
            if isinstance(value, dict) and value and _is_message(value):
                yield Written(value, command.place)

    def _set_parameter(self, need: Need) -> Written | None:
        for command in self._commands(_PUBLISHES):
            words = positional_words(command.words)
            if words[:1] == ("set",) and len(words) > 2 and is_named(words[-2], need.name):
                value = _yaml(words[-1])
                if value is not None and _is_of_kind(value, need.type_name):
                    return Written(value, command.place)
        return None

    def _here(self, value: Any) -> Any:
        """Return a value; a path that is not there as the file of the repository that it ends in.

        Its author wrote it from the folder that holds the repository: `src/cell/config/a.yaml`.
        """
        is_path = isinstance(value, str) and _PATH.fullmatch(value)
        parts = Path(value).parts if is_path else ()
        for at in range(len(parts)):
            path = self._top.joinpath(*parts[at:])
            if path.is_file():
                return value if at == 0 else from_root(self._top, path)
        return value

    def _commands(self, pattern: re.Pattern[str]) -> Iterator[_Command]:
        for path, text in self._texts:
            if path.suffix in (".yaml", ".yml", ".xml") or not pattern.search(text):
                continue
            lines = text.splitlines()
            for number, line in enumerate(lines):
                for match in pattern.finditer(line):
                    words = command_words(lines, number, match.start())
                    if path.suffix == ".py":
                        # The text in which it stands ends on its line, but for one of many lines.
                        cut = _within_text(line, match.start())
                        words = words if cut == line else command_words([cut], 0, match.start())
                    if words:
                        yield _Command(words, self._place(path, number + 1))

    def _published_frame(self, name: str) -> Written | None:
        """Return where static publishers of the repository put a frame, seen from the frame of
        theirs that hangs on none of them."""
        static_frame = self._static_frames.get(name.strip("/"))
        if static_frame is None:
            return None
        entry, climbed = static_frame.value, {name.strip("/")}
        while (above := entry["parent"].strip("/")) not in climbed:
            climbed.add(above)
            if above in self._static_frames:
                entry = on_top(self._static_frames[above].value, entry)
        return Written(entry, static_frame.place)

    @cached_property
    def _static_frames(self) -> dict[str, Written]:
        """The frames that static publishers of the repository publish, the nearest of each name."""
        static_frames: dict[str, Written] = {}
        launched = (
            (words, self._place(path, line))
            for path, text in self._texts
            for words, line in launched_arguments(path, text)
        )
        typed = (
            (command.words[command.words.index(PROGRAM) + 1 :], command.place)
            for command in self._commands(COMMAND)
        )
        for words, place in (*launched, *typed):
            entry = static_frame(words)
            if entry is not None:
                static_frames.setdefault(entry["frame"].strip("/"), Written(entry, place))
        return static_frames

    # Configuration

    def _configured(self, need: Need) -> Written | None:
        wanted = tuple(part for part in re.split(r"[/.]", need.name.lstrip("~")) if part)
        if not wanted:
            return None
        pairs: list[tuple[int, Written]] = []
        for path, text in self._texts:
            if not re.search(rf"(?<![\w]){re.escape(wanted[-1])}(?![\w])", text):
                continue
            if path.suffix in (".yaml", ".yml"):
                pairs += self._of_yaml(path, text, wanted, need.type_name)
            elif path.suffix in (".launch", ".xml"):
                pairs += self._of_xml(path, text, wanted, need.type_name)
        # The longest common end of the name, then the file that comes first.
        best = max(pairs, key=lambda pair: pair[0], default=None)
        return None if best is None else best[1]

    def _of_yaml(
        self, path: Path, text: str, wanted: tuple[str, ...], kind: str
    ) -> Iterator[tuple[int, Written]]:
        tree = _yaml(text)
        for keys, value in _leaves(tree, ()):
            plain = tuple(
                part
                for key in keys
                if key not in ("ros__parameters", "/**")
                for part in re.split(r"[/.]", key.strip("/~"))
            )
            if plain[-1:] != wanted[-1:] or value is None or not _is_of_kind(value, kind):
                continue
            common = _common_end(plain, wanted)
            # A key below another name than the one that is asked for is another thing.
            if common == len(plain) or common == len(wanted) or common > 1:
                line = _line_of(text, keys[-1])
                yield common, Written(value, self._place(path, line))

    def _of_xml(
        self, path: Path, text: str, wanted: tuple[str, ...], kind: str
    ) -> Iterator[tuple[int, Written]]:
        try:
            tree = ET.fromstring(text)
        except (ET.ParseError, ValueError):
            return
        for node in tree.iter():
            name = node.get("name", "").strip("/~").split("/")
            given = node.get("value", node.get("default"))
            if node.tag not in ("param", "arg") or name[-1] != wanted[-1] or not given:
                continue
            value = _yaml(given) if "$(" not in given else None
            if value is not None and not isinstance(value, dict) and _is_of_kind(value, kind):
                line = _line_of(text, f'name="{node.get("name")}"')
                yield _common_end(tuple(name), wanted), Written(value, self._place(path, line))

    # Other programs

    def _made(self, need: Need) -> Written | None:
        """Return the literals with which another source of the repository fills the message."""
        kind = need.type_name.rpartition("/")[2]
        for path, text in self._texts:
            if path.suffix != ".py" or path == self._program.script or kind not in text:
                continue
            if not re.search(rf"[\"']{_NAME_START}{re.escape(need.name.strip('/'))}[\"']", text):
                continue
            fields, line = filled_fields(text, kind, need.kind)
            if fields:
                return Written(fields, self._place(path, line), is_whole=False)
        return None

    def started_with(self, topic: str, programs: Sequence[str]) -> str | None:
        """Return the launch file that names one of `programs` and the topic, None for none."""
        last = topic.strip("/")
        for path, text in self._texts:
            is_launch = path.suffix in (".launch", ".xml") or path.name.endswith("launch.py")
            result = next((program for program in programs if program in text), None)
            if is_launch and last in text and result is not None:
                return f"{result} in {self._place(path, _line_of(text, result))}"
        return None

    # Files

    @cached_property
    def _texts(self) -> tuple[tuple[Path, str], ...]:
        """The texts of the repository, those nearest to the controller first."""
        paths: list[Path] = []
        for folder, files in searched(self._top):
            paths += [
                Path(folder, name)
                for name in files
                if name.endswith(_TEXTS) and name not in (PACKAGE_FILE, "CMakeLists.txt")
            ]
            if len(paths) > _MOST_FILES:
                break
        script = self._program.script
        paths.sort(key=lambda item: (_apart(item, script), _rank(item), str(item)))
        texts = []
        for path in paths[:_MOST_FILES]:
            try:
                if path.stat().st_size <= _MOST_BYTES:
                    texts.append((path, file_text(path, errors="replace")))
            except OSError:
                continue
        return tuple(texts)

    def _place(self, path: Path, line: int) -> str:
        return f"{from_root(self._top, path)}:{line}"


_NAME_START = r"[~/]?(?:[\w/]*/)?"


def _in_turn(messages: Sequence[dict[str, Any]]) -> tuple[dict[str, Any], ...]:
    """Return written messages, each once; of words what ends the program last."""
    once = [message for at, message in enumerate(messages) if message not in messages[:at]]
    if all(fields.keys() == {"data"} and isinstance(fields["data"], str) for fields in once):
        words = without_emergency(ordered_answers(fields["data"] for fields in once))
        once = [{"data": word} for word in words]
    return tuple(once[:_MOST_IN_TURN])


def _apart(one: Path, other: Path) -> int:
    common = os.path.commonpath([one, other])
    return len(other.parts) - len(Path(common).parts)


def _rank(path: Path) -> int:
    return 0 if path.stem.lower().startswith("readme") else 1


def _within_text(line: str, start: int) -> str:
    """Return a line of Python up to the end of the text in which a command begins at `start`."""
    before, rest = line[:start], line[start:]
    for quote in ('"""', "'''"):
        before, rest = before.replace(quote, ""), rest.partition(quote)[0]
    for quote in ('"', "'"):
        if before.count(quote) % 2:
            rest = rest.partition(quote)[0]
    return line[:start] + rest.partition("\\n")[0]


def _is_message(value: dict[Any, Any]) -> bool:
    """Return whether a mapping is one of fields: `1 2 3`, or words, are read as none."""
    return all(isinstance(key, str) and re.fullmatch(r"[a-zA-Z]\w*", key) for key in value)


def _is_of_kind(value: Any, kind: str) -> bool:
    if kind.endswith("_array"):
        return isinstance(value, list)
    wanted: dict[str, type | tuple[type, ...]] = {
        "bool": bool, "integer": int, "double": (int, float), "string": str,
    }  # fmt: skip
    return kind not in wanted or isinstance(value, wanted[kind])


def _yaml(text: str) -> Any:
    # Of YAML 1.2, for the key `y` of a point is true in that of 1.1.
    try:
        return plain_value(plain_yaml(text))
    except (ValueError, RecursionError):  # keys of endless digits, endless depth
        return None


def _leaves(tree: Any, keys: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield (*keys, key), value
            yield from _leaves(value, (*keys, key))


def _common_end(one: Sequence[str], two: Sequence[str]) -> int:
    count = 0
    for a, b in zip(reversed(one), reversed(two), strict=False):
        if a != b:
            break
        count += 1
    return count


def _line_of(text: str, word: str) -> int:
    at = text.find(word)
    return text.count("\n", 0, max(at, 0)) + 1
