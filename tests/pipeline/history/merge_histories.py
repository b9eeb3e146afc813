"""Random histories of branches on which code, blocks and the lock change, and are brought together.

What each branch typed is written down as it is typed: the model to which every answer of the
tool is compared. Values are computed from a log that is made of the code, without a simulation.
"""

import ast
import os
import random
import re
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tracerisk import api
from tracerisk.adder.lock.lock import LockError
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.sources.read import read_blocks
from tracerisk.adder.sources.renames import follow_renames
from tracerisk.common.trace_log import read_log
from tracerisk.errors import EditInTheWayError, TraceRiskError
from tracerisk.pipeline.annotate import Annotated
from tracerisk.pipeline.check.check import check_controller
from tracerisk.pipeline.workspace.project import Projects
from tracerisk.trace import Trace

COMPONENTS = ("camera", "gripper", "motor")
START = """\
CALLS = "home place home leave"


def home(arm):
    motor(arm)
    camera(arm)


def place(arm):
    motor(arm)

    gripper(arm)


def leave(arm):
    camera(arm)
"""
HARDWARE = (
    "  {0}: {{probability: {{value: {1}, per: visit}}, quantity: {2}, twin: {{joints: '*'}}}}\n"
)
# A formatter breaks a line that is too long, and the text in it.
CALLS = re.compile(r'(CALLS =\s*\(?\s*)("[^"]*"(?:\s*"[^"]*")*)')
_GUTTER = r" *(?:# \|| \*)"
_VALUE = re.compile(rf"^({_GUTTER}   (?:probability|quantity|redundancy) )(= )(.*)$", re.MULTILINE)
_SECTION = re.compile(
    rf"^{_GUTTER} @Component \{{\n(?:{_GUTTER}   .*\n)*{_GUTTER} \}}\n", re.MULTILINE
)


@dataclass
class Typed:
    """What persons typed, on any branch: each thing is told from all others by its text."""

    edits: set[str] = field(default_factory=set)
    pins: set[str] = field(default_factory=set)
    removed: set[tuple[str, str]] = field(default_factory=set)
    targets: set[str] = field(default_factory=set)
    first_names: dict[str, str] = field(default_factory=dict)
    number: int = 0

    def first_name(self, function: str) -> str:
        """Return the name that a function had before all renamings, without that of its class."""
        name = re.split(r"[.:]+", function)[-1]
        return self.first_names.get(name, name)

    def figure(self) -> str:
        """Return a probability that the tool never computes: it has six digits."""
        self.number += 1
        return f"{1 + self.number / 100_000:.5f}e-05"


