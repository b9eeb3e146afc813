"""Random histories in which functions, classes and files are renamed, moved and reformatted.

As those of `merge_histories`, of controllers in several files of Python or of C++: functions are
renamed in code alone or by search and replace, move to other files and change their order;
formatters of one's own choice go over the sources.
"""

import ast
import re
import subprocess
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from tests.pipeline.history.merge_histories import (
    CALLS,
    COMPONENTS,
    History,
    calls_of,
    live,
    with_calls,
)
from tracerisk.adder.sources.c_source import parse_c
from tracerisk.adder.sources.renames import follow_renames
from tracerisk.common.trace_log import read_log
from tracerisk.errors import TraceRiskError
from tracerisk.trace import Trace

PYTHON = """\
CALLS = "home Cell.place home leave"


def home(arm):
    motor(arm)
    camera(arm)


class Cell:
    def place(self, arm):
        motor(arm)

        gripper(arm)

    def turn(self, arm): return motor(arm)


def leave(arm):
    camera(arm)
"""
CPP = """\
const char* CALLS = "home Cell::place home leave";

void home(Arm& arm) {
  motor(arm);
  camera(arm);
}

void Cell::place(Arm& arm)
{
  motor(arm);

  gripper(arm);
}

void Cell::turn(Arm& arm) { motor(arm); }

void leave(Arm& arm) {
  camera(arm);
}
"""


class Part(NamedTuple):
    """A function in one of the sources; lines are those of its definition, from 0."""

    file: str
    name: str
    first: int
    after: int


