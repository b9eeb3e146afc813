"""Who names parts of a robot: the controller, the modules that it imports, programs beside it."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from tracerisk.config import controller_root
from tracerisk.errors import TraceRiskError
from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.pipeline.workspace.controller import Controller, string_literals
from tracerisk.pipeline.workspace.own_modules import imported_directly, own_modules, source_bytes
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.sibling_programs import sibling_programs
from tracerisk.twin.robots.generic import names_asked
from tracerisk.twin.robots.robot_names import words_in

# How much the words of a source count, as a share of those of the controller itself.
_DIRECT, _OF_PACKAGE, _OF_OTHERS, _BESIDE = 0.6, 0.4, 0.2, 0.25

# The calls of MoveIt that are given the name of a state, and the arguments that are the name.
_STATE_CALLS = (
    "remember_joint_values",
    "set_goal_state",
    "set_named_target",
    "set_start_state",
)
_STATE_ARGUMENTS = ("configuration_name", "name")
# What is given the name of a planning group: classes and calls of MoveIt and of libraries on it,
# arguments, and fields of requests.
_GROUP_CALLS = frozenset(
    {"MoveGroupCommander", "MoveGroupInterface", "get_group", "get_planning_component"}
)
_GROUP_NAMES = frozenset(
    {"group", "group_name", "gripper_group_name", "planning_group", "move_group_name"}
)


@dataclass(frozen=True)
class Speech:
    """The names that one source has, and how much they count."""

    who: str
    """Whose source it is, for messages: `its source`."""
    file: str
    """The source, as seen from the top of the project."""
    tree: ast.Module | None = field(repr=False)
    """The source itself; `None` where it is no Python 3."""
    strings: tuple[str, ...]
    """Its strings."""
    listed: tuple[str, ...]
    """What it lists as joints."""
    share: float
    """How much it counts, from 0 to 1."""

    @cached_property
    def words(self) -> frozenset[str]:
        """Its strings and their parts."""
        return words_in(self.strings)

    @cached_property
    def _lines(self) -> dict[str, int]:
        """The first line of each of its strings, and of their parts."""
        lines: dict[str, int] = {}
        for node in ast.walk(self.tree or ast.Module([], [])):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                for word in words_in([node.value]):
                    lines[word] = min(node.lineno, lines.get(word, node.lineno))
        return lines

    def line_of(self, names: Iterable[str]) -> int | None:
        """Return the first line with one of some names as a string, `None` for none."""
        return min((self._lines[name] for name in names if name in self._lines), default=None)

    def without(self, prefix: str) -> Speech:
        """Return the speech with a prefix left out before the names that bear it."""
        bare = (word.removeprefix(prefix) for word in self.words)
        listed = tuple(name.removeprefix(prefix) for name in self.listed)
        return replace(self, strings=tuple(sorted(bare)), listed=listed)


def strings_of(speeches: Iterable[Speech]) -> tuple[str, ...]:
    """Return the strings of some sources, one after the other."""
    return tuple(text for speech in speeches for text in speech.strings)


def states_asked_of(speeches: Iterable[Speech]) -> frozenset[str]:
    """Return the named states that some sources ask for and have not remembered themselves."""
    asked: dict[str, set[str]] = {name: set() for name in _STATE_CALLS}
    for speech in speeches:
        for node in ast.walk(speech.tree or ast.Module([], [])):
            if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
                continue
            if node.func.attr in asked:
                named = (word.value for word in node.keywords if word.arg in _STATE_ARGUMENTS)
                given = [*node.args[:1], *named]
                asked[node.func.attr].update(
                    value.value
                    for value in given
                    if isinstance(value, ast.Constant) and isinstance(value.value, str)
                )
    remembered = asked.pop("remember_joint_values")
    return frozenset().union(*asked.values()) - remembered


def groups_asked_of(speeches: Iterable[Speech]) -> frozenset[str]:
    """Return the planning groups that some sources ask for by name."""
    asked: set[str] = set()
    for speech in speeches:
        for node in ast.walk(speech.tree or ast.Module([], [])):
            values: list[ast.expr | None] = []
            if isinstance(node, ast.Call):
                is_group = last_name(node.func) in _GROUP_CALLS
                values = [*node.args[:1]] if is_group else []
                values += [word.value for word in node.keywords if word.arg in _GROUP_NAMES]
            elif isinstance(node, ast.Assign):
                names = {last_name(target).lower() for target in node.targets}
                values = [node.value] if names & _GROUP_NAMES else []
            asked |= {
                value.value
                for value in values
                if isinstance(value, ast.Constant) and isinstance(value.value, str)
            }
    return frozenset(asked) - {""}


def own_speeches(controller: Controller, also_named: tuple[str, ...] = ()) -> tuple[Speech, ...]:
    """Return what a controller says, and what the modules of its project say that it imports.

    `also_named` are joints that it names in its run.
    """
    own = _speech("its source", controller.path.name, controller.source, 1.0, controller.project)
    own = replace(
        own,
        strings=(*string_literals(controller), *also_named),
        listed=tuple(dict.fromkeys((*also_named, *own.listed))),
    )
    top = controller.project.top
    direct = imported_directly(controller)
    package = controller_root(controller.path).resolve()
    modules = []
    for path in own_modules(controller):
        file = path.relative_to(top).as_posix()
        if path in direct:
            share = _DIRECT
        elif controller_root(path).resolve() == package:
            share = _OF_PACKAGE
        else:
            share = _OF_OTHERS
        modules.append(
            _speech(f"module {path.name}", file, source_bytes(path), share, controller.project)
        )
    return (own, *modules)


def speeches_beside(controller: Controller) -> Iterator[Speech]:
    """Yield what the other programs of a controller's folder say; all of them count as one."""
    for sibling_program in sibling_programs(controller):
        name = sibling_program.path.name
        yield _speech(
            f"{name} beside it", name, sibling_program.source, _BESIDE, controller.project
        )


def _speech(who: str, file: str, text: bytes, share: float, project: Project) -> Speech:
    controller = Controller(Path(file), project, file, text)
    try:
        strings = string_literals(controller)
    except TraceRiskError:
        strings = ()
    listed = names_asked(controller.tree).joints
    return Speech(who, file, controller.tree, strings, listed, share)
