"""Break a controller in one place, automatically: each way has a kind and a few words.

What can be broken is found in the syntax tree, in the scenario, in the robot's file, and at the
places from which the unbroken controller commanded. Nothing is chosen by hand.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import yaml

Files = Mapping[str, str]
Site = tuple[str, int, int]

GONE = "frame, service or parameter gone"
MISSPELT = "joint or group misspelt"
OUT_OF_REACH = "pose out of reach"
GRIPPER = "gripper command dropped or early"
SWALLOWED = "exception swallowed"
EARLY_RETURN = "early return"
WAIT = "wait for ever"
TOPIC = "wrong topic"
MOVED = "object moved away"
LIMIT = "limit of the arm halved"
IGNORED = "result ignored"
KINDS = (
    *(GONE, MISSPELT, OUT_OF_REACH, GRIPPER, SWALLOWED, EARLY_RETURN),
    *(WAIT, TOPIC, MOVED, LIMIT, IGNORED),
)

_ASKING = {"lookup_transform", "can_transform", "ServiceProxy", "create_client", "get_param"}
_ASKING |= {"wait_for_service", "get_parameter", "declare_parameter"}
_TOPICS = {"Publisher", "create_publisher", "Subscriber", "create_subscription"}
_TOPICS |= {"SimpleActionClient", "ActionClient", "wait_for_message"}
_FAR_M, _FAR_RAD = 2.0, 9.0  # [m], [rad]
_AWAY_M = 0.06


@dataclass(frozen=True)
class Commanded:
    """One command of the unbroken run: its sites, outermost first, and whether of a gripper."""

    sites: tuple[Site, ...]
    is_gripper: bool


@dataclass(frozen=True)
class Unbroken:
    """A controller that works: its files, and what its run has shown.

    `names` are the joints and groups of its robot.
    """

    files: Files
    names: frozenset[str]
    commands: tuple[Commanded, ...]

    def trees(self) -> Iterator[tuple[str, ast.Module]]:
        for name, text in self.files.items():
            if name.endswith(".py") and name.rpartition("/")[2] != "setup.py":
                yield name, ast.parse(text)


@dataclass(frozen=True)
class Breakage:
    """A kind, what was done, and the files that differ."""

    kind: str
    what: str
    files: Files


def breakages(unbroken: Unbroken) -> Iterator[Breakage]:
    """Yield every breakage that fits a controller, in the order of the source."""
    for item in (
        *(_names, _scenario_entries, _out_of_reach, _grippers, _swallowed),
        *(_early_returns, _waits, _moved, _limits, _ignored),
    ):
        yield from item(unbroken)


def _edited(
    unbroken: Unbroken, name: str, edit: Callable[[ast.Module], object]
) -> dict[str, str] | None:
    """Return the file after `edit` has changed its tree; None where it changed nothing."""
    tree = ast.parse(unbroken.files[name])
    before = ast.dump(tree)
    edit(tree)
    if ast.dump(tree) == before:
        return None
    return {name: ast.unparse(ast.fix_missing_locations(tree)) + "\n"}


def _same(tree: ast.AST, node: ast.AST) -> ast.AST:
    """Return the node of another tree of the same text that lies at the place of `node`."""
    return next(
        item
        for item in ast.walk(tree)
        if type(item) is type(node)
        and getattr(item, "lineno", 0) == getattr(node, "lineno", 0)
        and getattr(item, "col_offset", 0) == getattr(node, "col_offset", 0)
        and getattr(item, "end_col_offset", 0) == getattr(node, "end_col_offset", 0)
    )


# Names


def _names(unbroken: Unbroken) -> Iterator[Breakage]:
    for name, tree in unbroken.trees():
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                word = node.value
                is_name = len(word) > 3 and any(text.startswith(word) for text in unbroken.names)
                if is_name:
                    spelt = word[: len(word) // 2] + word[len(word) // 2 + 1 :]
                    yield from _renamed(unbroken, name, node, MISSPELT, spelt)
            elif isinstance(node, ast.Call):
                called = ast.unparse(node.func).rpartition(".")[2]
                kind = GONE if called in _ASKING else TOPIC if called in _TOPICS else None
                words = [
                    part
                    for argument in node.args
                    for part in (
                        argument.values if isinstance(argument, ast.JoinedStr) else [argument]
                    )
                    if isinstance(part, ast.Constant) and isinstance(part.value, str)
                ]
                if kind is not None and words:
                    last = words[-1] if called == "lookup_transform" else words[0]
                    yield from _renamed(unbroken, name, last, kind, f"{last.value!s}_other")


def _renamed(
    unbroken: Unbroken, name: str, node: ast.Constant, kind: str, to: str
) -> Iterator[Breakage]:
    def edit(tree: ast.Module) -> None:
        for item in ast.walk(tree):
            is_it = isinstance(item, ast.Constant) and item.value == node.value
            if is_it and (item.lineno, item.col_offset) == (node.lineno, node.col_offset):  # type: ignore[attr-defined]
                item.value = to  # type: ignore[attr-defined]

    files = _edited(unbroken, name, edit)
    if files:
        yield Breakage(kind, f"{name}:{node.lineno} {node.value!r} -> {to!r}", files)


def _scenario_entries(unbroken: Unbroken) -> Iterator[Breakage]:
    for name, text in unbroken.files.items():
        if not name.endswith("scenario.yaml"):
            continue
        for section in ("frames", "services", "parameters"):
            given = yaml.safe_load(text).get(section) or ()
            for key in given if isinstance(given, dict) else range(len(given)):
                data = yaml.safe_load(text)
                gone = data[section].pop(key)
                if not data[section]:
                    del data[section]
                yield Breakage(
                    GONE, f"{name}: {section} {gone}", {name: yaml.safe_dump(data, sort_keys=False)}
                )


# Poses


def _far_edits(tree: ast.Module) -> Iterator[tuple[int, Callable[[ast.Module], None]]]:
    """Yield the lines at which a goal may be put out of reach, and what does so."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and re.search(
            r"position\.[xyz]$", ast.unparse(node.targets[0])
        ):
            yield node.lineno, _farther_m(node)
        elif (
            isinstance(node, ast.List)
            and len(node.elts) >= 4
            and any(isinstance(elt, ast.Constant) and elt.value for elt in node.elts)
            and all(_is_number(elt) for elt in node.elts)
        ):
            yield node.lineno, _farther_rad(node)