class History:
    """A repository with a controller, and a person who works on its branches."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder = folder
        self.chance = random.Random(seed)
        self.typed = Typed()
        self.notes: list[str] = []
        self.stops = 0
        folder.mkdir(exist_ok=True)
        self.git("init", "--quiet", "--initial-branch=b0")
        self.start()
        self.write("pyproject.toml", "")
        self.write(".gitignore", ".tracerisk_cache\n")
        self.hardware()
        self.refresh()
        self.commit()
        self.branches = ["b0"]

    @property
    def main(self) -> str:
        """The source that is looked at."""
        return "c.py"

    def start(self) -> None:
        self.write(self.main, START)

    # What git does.

    def git(self, *arguments: str, fails: bool = False) -> str:
        settings = {
            "GIT_CONFIG_GLOBAL": os.devnull,
            "GIT_CONFIG_NOSYSTEM": "1",
            "GIT_EDITOR": "true",
            **{
                f"GIT_{role}_{what}": "a@example.org"
                for role in ("AUTHOR", "COMMITTER")
                for what in ("NAME", "EMAIL")
            },
        }
        done = subprocess.run(
            ["git", *arguments],
            cwd=self.folder,
            env={**os.environ, **settings},
            capture_output=True,
            text=True,
            check=False,
        )
        assert fails or done.returncode == 0, f"{arguments}: {done.stderr}{done.stdout}"
        return done.stdout

    def commit(self) -> None:
        self.git("add", "--all")
        self.git("commit", "--quiet", "--allow-empty", "-m", "change")

    def read(self, name: str | None = None) -> str:
        return (self.folder / (name or self.main)).read_text()

    def write(self, name: str, text: str) -> None:
        (self.folder / name).write_text(text)

    def has_conflicts(self) -> list[str]:
        return sorted(set(self.git("diff", "--name-only", "--diff-filter=U").split()))

    # What the person does on a branch.

    def hardware(self) -> None:
        rows = [
            HARDWARE.format(name, f"{self.chance.randint(100, 999)}e-10", self.chance.randint(1, 3))
            for name in COMPONENTS
        ]
        self.write("arm.yaml", "components:\n" + "".join(rows))

    def work(self) -> None:
        """Make one to three changes, refresh or not, and commit."""
        for _ in range(self.chance.randint(1, 3)):
            self.chance.choice(self.changes())()
            if self.chance.random() < 0.7:
                self.refresh()
        if self.chance.random() < 0.8:
            self.refresh()
        self.commit()

    def changes(self) -> Sequence[Callable[[], None]]:
        """Return what a person may do, as often as it is done."""
        return (
            *(self.change_code,) * 4,
            *(self.hardware,) * 2,
            *(self.pin,) * 2,
            self.edit,
            self.omit,
            self.add_by_hand,
            self.take_out,
            self.rename,
            self.delete_block,
            self.format,
        )

    def change_code(self) -> None:
        source = self.read()
        names = functions(source)
        kind = self.chance.choice(("calls", "component", "component", "new", "delete"))
        if kind == "calls":
            calls = [self.chance.choice(names) for _ in range(self.chance.randint(2, 5))]
            source = with_calls(source, calls)
        elif kind == "component":
            line = f"    {self.chance.choice(COMPONENTS)}(arm)\n"
            source = source.rstrip("\n") + f"\n{line}"
        elif kind == "new" and len(names) < 6:
            self.typed.number += 1
            source += f"\n\ndef step{self.typed.number}(arm):\n    motor(arm)\n"
            source = re.sub(r'CALLS = "', f'CALLS = "step{self.typed.number} ', source)
        elif kind == "delete" and len(names) > 2:
            gone = self.chance.choice(names)
            source = re.sub(rf"def {gone}\(arm\):\n(?:(?:    .*)?\n)+?(?=def |\Z)", "", source)
            left = functions(source)
            source = re.sub(rf"\b{gone}\b(?=.*\")", left[0], source)
        self.write(self.main, source)

    def rename(self) -> None:
        source = self.read()
        old = self.chance.choice(functions(source))
        self.typed.number += 1
        new = f"named{self.typed.number}"
        self.typed.first_names[new] = self.typed.first_name(old)
        source = source.replace(f"def {old}(", f"def {new}(")
        source = re.sub(rf"(?<=[\" ]){old}(?=[\" ].*|\")", new, source, count=0)
        # By search and replace, in the `next` lines of other blocks too.
        if f"next = {new} " in source:
            self.typed.targets.add(new)
        self.write(self.main, source)

    def format(self) -> None:
        source = self.read().replace("\n\n\n\n", "\n\n\n")
        self.write(self.main, source.replace("    motor(arm)", "    motor(arm)  # turn", 1))

    def _value(self) -> re.Match[str] | None:
        found = [each for each in _VALUE.finditer(self.read()) if "probability" in each[1]]
        return self.chance.choice(found) if found else None

    def pin(self) -> None:
        self._type(self.typed.pins, ":= {}  ! why")

    def edit(self) -> None:
        self._type(self.typed.edits, "= {}")

    def _type(self, figures: set[str], text: str) -> None:
        found = self._value()
        if found is None:
            return
        figure = self.typed.figure()
        figures.add(figure)
        source = self.read()
        text = found[1] + text.format(figure)
        self.write(self.main, source[: found.start()] + text + source[found.end() :])

    def _section(self) -> re.Match[str] | None:
        found = list(_SECTION.finditer(self.read()))
        return self.chance.choice(found) if found else None

    def omit(self) -> None:
        found = self._section()
        if found is None:
            return
        source = self.read()
        figure = self.typed.figure()
        self.typed.pins.add(figure)
        text = found[0].replace("@Component {", f"@Component := omit {{  ! {figure}")
        self.write(self.main, source[: found.start()] + text + source[found.end() :])

    def add_by_hand(self) -> None:
        found = self._section()
        if found is None:
            return
        source = self.read()
        figure = self.typed.figure()
        self.typed.pins.add(figure)
        self.typed.number += 1
        text = found[0].replace("@Component {", "@Component := {")
        text = re.sub(r"name = .*", f"name = hose{self.typed.number}", text)
        text = re.sub(r"probability :?= .*", f"probability = {figure}", text)
        text = re.sub(r"(quantity|redundancy) :?= (\S+).*", r"\1 = \2", text)
        self.write(self.main, source[: found.end()] + text + source[found.end() :])

    def take_out(self) -> None:
        """Take out a component, which is a change of what the tool writes, or an omission."""
        found = self._section()
        if found is None:
            return
        source = self.read()
        if ":=" in found[0]:
            return
        name = re.search(r"name = (\S+)", found[0])
        assert name is not None
        function = re.findall(r"@Function.*\n.*name = (\S+)", source[: found.start()])[-1]
        self.typed.removed.add((self.typed.first_name(function), name[1]))
        self.write(self.main, source[: found.start()] + source[found.end() :])

    def delete_block(self) -> None:
        source = self.read()
        if ":=" not in source:
            self.write(
                self.main, re.sub(r"(?:^ *# \|.*\n)+", "", source, count=1, flags=re.MULTILINE)
            )

    # What brings branches together.

    def branch(self) -> None:
        name = f"b{len(self.branches)}"
        self.git("checkout", "--quiet", "-b", name, self.chance.choice(self.branches))
        self.branches.append(name)

    def bring_together(self) -> None:
        one, other = self.chance.sample(self.branches, 2)
        self.git("checkout", "--quiet", one)
        kind = self.chance.choice(
            ("merge", "merge", "rebase", "cherry-pick", "revert", "stash", "one side", "squash")
            + ("figures",) * 3
        )
        if kind == "figures":
            other = self._figures_and_calls(one)
        self.notes.append(f"{kind} {other} into {one}")
        style = ("-c", f"merge.conflictStyle={self.chance.choice(('merge', 'diff3'))}")
        if kind in ("merge", "figures"):
            self.git(*style, "merge", "--no-edit", other, fails=True)
        elif kind == "squash":
            self.git(*style, "merge", "--squash", other, fails=True)
        elif kind == "rebase":
            self.git(*style, "rebase", other, fails=True)
        elif kind == "cherry-pick":
            self.git(*style, "cherry-pick", "--no-commit", other, fails=True)
        elif kind == "revert":
            self.git(*style, "revert", "--no-edit", "--no-commit", "HEAD", fails=True)
        elif kind == "stash":
            self.change_code()
            self.refresh()
            self.git("stash", "--quiet", fails=True)
            self.git("checkout", "--quiet", other)
            self.git(*style, "stash", "pop", fails=True)
        else:
            names = self.chance.choice(((self.main,), ("tracerisk.lock",), ("arm.yaml",)))
            self.git("checkout", other, "--", *names, fails=True)
        for _ in range(20):
            self.resolve()
            if not self._is_rebasing():
                break
            self.git("add", "--all")
            self.git("-c", "core.editor=true", "rebase", "--continue", fails=True)
        if self._is_rebasing():
            self.git("rebase", "--abort", fails=True)
            self.git("checkout", "--quiet", "--force", one)
        if kind == "stash" and self.chance.random() < 0.5:
            self.git("stash", "drop", "--quiet", fails=True)
        self.upset_lock()
        # The code is one that runs, whoever resolved the conflicts.
        self.settle_code()
        self.refresh(self.chance.choice(("as it is", "as it is", "without git", "shallow")))
        self.commit()

    def _figures_and_calls(self, one: str) -> str:
        """Change figures on a new branch and the order of calls on this one.

        Git then puts figures of the one into blocks whose first line is of the other.
        """
        self.typed.number += 1
        other = f"figures{self.typed.number}"
        self.git("checkout", "--quiet", "-b", other)
        self.hardware()
        self.refresh()
        self.commit()
        self.git("checkout", "--quiet", one)
        names = self.names()
        self.chance.shuffle(names)
        self.write(self.main, with_calls(self.read(), [*names, names[0]]))
        self.refresh()
        self.commit()
        return other

    def _is_rebasing(self) -> bool:
        return any(
            (self.folder / ".git" / name).exists() for name in ("rebase-merge", "rebase-apply")
        )

    def resolve(self) -> None:
        for name in self.has_conflicts():
            path = self.folder / name
            if not path.exists() or name == "arm.yaml":
                self.git("checkout", "--ours", "--", name, fails=True)
                continue
            how = self.chance.choice(("ours", "theirs", "hunks", "hunks", "hunks", "hunks"))
            if name == "tracerisk.lock":
                if self.chance.random() < 0.4:
                    continue  # its markers stay, as the documentation says
                how = self.chance.choice(("ours", "theirs", "hunks"))
            if how == "hunks" and "<<<<<<<" in path.read_text():
                path.write_text(self.by_hunks(path.read_text()))
            else:
                self.git("checkout", f"--{how.replace('hunks', 'ours')}", "--", name, fails=True)

    def by_hunks(self, text: str) -> str:
        """Resolve each conflict by one of its sides."""

        def pick(found: re.Match[str]) -> str:
            return self.chance.choice((found["ours"], found["theirs"]))

        return re.sub(
            r"<{7}.*\n(?P<ours>(?:.*\n)*?)(?:\|{7}.*\n(?:.*\n)*?)?={7}\n(?P<theirs>(?:.*\n)*?)>{7}.*\n",
            pick,
            text,
        )

    def upset_lock(self) -> None:
        path = self.folder / "tracerisk.lock"
        chance = self.chance.random()
        if chance < 0.15:
            path.unlink(missing_ok=True)
        elif chance < 0.4:
            commits = self.git("log", "--all", "--format=%H").split()
            older = self.git("show", f"{self.chance.choice(commits)}:tracerisk.lock", fails=True)
            if older:
                path.write_text(older)

    def settle_code(self) -> None:
        """Take a side whole where the mixture is no program, or its blocks are none."""
        for name in ("c.py", "arm.yaml", "pyproject.toml"):
            # The first commit of all may have been reverted.
            if not (self.folder / name).exists():
                self.git("checkout", self.chance.choice(self.branches), "--", name)
        if not self._is_sound():
            # The tip of a branch that was rebased may be the mixture itself.
            sides = self.chance.sample(self.branches, len(self.branches))
            any(self._takes_sound(side) for side in sides)
        assert self._is_sound()
        source = self.read()
        names = functions(source)
        left = [name for name in calls_of(source) if name in names] or names[:1]
        self.write(self.main, with_calls(source, left))

    def _takes_sound(self, branch: str) -> bool:
        self.git("checkout", branch, "--", "c.py", fails=True)
        return self._is_sound()

    def _is_sound(self) -> bool:
        source = self.read()
        try:
            names = functions(source)
            # A block of a renamed function is followed by the tool.
            follow_renames(source.encode(), "c.py", ())
        except (SyntaxError, TraceRiskError):
            return False
        return len(set(names)) == len(names) > 0 and source.count("CALLS = ") == 1

    # What the tool does, and what it must not.

    def computed_log(self) -> str:
        source = self.read()
        active = {
            node.name: sorted(
                {
                    call.func.id
                    for call in ast.walk(node)
                    if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)
                }
                & set(COMPONENTS)
            )
            for node in ast.parse(source).body
            if isinstance(node, ast.FunctionDef)
        }
        calls = [name for name in calls_of(source) if name in active] or [next(iter(active))]
        rows = [
            f"Function:{name}()\nActiveComponents:{','.join(active[name])}"
            for name in dict.fromkeys(calls)
        ]
        return "\n".join([*rows, "", "CallSequence:" + ",".join(f"{each}()" for each in calls)])

    def trace(self) -> Trace:
        return read_log(self.computed_log(), "run.log", controller=self.main)

    def annotated(self, policy: MergePolicy) -> Annotated:
        controller = api.load_controller(self.folder / self.main)
        hardware = str(self.folder / "arm.yaml")
        settings = api.load_settings(controller, {"hardware": hardware})
        trace = self.trace()
        return api.annotate(
            controller,
            trace,
            api.load_hardware(settings, ""),
            settings,
            policy=policy,
            given={"hardware": hardware},
        )

    def refresh(self, how: str = "as it is") -> None:
        hidden = self.folder.parent / f"{self.folder.name}-git"
        shallow = self.folder / ".git" / "shallow"
        if how == "without git":
            (self.folder / ".git").rename(hidden)
        elif how == "shallow" and not shallow.exists():
            shallow.write_text(self.git("rev-parse", "HEAD"))
        try:
            self._refresh()
        finally:
            if how == "without git":
                hidden.rename(self.folder / ".git")
            elif how == "shallow":
                shallow.unlink(missing_ok=True)

    def _refresh(self) -> None:
        self.check()
        before = self.text()
        for edits in ("stop", self.chance.choice(("accept", "discard")), "discard"):
            try:
                done = self.annotated(MergePolicy(edits))
            except EditInTheWayError as error:
                assert edits != "discard"
                assert self.text() == before
                self.stops += 1
                self.judge(str(error))
                continue
            except LockError as error:
                # Sides that are no JSON: the message says to take one of them.
                self.notes.append(str(error))
                (self.folder / "tracerisk.lock").unlink()
                self._refresh()
                return
            except TraceRiskError as error:
                if edits == "accept" and self._leads_to_what_was_renamed(str(error)):
                    continue
                # A rank or a target of two branches; none is typed here.
                raise AssertionError(f"{self.notes}: {error}") from error
            done.write()
            break
        after = self.text()
        self.keeps_pins(before, after)
        self.invents_nothing()
        if edits == "stop":
            lost = {each for each in self.typed.edits if f"= {each}\n" in before} - {
                each for each in self.typed.edits if each in after
            }
            gone = {each for each in lost if not self.is_in_live_block(before, each)}
            assert lost == gone, f"{self.notes}: typed and lost: {lost}"
        assert not self.annotated(MergePolicy()).is_changed
        assert not self.findings(), self.findings()

    def _leads_to_what_was_renamed(self, expected: str) -> bool:
        """Return whether a `next` leads to a name that was typed for a function since deleted."""
        found = re.search(r"leads to '(\w+)', not a function", expected)
        return found is not None and found[1] in self.typed.targets - set(self.names())

    def findings(self) -> list[str]:
        """Return what check finds that a refresh would mend, or that is not true."""
        found = check_controller(self.folder / self.main, Projects()).findings
        return [
            str(finding)
            for finding in found
            if finding.kind != "unknown"
            and not (finding.kind == "moved" and self._has_moved(finding.message))
        ]

    def _has_moved(self, message: str) -> bool:
        """Return whether the code is such that a value by hand is not for what is done there."""
        unvisited = re.match(r"what is set by hand in the block of (\S+) counts nothing", message)
        if unvisited is not None:
            return f"Function:{unvisited[1]}(" not in self.computed_log()
        said = re.match(
            r"(\w+) is .* in (\S+) for .*, now (\S+)\)(?:, and (.+) took over)?"
            r"(?:.*, and what (.+) did with it)?",
            message,
        )
        assert said is not None, message
        component, name, now, took, gave = said.groups(default="")
        users = {
            user
            for user, used in re.findall(
                r"Function:(.+)\(\)\nActiveComponents:(.*)", self.computed_log()
            )
            if component in used.split(",")
        }
        if (now == "none") != (name not in users):
            return False
        new, left = (set(names.split(", ")) - {""} for names in (took, gave))
        return name not in users or (new | left != set() and new <= users and not left & users)

    def keeps_pins(self, before: str, after: str) -> None:
        def held(text: str) -> set[str]:
            return {each for each in self.typed.pins if each in text}

        assert held(before) <= held(after), f"{self.notes}: {held(before) - held(after)} lost"

    def invents_nothing(self) -> None:
        """Assert that whatever is set by hand was typed, or taken out, by a person."""

    def judge(self, expected: str) -> None:
        """Compare what is called a person's with what was typed, and that alone with advice."""
        certain, _, doubtful = expected.partition("it is unknown who wrote these values")
        assert ":=" not in doubtful
        assert "--accept-edits" not in doubtful
        for line in certain.splitlines():
            self.judge_line(line)

    def judge_line(self, line: str) -> None:
        changed = re.search(r"(\S+) is (.+?)(?:,| \(last) ?(?:was|written)", line)
        if changed is not None:
            # Where a renamed function is there, the tool knows the name in a `next` by it.
            targets = {each.split(" ")[0] for each in changed[2].split(", ")}
            is_left = targets & self.typed.targets - set(self.names())
            assert is_left or changed[2] in self.typed.edits, f"{self.notes}: {line}"
        if re.search(r" was removed", line):
            path = line.split(" was removed")[0].split()[-1]
            function, _, name = path.rpartition(".")
            pair = self.typed.first_name(function), name
            assert pair in self.typed.removed, f"{self.notes}: {line}"
        assert " was added" not in line, f"{self.notes}: {line}"

    def names(self) -> list[str]:
        return functions(self.read())

    def text(self) -> str:
        """Return all that the sources hold."""
        return self.read()

    def is_in_live_block(self, text: str, figure: str) -> bool:
        """Return whether a value stands in the block of a function that is called."""
        for part in re.split(r"^(?=def )", text, flags=re.MULTILINE):
            name = re.match(r"def (\w+)", part)
            if figure in part and name is not None:
                return name[1] in calls_of(text)
        return False

    def check(self) -> None:
        """Judge what `check` says; where it finds nothing, nothing is stale."""
        if not (self.folder / "tracerisk.lock").exists():
            return
        try:
            found = check_controller(self.folder / self.main, Projects()).findings
        except TraceRiskError:
            return
        for each in found:
            if each.kind == "edited":
                self.judge_line(each.message)
        if not found:
            done = self.annotated(MergePolicy("discard"))
            for file, content in done.sources.items():
                assert values(content, file) == values(done.before[file], file), self.notes


