"""Random edits of an annotated controller: of its code by the tool, and of its blocks by hand.

The blocks that a run would write are made up, with their digests and the lock, so that an edit
takes milliseconds. Every output that compares versions is then asked for.
"""

import ast
import io
import json
import random
import re
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field, replace
from typing import Any

from tests.conftest import RepositoryExample
from tests.pipeline.review.hand_edits import Key, as_computed, edited_by_hand, new_component
from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.blocks.values import (
    DONE,
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
)
from tracerisk.adder.lock.digest import with_digest
from tracerisk.adder.lock.lock import ControllerLock, Lock, written_block
from tracerisk.adder.lock.reading import loads
from tracerisk.adder.sources.insert import insert_blocks, strip_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.cli.boundary import guarded
from tracerisk.cli.parser import parse
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.instrument.source.function_definitions import MODULE, definitions

FORMS = (
    ("--format", "text"),
    ("--format", "markdown", "--silent-below", "0.01"),
    ("--json", "--max-increase", "0.1", "--no-new-accepts"),
    ("--sarif", "risk.sarif"),
)


def outcome_of(*words: str) -> tuple[int, str, str]:
    """Return the exit code of a command in this process and folder, and what it printed."""
    out, err = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = guarded(parse(list(words)))
        out.flush()
    return code, out.buffer.getvalue().decode(), err.getvalue()  # type: ignore[attr-defined]