def _farther_m(node: ast.Assign) -> Callable[[ast.Module], None]:
    def edit(tree: ast.Module) -> None:
        result = _same(tree, node)
        assert isinstance(result, ast.Assign)
        result.value = ast.BinOp(result.value, ast.Add(), ast.Constant(_FAR_M))

    return edit


def _farther_rad(node: ast.List) -> Callable[[ast.Module], None]:
    def edit(tree: ast.Module) -> None:
        result = _same(tree, node)
        assert isinstance(result, ast.List)
        result.elts[1] = ast.Constant(_FAR_RAD)

    return edit


def _is_number(node: ast.expr) -> bool:
    if isinstance(node, ast.UnaryOp):
        node = node.operand
    return isinstance(node, ast.Constant) and isinstance(node.value, float | int)


def _out_of_reach(unbroken: Unbroken) -> Iterator[Breakage]:
    for name, tree in unbroken.trees():
        for line, edit in _far_edits(tree):
            files = _edited(unbroken, name, edit)
            if files:
                yield Breakage(OUT_OF_REACH, f"{name}:{line} goal put out of reach", files)


# Statements that command


def _blocks(tree: ast.AST) -> Iterator[list[ast.stmt]]:
    for node in ast.walk(tree):
        for field in ("body", "orelse", "finalbody"):
            block = getattr(node, field, None)
            if isinstance(block, list) and block and isinstance(block[0], ast.stmt):
                yield block


def _is_simple(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr | ast.Assign | ast.Return | ast.AugAssign)


def _holds(statement: ast.stmt, sites: set[tuple[int, int]]) -> bool:
    return any(
        isinstance(node, ast.Call) and (node.lineno, node.col_offset + 1) in sites
        for node in ast.walk(statement)
    )