def calls_of(source: str) -> list[str]:
    """Return the functions that a script calls, in their order."""
    found = CALLS.search(source)
    assert found is not None
    return found[2].replace('"', " ").split()


def with_calls(source: str, names: Sequence[str]) -> str:
    """Return the script with calls of these functions instead of its own."""
    return CALLS.sub(rf'\1"{" ".join(names)}"', source)


def functions(source: str) -> list[str]:
    return [node.name for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)]


def values(source: bytes, file: str) -> dict[str, list[str]]:
    """Return the tool's values in the blocks of a source."""
    found: dict[str, list[str]] = {}
    for placed in read_blocks(source, file):
        block = placed.block
        row = [f"{block.call_sequence.text}", "" if block.next is None else block.next.text]
        for each in block.components:
            if not each.added and not each.omitted and not each.probability.pinned:
                row += [each.name, each.probability.text, each.quantity.text, each.redundancy.text]
        found[str(placed.function)] = row
    return found


def run_history(folder: Path, seed: int) -> int:
    """Make one history; return how often the tool stopped."""
    return live(History(folder, seed))


def live(history: History) -> int:
    """Branch and bring together at random; return how often the tool stopped."""
    for _ in range(history.chance.randint(1, 3)):
        history.branch()
        history.work()
    for _ in range(history.chance.randint(2, 4)):
        for name in history.chance.sample(history.branches, 2):
            history.git("checkout", "--quiet", name)
            history.work()
        history.bring_together()
    return history.stops