@dataclass
class EditedController:
    """The sources without blocks, and what the tool would write into them."""

    repository: RepositoryExample
    script: str
    chance: random.Random
    notes: list[str] = field(default_factory=list)
    """What was done, to say with a failure."""
    codes: list[int] = field(default_factory=list)
    """The exit codes of `diff`."""

    def __post_init__(self) -> None:
        lock = loads(self.repository.read("tracerisk.lock"), "tracerisk.lock")
        entry = lock.controllers[self.script]
        self.trace: dict[str, Any] = dict(entry.trace)
        self.first_outcome = self.trace.get("outcome", {})
        self.inputs: dict[str, Any] = dict(entry.inputs)
        self.sources: dict[str, bytes] = {}
        self.blocks: dict[Key, RiskBlock] = {}
        self.follows: dict[Key, dict[Key | None, int]] = {}
        for file in entry.blocks:
            text = self.repository.read(file)
            self.sources[file] = strip_blocks(text, file)
            for placed in read_blocks(text, file):
                self.blocks[file, placed.function] = placed.block
        self.order = sorted(self.blocks, key=lambda key: self.blocks[key].call_sequence.value)
        for key, after in zip(self.order, [*self.order[1:], None], strict=True):
            self.follows[key] = {after: 1}
        self.number = 0

    # What one step does.

    def step(self) -> None:
        """Make one commit: by the tool, by hand or both."""
        number = self.chance.choice((0, 1, 1, 2))
        done = [self._changed_code() for _ in range(number)]
        written = {key: with_digest(block) for key, block in self._numbered().items()}
        by_hand = dict(written)
        number = self.chance.choice((0, 1, 2)) or (not done)
        done += [edited_by_hand(by_hand, self.chance) for _ in range(number)]
        entry = self._entry(written)
        if self.chance.random() < 0.2:
            entry = self._upset(entry, done)
        self.notes.append(", ".join(done))
        self._write(by_hand, entry)
        # What a user typed stays, until the tool writes the value anew.
        self.blocks = {key: by_hand.get(key, block) for key, block in written.items()}
        self.repository.git("add", "--all")
        self.repository.git("commit", "--quiet", "--allow-empty", "--message", "change")

    def _changed_code(self) -> str:
        changes: tuple[Callable[[], None], ...] = (
            *(self._add, self._remove, self._reorder, self._rename, self._split, self._move),
            *(self._flow, self._figures, self._components, self._inputs, self._trace),
            *(self._outcome, self._outcome),
        )
        change = self.chance.choice(changes)
        change()
        return change.__name__.lstrip("_")

    # Changes of the code, with what the tool then computes.

    def _new_function(self, components: tuple[ComponentEntry, ...], file: str) -> Key:
        self.number += 1
        name = self.chance.choice(
            (f"step{self.number}", f"entry{self.number}", f"next_{self.number}")
        )
        self.sources[file] += f"\n\ndef {name}(arm):\n    arm.wait({self.number})\n".encode()
        key = (file, name)
        self.blocks[key] = RiskBlock(name, computed_count(1), None, components)
        return key

    def _place(self, key: Key, rank: int) -> None:
        """Have a function run at a rank, between what ran there."""
        self.order.insert(rank, key)
        after = self.order[rank + 1] if rank + 1 < len(self.order) else None
        self.follows[key] = {after: 1}
        if rank:
            self.follows[self.order[rank - 1]] = {key: 1}

    def _any(self) -> Key:
        return self.chance.choice(self.order)

    def _add(self) -> None:
        entries = self.blocks[self._any()].components
        key = self._new_function(as_computed(entries[: self.chance.randint(0, 3)]), self._any()[0])
        self._place(key, self.chance.randint(0, len(self.order)))

    def _remove(self) -> None:
        if len(self.order) > 1:
            key = self._any()
            self._take_out(key)
            self._forget(key)

    def _forget(self, key: Key) -> None:
        self.order.remove(key)
        del self.blocks[key], self.follows[key]

    def _take_out(self, key: Key) -> None:
        """Remove a function from its source, which stays a program."""
        file, name = key
        source = self.sources[file]
        tree = ast.parse(source)
        lines = {str(each.name): each.line for each in definitions(tree)}
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef) and lines.get(name) == node.lineno:
                first = min([node.lineno, *(each.lineno for each in node.decorator_list)])
                kept = source.splitlines(keepends=True)
                kept[first - 1 : node.end_lineno] = [b" " * node.col_offset + b"pass\n"]
                self.sources[file] = b"".join(kept)
                return

    def _reorder(self) -> None:
        self.chance.shuffle(self.order)
        for key, after in zip(self.order, [*self.order[1:], None], strict=True):
            self.follows[key] = {after: 1}

    def _rename(self) -> None:
        key = self._any()
        name = key[1]
        if name == MODULE:
            return
        self.number += 1
        old = name.rpartition(".")[2]
        new = f"named{self.number}"
        for each in self.sources:
            self.sources[each] = re.sub(rf"\b{old}\b".encode(), new.encode(), self.sources[each])
        names = {other: (other[0], re.sub(rf"\b{old}\b", new, other[1])) for other in self.order}
        assert names[key] != key
        self.order = [names[other] for other in self.order]
        self.blocks = {
            names[other]: replace(block, name=names[other][1])
            for other, block in self.blocks.items()
        }
        self.follows = {
            names[other]: {None if to is None else names.get(to, to): n for to, n in after.items()}
            for other, after in self.follows.items()
        }

    def _split(self) -> None:
        key = self._any()
        entries = self.blocks[key].components
        half = len(entries) // 2
        rest = self._new_function(as_computed(entries[half:]), key[0])
        self.blocks[key] = replace(self.blocks[key], components=entries[: half or 1])
        self._place(rest, self.order.index(key) + 1)

    def _move(self) -> None:
        """Move a function to another file of the controller, which may be a new one."""
        key = self._any()
        file = f"module{self.chance.randint(1, 2)}.py"
        if key[1] == MODULE or "." in key[1] or file == key[0] or (file, key[1]) in self.blocks:
            return
        self.sources.setdefault(file, b'"""Steps."""\n')
        if self.chance.random() < 0.7:
            self._take_out(key)
        moved = (file, key[1])
        self.sources[file] += f"\n\ndef {key[1]}(arm):\n    arm.wait(1)\n".encode()
        self.blocks[moved] = self.blocks[key]
        self._place(moved, self.order.index(key))
        if self.chance.random() < 0.7:
            self._forget(key)

    def _flow(self) -> None:
        key = self._any()
        targets = [*self.chance.sample(self.order, min(2, len(self.order))), None]
        self.follows[key] = {to: self.chance.randint(1, 9) for to in targets}

    def _figures(self) -> None:
        factor = self.chance.choice((0.0, 0.999, 1.5, 3.0))
        for key in self.chance.sample(self.order, self.chance.randint(1, len(self.order))):
            entries = tuple(
                entry
                if entry.omitted or entry.probability.pinned
                else replace(
                    entry,
                    probability=computed_probability(min(1.0, entry.probability.value * factor)),
                )
                for entry in self.blocks[key].components
            )
            self.blocks[key] = replace(self.blocks[key], components=entries)

    def _components(self) -> None:
        key = self._any()
        entries = list(self.blocks[key].components)
        kind = self.chance.choice(("new", "gone", "units"))
        if kind == "new":
            self.number += 1
            entries.append(new_component(f"next {self.number}", 2e-7))
        elif entries and kind == "gone":
            entries.remove(self.chance.choice(entries))
        elif entries:
            number = self.chance.randrange(len(entries))
            entries[number] = replace(
                as_computed((entries[number],))[0],
                quantity=computed_count(self.chance.randint(1, 4)),
                redundancy=computed_redundancy(
                    self.chance.choice((Redundancy(False), Redundancy(True), Redundancy(True, 2)))
                ),
            )
        self.blocks[key] = replace(self.blocks[key], components=tuple(entries))

    def _inputs(self) -> None:
        self.number += 1
        what = self.chance.choice(("hardware", "files", "settings"))
        changed = {
            "hardware": f"{self.number}",
            "files": {"arm.yaml": f"{self.number}"},
            "settings": {"seed": self.number, "hardware": "arm.yaml"},
        }
        self.inputs[what] = changed[what]

    def _trace(self) -> None:
        file, name = self._any()
        self.trace["uncovered"] = self.chance.choice(({}, {file: [name, "later"]}))
        pairs = self.chance.choice(({}, {file: {name: [["finger", "table"]]}}))
        self.trace["unexpected_contacts"] = pairs
        kind = self.chance.choice(("complete", "partial", "faulted", None))
        if kind is None:
            self.trace.pop("verdict", None)
        elif isinstance(self.trace.get("verdict"), dict):
            self.trace["verdict"] = {**self.trace["verdict"], "kind": kind}

    def _outcome(self) -> None:
        """Have the run bring about something else, or the lock keep what is no outcome."""
        data = self.trace.get("outcome")
        kind = self.chance.choice(("back", "number", "number", "step", "form", "gone"))
        if kind == "back" or not isinstance(data, dict):
            self.trace["outcome"] = self.first_outcome
        elif kind == "number":
            text = json.dumps(data)
            found = self.chance.choice(list(re.finditer(r"(?<![\d.])[1-9]\d*", text)))
            number = str(self.chance.randint(1, 9999))
            text = text[: found.start()] + number + text[found.end() :]
            self.trace["outcome"] = json.loads(text)
        elif kind == "step":
            lists = [name for name, value in data.items() if isinstance(value, list) and value]
            name = self.chance.choice(lists)
            kept = list(data[name])
            kept.pop(self.chance.randrange(len(kept)))
            self.trace["outcome"] = {**data, name: kept}
        elif kind == "form":
            forms: tuple[Any, ...] = ([], {"way": 3}, {**data, "arms": None})
            self.trace["outcome"] = self.chance.choice(forms)
        else:
            del self.trace["outcome"]

    # What the tool writes.

    def _numbered(self) -> dict[Key, RiskBlock]:
        """Return the blocks with their ranks and what follows; what a user pinned stays."""
        self._settle()
        refs = {key: FunctionRef(key[0], QualifiedName(key[1])) for key in self.order}
        named = model_names(list(refs.values()))
        names: dict[Key | None, str] = {key: named[ref] for key, ref in refs.items()}
        names[None] = DONE
        found = {}
        for rank, key in enumerate(self.order, start=1):
            block = self.blocks[key]
            after = {names[to]: count for to, count in self.follows[key].items()}
            steps, sequence = computed_next(after), computed_count(rank)
            is_kept = block.next is not None and block.next.pinned and self.chance.random() < 0.5
            has_rank = block.call_sequence.pinned and self.chance.random() < 0.5
            found[key] = replace(
                block,
                call_sequence=block.call_sequence if has_rank else sequence,
                next=block.next if is_kept else steps,
            )
        return found

    def _settle(self) -> None:
        """Forget functions that are gone; have the others lead to such as are there, and on."""
        for key in list(self.order):
            lines = definitions(ast.parse(self.sources[key[0]]))
            if key[1] not in (MODULE, *(str(each.name) for each in lines)):
                self._forget(key)
        for key, after in zip(self.order, [*self.order[1:], None], strict=True):
            kept = {to: n for to, n in self.follows[key].items() if to is None or to in self.blocks}
            self.follows[key] = kept if {after, None} & kept.keys() else {**kept, after: 1}

    def _entry(self, blocks: dict[Key, RiskBlock]) -> ControllerLock:
        written: dict[str, dict[str, Any]] = {file: {} for file in self.sources}
        for (file, name), block in blocks.items():
            if (of_tool := written_block(block)) is not None:
                written[file][name] = of_tool
        sources = {file: code_digest(text, file) for file, text in self.sources.items()}
        return ControllerLock("f", written, self.trace, inputs={**self.inputs, "sources": sources})

    def _upset(self, entry: ControllerLock, done: list[str]) -> ControllerLock | None:
        """Return the entry as a merge, a kill or a person may leave it; `None` for no lock."""
        kind = self.chance.choice(("gone", "pending", "merged", "mixed", "stale", "bare"))
        done.append(f"lock {kind}")
        changed: dict[str, dict[str, Any]] = {
            "pending": {"previous": {}},
            "merged": {"others": (entry.blocks,)},
            "mixed": {"is_mixed": True},
            "stale": {"inputs": {**entry.inputs, "sources": {self.script: "old"}}},
            "bare": {"trace": {}, "inputs": {}},
        }
        return None if kind == "gone" else replace(entry, **changed[kind])

    def _write(self, blocks: dict[Key, RiskBlock], entry: ControllerLock | None) -> None:
        for file, text in self.sources.items():
            own = {QualifiedName(name): each for (of, name), each in blocks.items() if of == file}
            self.repository.write(file, insert_blocks(text, own, file))
        lock = self.repository.folder / "tracerisk.lock"
        lock.unlink(missing_ok=True)
        if entry is not None:
            lock.write_bytes(Lock().with_controller(self.script, entry).dumps())

    # What every output says of it.

    def compare(self) -> None:
        """Ask for every output of `diff` on the last commit; none may end in an internal error."""
        for form in FORMS:
            self._asked("diff", "HEAD~1..HEAD", *form)

    def look_back(self) -> None:
        """Ask for the outputs that go over many versions."""
        self._asked("history", self.script)
        self._asked("history", self.script, "--json")
        self._asked("history", "--svg", "history.svg")
        count = int(self.repository.git("rev-list", "--count", "HEAD"))
        for back in {1, self.chance.randint(1, count - 1)}:
            page = ("--output", "page.html")
            self._asked("report", self.script, "--against", f"HEAD~{back}", *page)

    def _asked(self, *words: str) -> None:
        code, out, err = outcome_of(*words)
        said = f"{' '.join(words)} after {self.notes}:\n{err}"
        assert code in (0, 1, 2), said
        assert "Traceback" not in err, said
        assert code != 2 or "tracerisk: " in err or '"error"' in out, said
        if words[0] == "diff":
            self.codes.append(code)