def _commanding(
    unbroken: Unbroken, *, gripper_only: bool = False
) -> Iterator[tuple[str, int, int]]:
    """Yield the simple statements that commanded: file, number of the block, place in it."""
    arms = {
        site for command in unbroken.commands if not command.is_gripper for site in command.sites
    }
    for name, tree in unbroken.trees():
        sites = {
            (line, column)
            for command in unbroken.commands
            if command.is_gripper or not gripper_only
            for file, line, column in command.sites
            if file.endswith(name) and not (gripper_only and (file, line, column) in arms)
        }
        for number, block in enumerate(_blocks(tree)):
            for place, statement in enumerate(block):
                if _is_simple(statement) and _holds(statement, sites):
                    yield name, number, place


def _grippers(unbroken: Unbroken) -> Iterator[Breakage]:
    for name, number, place in _commanding(unbroken, gripper_only=True):

        def drop(tree: ast.Module, number: int = number, place: int = place) -> None:
            block = list(_blocks(tree))[number]
            if isinstance(block[place], ast.Expr):
                block[place] = ast.Pass()

        def early(tree: ast.Module, number: int = number, place: int = place) -> None:
            block = list(_blocks(tree))[number]
            if place > 0 and isinstance(block[place], ast.Expr) and _is_simple(block[place - 1]):
                block[place - 1], block[place] = block[place], block[place - 1]

        line = list(_blocks(ast.parse(unbroken.files[name])))[number][place].lineno
        for what, edit in (("dropped", drop), ("one statement early", early)):
            files = _edited(unbroken, name, edit)
            if files:
                yield Breakage(GRIPPER, f"{name}:{line} gripper command {what}", files)