class RenamingHistory(History):
    """A person who renames and moves; `formatters` are the commands that take a file's name."""

    first_file = "c.py"
    scope = "."
    code = PYTHON

    def __init__(self, folder: Path, seed: int, formatters: Sequence[Sequence[str]] = ()) -> None:
        self.formatters = formatters
        self.at = ""
        super().__init__(folder, seed)

    def start(self) -> None:
        (self.folder / self.first_file).write_text(self.code)

    @property
    def main(self) -> str:
        """The source that is looked at: where a change is made, else the script."""
        return self.at or self.script

    @property
    def script(self) -> str:
        return next(file for file in self.files() if CALLS.search(self.read(file)))

    def files(self) -> list[str]:
        suffix = Path(self.first_file).suffix
        return sorted(path.name for path in self.folder.iterdir() if path.suffix == suffix)

    def text(self) -> str:
        return "".join(map(self.read, self.files()))

    def parts(self) -> list[Part]:
        return [part for file in self.files() for part in parts_of(self.read(file), file)]

    def names(self) -> list[str]:
        return [part.name for part in self.parts()]

    def lines_of(self, part: Part) -> list[str]:
        return self.read(part.file).splitlines(keepends=True)[part.first : part.after]

    # What the person does on a branch.

    def changes(self) -> Sequence[Callable[[], None]]:
        in_a_file = (*(self.pin,) * 3, self.edit, self.omit, self.add_by_hand, self.take_out)
        return (
            *(self.change_code,) * 3,
            *(self.hardware,) * 2,
            *(self.within(change) for change in in_a_file),
            *(self.rename,) * 4,
            *(self.rename_class, self.rename_file, self.move, self.move),
            *(self.reorder, self.format, self.format),
        )

    def within(self, change: Callable[[], None]) -> Callable[[], None]:
        def in_one_file() -> None:
            self.at = self.chance.choice(self.files())
            try:
                change()
            finally:
                self.at = ""

        return in_one_file

    def change_code(self) -> None:
        parts = self.parts()
        kind = self.chance.choice(("calls", "calls", "component", "delete"))
        part = self.chance.choice(parts)
        if kind == "calls":
            names = [one.name for one in parts]
            self.call([self.chance.choice(names) for _ in range(self.chance.randint(2, 6))])
        elif kind == "component":
            lines = self.lines_of(part)
            own = [n for n, line in enumerate(lines) if re.match(r" *\w+ ?\(arm\);?$", line)]
            if own:
                line = lines[own[-1]]
                new = re.sub(r"\w+(?= ?\(arm\))", self.chance.choice(COMPONENTS), line)
                lines.insert(own[-1] + 1, new)
                self.put(part, lines)
        elif kind == "delete" and len(parts) > 3:
            self.put(part, [])
            self.call([name for name in self.calls() if name != part.name])

    def calls(self) -> list[str]:
        return calls_of(self.read(self.script))

    def call(self, names: Sequence[str]) -> None:
        script = self.script
        self.write(script, with_calls(self.read(script), names or [self.parts()[0].name]))

    def put(self, part: Part, lines: Sequence[str]) -> None:
        whole = self.read(part.file).splitlines(keepends=True)
        whole[part.first : part.after] = lines
        self.write(part.file, "".join(whole))

    def rename(self) -> None:
        part = self.chance.choice(self.parts())
        scope, mark, old = part.name.rpartition(self.scope)
        self.typed.number += 1
        new = f"named{self.typed.number}"
        self.typed.first_names[new] = self.typed.first_name(old)
        self.replaced(old, new, part.name, f"{scope}{mark}{new}")

    def rename_class(self) -> None:
        scopes = {part.name.rpartition(self.scope)[0] for part in self.parts()} - {""}
        if scopes:
            old = self.chance.choice(sorted(scopes))
            self.typed.number += 1
            new = f"Kind{self.typed.number}"
            methods = [one.name for one in self.parts() if one.name.startswith(old + self.scope)]
            self.replaced(old, new, methods[0], new + methods[0].removeprefix(old))

    def replaced(self, old: str, new: str, name: str, new_name: str) -> None:
        """Replace a word: everywhere, in the code alone, or in code and in what follows."""
        how = self.chance.choice(("everywhere", "everywhere", "code", "following"))
        self.notes.append(f"rename {name} to {new_name}: {how}")
        for file in self.files():
            lines = self.read(file).splitlines(keepends=True)
            for number, line in enumerate(lines):
                is_block = re.match(r" *(?:# \| | \* )", line) is not None
                follows = re.match(r" *(?:# \| | \* ) *next ", line) is not None
                if how == "everywhere" or not is_block or (how == "following" and follows):
                    lines[number] = re.sub(rf"\b{old}\b", new, line)
                    if lines[number] != line and follows:
                        self.typed.targets.add(new_name)
            self.write(file, "".join(lines))

    def rename_file(self) -> None:
        old = self.chance.choice([self.script, *self.files()])
        self.typed.number += 1
        new = f"f{self.typed.number}{Path(old).suffix}"
        self.notes.append(f"rename {old} to {new}")
        (self.folder / old).rename(self.folder / new)

    def move(self) -> None:
        """Move a function, with its block, to another file, which may be new."""
        part = self.chance.choice(self.parts())
        lines = self.lines_of(part)
        if lines[0].startswith(" "):
            return
        others = [file for file in self.files() if file != part.file]
        self.typed.number += 1
        new = f"m{self.typed.number}{Path(part.file).suffix}"
        target = self.chance.choice([new, *others])
        self.notes.append(f"move {part.name} from {part.file} to {target}")
        self.put(part, [])
        path = self.folder / target
        before = path.read_text().rstrip("\n") + "\n\n\n" if path.exists() else ""
        path.write_text(before + "".join(lines))

    def reorder(self) -> None:
        file = self.chance.choice(self.files())
        tops = [one for one in parts_of(self.read(file), file) if not self._is_inner(one)]
        if len(tops) < 2:
            return
        texts = [self.lines_of(one) for one in tops]
        self.chance.shuffle(texts)
        for part, lines in reversed(list(zip(tops, texts, strict=True))):
            self.put(part, lines)

    def _is_inner(self, part: Part) -> bool:
        return self.lines_of(part)[0].startswith(" ")

    def format(self) -> None:
        if not self.formatters:
            super().format()
            return
        command = self.chance.choice(list(self.formatters))
        self.notes.append(f"format by {Path(command[0]).name}")
        for file in self.files():
            path = self.folder / file
            subprocess.run([*command, str(path)], check=False, capture_output=True)

    # What brings branches together.

    def settle_code(self) -> None:
        """Take a side whole where the mixture is no program, or its blocks are none."""
        for name in ("arm.yaml", "pyproject.toml"):
            if not (self.folder / name).exists():
                self.git("checkout", self.chance.choice(self.branches), "--", name)
        sides = self.chance.sample(self.branches, len(self.branches))
        assert self._is_sound() or any(self._takes_sound(side) for side in sides)
        known = {part.name for part in self.parts()}
        self.call([name for name in self.calls() if name in known])

    def _takes_sound(self, branch: str) -> bool:
        for file in self.files():
            (self.folder / file).unlink()
        pattern = f"*{Path(self.first_file).suffix}"
        self.git("checkout", branch, "--", pattern, fails=True)
        return self._is_sound()

    def _is_sound(self) -> bool:
        texts = {file: self.read(file) for file in self.files()}
        try:
            names = [part.name for part in self.parts()]
            for file, text in texts.items():
                follow_renames(text.encode(), file, ())
        except (SyntaxError, TraceRiskError):
            return False
        is_one = sum(len(CALLS.findall(text)) for text in texts.values()) == 1
        return is_one and len(set(names)) == len(names) > 0

    # What the tool does, and what it must not.

    def computed_log(self) -> str:
        parts = {part.name: part for part in self.parts()}
        calls = [name for name in self.calls() if name in parts] or [next(iter(parts))]
        rows = []
        for name in dict.fromkeys(calls):
            body = "".join(self.lines_of(parts[name]))
            active = [one for one in COMPONENTS if re.search(rf"\b{one} ?\(", body)]
            rows.append(f"Function:{name}()\nActiveComponents:{','.join(active)}")
        return "\n".join([*rows, "", "CallSequence:" + ",".join(f"{one}()" for one in calls)])

    def trace(self) -> Trace:
        parts = {part.name: part for part in self.parts()}
        trace = read_log(self.computed_log(), "run.log", controller=self.script)
        return replace(
            trace,
            functions=tuple(
                replace(one, ref=replace(one.ref, file=parts[one.ref.name].file))
                for one in trace.functions
            ),
            visits=tuple(
                replace(one, function=replace(one.function, file=parts[one.function.name].file))
                for one in trace.visits
            ),
            files=tuple(file for file in self.files() if file != self.script),
        )

    def is_in_live_block(self, text: str, figure: str) -> bool:
        live_names = self.calls()
        return any(
            figure in "".join(self.lines_of(part))
            for part in self.parts()
            if part.name in live_names
        )

    def invents_nothing(self) -> None:
        typed = self.typed.pins | self.typed.edits
        for file in self.files():
            for placed in follow_renames(self.read(file).encode(), file, ()).placed:
                block = placed.block
                assert not block.added, self.notes
                assert not block.call_sequence.pinned, self.notes
                assert block.next is None or not block.next.pinned, self.notes
                for entry in block.components:
                    pair = self.typed.first_name(block.name), entry.name
                    is_out = pair in self.typed.removed
                    is_typed = any(figure in (entry.reason or "") for figure in typed)
                    assert not entry.omitted or is_out or is_typed, self.notes
                    assert not entry.added or entry.probability.text in typed, self.notes
                    pinned = entry.probability.pinned
                    assert not pinned or entry.probability.text in typed, self.notes
                    assert not entry.quantity.pinned, self.notes
                    assert not entry.redundancy.pinned, self.notes