def _functions_that_command(unbroken: Unbroken) -> Iterator[tuple[str, ast.FunctionDef, int]]:
    """Yield functions, and the first statement of each body that commanded."""
    for name, tree in unbroken.trees():
        sites = {
            (line, column)
            for command in unbroken.commands
            for file, line, column in command.sites
            if file.endswith(name)
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                for place, statement in enumerate(node.body):
                    if _holds(statement, sites):
                        yield name, node, place  # type: ignore[misc]
                        break


def _swallowed(unbroken: Unbroken) -> Iterator[Breakage]:
    for name, function, place in _functions_that_command(unbroken):

        def swallow(
            tree: ast.Module, function: ast.FunctionDef = function, place: int = place
        ) -> None:
            result = _same(tree, function)
            assert isinstance(result, ast.FunctionDef | ast.AsyncFunctionDef)
            fault = ast.parse("raise ValueError('a mistake')").body
            _quieten(result, [*result.body[:place], *fault, *result.body[place:]])

        files = _edited(unbroken, name, swallow)
        if files:
            what = f"{name}: {function.name} raises and swallows it"
            yield Breakage(SWALLOWED, what, files)
    for name, tree in unbroken.trees():
        for line, far in _far_edits(tree):

            def both(tree: ast.Module, far: Callable[[ast.Module], None] = far) -> None:
                far(tree)
                for node in ast.walk(tree):
                    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                        _quieten(node, node.body)

            files = _edited(unbroken, name, both)
            if files:
                what = f"{name}:{line} goal out of reach, every exception swallowed"
                yield Breakage(SWALLOWED, what, files)


def _quieten(node: ast.FunctionDef | ast.AsyncFunctionDef, body: list[ast.stmt]) -> None:
    handler = ast.ExceptHandler(ast.Name("Exception", ast.Load()), None, [ast.Pass()])
    node.body = [ast.Try(body, [handler], [], [])]


def _early_returns(unbroken: Unbroken) -> Iterator[Breakage]:
    for name, function, place in _functions_that_command(unbroken):
        for where in dict.fromkeys((place, min(place + 1, len(function.body) - 1))):

            def edit(
                tree: ast.Module, function: ast.FunctionDef = function, where: int = where
            ) -> None:
                result = _same(tree, function)
                assert isinstance(result, ast.FunctionDef | ast.AsyncFunctionDef)
                result.body.insert(where, ast.Return())

            files = _edited(unbroken, name, edit)
            if files:
                what = f"{name}: {function.name} returns before its statement {where + 1}"
                yield Breakage(EARLY_RETURN, what, files)


_ENDLESS = (
    "__import__('threading').Event().wait()",
    "while True:\n    __import__('time').sleep(0.5)",
    "__import__('queue').Queue().get()",
)


def _waits(unbroken: Unbroken) -> Iterator[Breakage]:
    is_ros2 = any("rclpy" in text for text in unbroken.files.values())
    spin = (
        "while __import__('rclpy').ok():\n    __import__('time').sleep(0.1)"
        if is_ros2
        else "__import__('rospy').spin()"
    )
    ways = (spin, *_ENDLESS)
    for count, (name, number, place) in enumerate(_commanding(unbroken)):
        way = ways[(count + len(unbroken.commands)) % len(ways)]

        def edit(
            tree: ast.Module, number: int = number, place: int = place, way: str = way
        ) -> None:
            block = list(_blocks(tree))[number]
            block[place:place] = ast.parse(way).body

        files = _edited(unbroken, name, edit)
        if files:
            line = list(_blocks(ast.parse(unbroken.files[name])))[number][place].lineno
            yield Breakage(WAIT, f"{name}:{line} before it: {way.splitlines()[-1].strip()}", files)


# The world and the robot


def _moved(unbroken: Unbroken) -> Iterator[Breakage]:
    for name, text in unbroken.files.items():
        if not name.endswith(("scenario.yaml", "scene.yaml")):
            continue
        given = yaml.safe_load(text)
        full = {item.get("stands_in") for item in given.get("objects") or ()}
        for section, key in (("objects", "xyz"), ("racks", "first_slot")):
            for number, item in enumerate(given.get(section) or ()):
                if (not item.get("mass") and item["name"] not in full) or key not in item:
                    continue
                for axis in (0, 1):
                    data = yaml.safe_load(text)
                    data[section][number][key][axis] += _AWAY_M
                    what = f"{name}: {item['name']} is {_AWAY_M} m off along {'xyz'[axis]}"
                    yield Breakage(MOVED, what, {name: yaml.safe_dump(data, sort_keys=False)})


def _limits(unbroken: Unbroken) -> Iterator[Breakage]:
    pattern = re.compile(r'(?:lower|upper|velocity|effort)="(-?[\d.]+)"')
    for name, text in unbroken.files.items():
        if not name.endswith(".urdf"):
            continue
        for match_ in re.finditer(
            r'<joint name="(\w+)" type="revolute">.*?<limit[^>]*>', text, re.DOTALL
        ):
            for limit in pattern.finditer(text, match_.start(), match_.end()):
                key = limit.group(0).partition("=")[0]
                value = float(limit.group(1)) / 2
                changed = text[: limit.start(1)] + f"{value:g}" + text[limit.end(1) :]
                yield Breakage(LIMIT, f"{name}: {key} of {match_.group(1)}", {name: changed})


# Results


def _ignored(unbroken: Unbroken) -> Iterator[Breakage]:
    for name, tree in unbroken.trees():
        far: Sequence[tuple[int, Callable[[ast.Module], None]]] = [*_far_edits(tree)]
        checks = [
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.If)
            and isinstance(node.body[-1], ast.Raise | ast.Return)
            and not node.orelse
        ]
        for number, node in enumerate(checks):
            faults = [(0, None), *((line, edit) for line, edit in far)]
            for line, fault in (faults[0], faults[1 + number % len(far)]) if far else faults:

                def edit(
                    tree: ast.Module,
                    node: ast.If = node,
                    fault: Callable[[ast.Module], None] | None = fault,
                ) -> None:
                    result = _same(tree, node)
                    assert isinstance(result, ast.If)
                    result.body = [ast.Pass()]
                    if fault is not None:
                        fault(tree)

                files = _edited(unbroken, name, edit)
                if files:
                    also = f", goal of line {line} out of reach" if line else ""
                    yield Breakage(IGNORED, f"{name}:{node.lineno} check ignored{also}", files)


def spread(found: Sequence[Breakage], most: Mapping[str, int], turn: int = 0) -> list[Breakage]:
    """Return at most so many of each kind, evenly; `turn` says where to begin."""
    chosen = []
    for kind, wanted in most.items():
        of_kind = [breakage for breakage in found if breakage.kind == kind]
        count = min(wanted, len(of_kind))
        places = sorted(
            (turn + number * len(of_kind) // count) % len(of_kind) for number in range(count)
        )
        chosen += [of_kind[place] for place in places]
    return chosen