class CppHistory(RenamingHistory):
    """The same in C++."""

    first_file = "c.cpp"
    scope = "::"
    code = CPP


def parts_of(text: str, file: str) -> list[Part]:
    """Return the functions of a source."""
    return list(_python_parts(text, file) if file.endswith(".py") else _c_parts(text, file))


def _python_parts(text: str, file: str) -> Iterator[Part]:
    for node in ast.parse(text).body:
        inner = node.body if isinstance(node, ast.ClassDef) else [node]
        scope = f"{node.name}." if isinstance(node, ast.ClassDef) else ""
        for one in inner:
            if isinstance(one, ast.FunctionDef):
                assert one.end_lineno is not None
                yield _with_block(
                    Part(file, scope + one.name, one.lineno - 1, one.end_lineno), text
                )


def _c_parts(text: str, file: str) -> Iterator[Part]:
    source = text.encode()
    for function in parse_c(source, file).functions:
        first = source.count(b"\n", 0, function.begins)
        after = source.count(b"\n", 0, function.end) + 1
        yield _with_block(Part(file, str(function.name), first, after), text)


def _with_block(part: Part, text: str) -> Part:
    """Return the part with the block above it, as a function on one line has one."""
    lines, first = text.splitlines(), part.first
    while first and re.match(r" *(?:# \||/\*\*\*$| \*)", lines[first - 1]):
        first -= 1
    return part._replace(first=first)


def run_renaming_history(
    folder: Path, seed: int, language: str, formatters: Sequence[Sequence[str]] = ()
) -> int:
    """Make one history of a controller in a language; return how often the tool stopped."""
    kind = RenamingHistory if language == "python" else CppHistory
    return live(kind(folder, seed, formatters))
