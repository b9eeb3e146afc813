"""A text in the PRISM language as declarations: constants, variables, modules, labels."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.other_models.formats.explicit_chain import ChainKind
from tracerisk.prm.other_models.formats.prism.expressions import (
    Cursor,
    Expression,
    parse_expression,
)
from tracerisk.prm.other_models.formats.prism.tokens import Token, tokens_of

_KINDS = {
    "dtmc": ChainKind.DTMC,
    "probabilistic": ChainKind.DTMC,
    "ctmc": ChainKind.CTMC,
    "stochastic": ChainKind.CTMC,
}
_OTHER_KINDS = ("mdp", "nondeterministic", "pta", "pomdp", "popta", "smg", "imdp", "idtmc")
_NOT_READ = {
    "system": "'system' is not supported: all modules run in parallel; leave it out",
    "invariant": "'invariant' needs clocks, which a dtmc or ctmc does not have",
    "observables": "'observables' belongs to pomdps, which are not supported",
    "player": "'player' belongs to games, which are not supported",
}
_TYPES = ("int", "double", "bool", "rate", "prob")
_READ = ("const", "formula", "global", "init", "label", "module", "rewards")


@dataclass(frozen=True, slots=True)
class Constant:
    """A declared constant."""

    name: str
    """Its name."""
    type: str
    """`int`, `double`, `bool`, `rate` or `prob`."""
    value: Expression | None
    """Expression of its value; `None` for one to be given from outside."""
    location: Location
    """Place of its name."""


@dataclass(frozen=True, slots=True)
class Variable:
    """A declared variable: a whole number or a truth value."""

    name: str
    """Its name."""
    low: Expression | None
    """Least value; `None` for a truth value."""
    high: Expression | None
    """Greatest value; `None` for a truth value."""
    start: Expression | None
    """Initial value; `None` for the least value, or false."""
    location: Location
    """Place of its name."""


@dataclass(frozen=True, slots=True)
class Update:
    """One of the possible effects of a command."""

    weight: Expression | None
    """Probability or rate; `None` for 1."""
    assignments: tuple[tuple[Token, Expression], ...]
    """Variables with their new values, ((name, expression), ...)."""
    location: Location
    """Where it begins."""


@dataclass(frozen=True, slots=True)
class Command:
    """What a module can do in some states."""

    action: str
    """Name of the action by which modules move together; "" for a move alone."""
    guard: Expression
    """Condition on the state."""
    updates: tuple[Update, ...]
    """Possible effects, of which one happens."""
    location: Location
    """Where it begins."""


@dataclass(frozen=True, slots=True)
class Reward:
    """What states, or moves out of them, earn."""

    action: str | None
    """Action of the moves that earn it, "" for those without an action; `None` for the states."""
    guard: Expression
    """Condition on the state."""
    value: Expression
    """Reward in a state where the guard holds."""


@dataclass(slots=True)
class Program:
    """The declarations of a text, in order."""

    kind: ChainKind
    """Whether the chain is in discrete or continuous time."""
    constants: list[Constant] = field(default_factory=list)
    """Declared constants."""
    variables: list[Variable] = field(default_factory=list)
    """Variables of all modules and global ones; their order is the order of a state's values."""
    formulas: dict[str, Expression] = field(default_factory=dict)
    """Expressions of formulas by name."""
    labels: dict[str, Expression] = field(default_factory=dict)
    """Expressions of sets of states by label."""
    commands: dict[str, list[Command]] = field(default_factory=dict)
    """Commands by module."""
    rewards: dict[str, list[Reward]] = field(default_factory=dict)
    """Rewards by name of the structure; "" for one without a name."""
    starts: Expression | None = None
    """Condition on the initial states; `None` where the variables state their values."""


def parse_program(text: str, file: str) -> Program:
    """Return the declarations of a text.

    Raises ModelError with the position of what is malformed or not read.
    """
    cursor = Cursor(tokens_of(text, file))
    first = cursor.take()
    if first.text in _OTHER_KINDS:
        raise ModelError(
            f"a model of kind {first.text} is not supported; allowed: ctmc, dtmc", first.location
        )
    if first.text not in _KINDS:
        first.refuse("the kind of model, dtmc or ctmc,")
    program = Program(_KINDS[first.text])
    bodies: dict[str, list[Token]] = {}
    while cursor.now.kind != "end":
        word = cursor.take()
        if word.text in _NOT_READ:
            raise ModelError(_NOT_READ[word.text], word.location)
        match word.text:
            case "const":
                program.constants.append(parse_constant(cursor))
            case "formula":
                name = cursor.name("the name of a formula")
                cursor.expect("=")
                _once(name, program.formulas, "formula")
                program.formulas[name.text] = parse_expression(cursor)
                cursor.expect(";")
            case "label":
                name, held = parse_label(cursor)
                _once(name, program.labels, "label")
                program.labels[name.text.strip('"')] = held
            case "init":
                if program.starts is not None:
                    raise ModelError("duplicate 'init'; combine the two with |", word.location)
                program.starts = parse_expression(cursor)
                cursor.expect("endinit")
            case "global":
                program.variables.append(_variable(cursor))
            case "module":
                _module(cursor, program, bodies)
            case "rewards":
                _rewards(cursor, program)
            case _:
                word.refuse(f"a declaration ({', '.join(_READ)})")
    if not program.commands:
        raise ModelError("the model has no module", cursor.now.location)
    _check_names(program)
    return program


def _check_names(program: Program) -> None:
    seen: set[str] = set()
    declared = (
        *((constant.name, constant.location) for constant in program.constants),
        *((variable.name, variable.location) for variable in program.variables),
        *((name, expression.location) for name, expression in program.formulas.items()),
    )
    for name, location in declared:
        if name in seen:
            raise ModelError(f"'{name}' is declared twice; rename one", location)
        seen.add(name)


def _once(name: Token, known: dict[str, Expression], kind: str) -> None:
    if name.text.strip('"') in known:
        raise ModelError(f"duplicate {kind} {name.text}; rename one", name.location)


def parse_constant(cursor: Cursor) -> Constant:
    """Return the constant whose declaration goes on at the next word."""
    kind = cursor.take().text if cursor.now.text in _TYPES else "int"
    name = cursor.name("the name of a constant")
    value = parse_expression(cursor) if cursor.accept("=") else None
    cursor.expect(";")
    return Constant(name.text, kind, value, name.location)


def parse_label(cursor: Cursor) -> tuple[Token, Expression]:
    """Return the name and the states of the label whose declaration goes on at the next word."""
    name = cursor.take()
    if name.kind != "text":
        name.refuse("a label in quotes")
    cursor.expect("=")
    states = parse_expression(cursor)
    cursor.expect(";")
    return name, states


def _variable(cursor: Cursor) -> Variable:
    name = cursor.name("the name of a variable")
    cursor.expect(":")
    low = high = None
    if not cursor.accept("bool"):
        if cursor.now.text != "[":
            cursor.now.refuse("bool or a range such as [0..3]")
        cursor.expect("[")
        low = parse_expression(cursor)
        cursor.expect("..")
        high = parse_expression(cursor)
        cursor.expect("]")
    start = parse_expression(cursor) if cursor.accept("init") else None
    cursor.expect(";")
    return Variable(name.text, low, high, start, name.location)


def _module(cursor: Cursor, program: Program, bodies: dict[str, list[Token]]) -> None:
    name = cursor.name("the name of a module")
    if name.text in program.commands:
        raise ModelError(f"duplicate module '{name.text}'; rename one", name.location)
    if cursor.accept("="):
        inner = Cursor(_renamed(cursor, bodies))
    else:
        first = cursor.position
        while cursor.now.text != "endmodule":
            if cursor.now.kind == "end":
                cursor.now.refuse("'endmodule'")
            cursor.take()
        body = cursor.tokens[first : cursor.position]
        end = cursor.expect("endmodule")
        inner = Cursor([*body, replace(end, kind="end")])
    bodies[name.text] = inner.tokens
    commands: list[Command] = []
    while inner.now.kind != "end":
        if inner.now.text == "[":
            commands.append(_command(inner))
        elif inner.now.kind == "name" and inner.ahead(1).text == ":":
            program.variables.append(_variable(inner))
        else:
            inner.now.refuse("a variable, a command or 'endmodule'")
    program.commands[name.text] = commands


def _renamed(cursor: Cursor, bodies: dict[str, list[Token]]) -> list[Token]:
    """Return the words of a module read before, with other names."""
    source = cursor.name("the name of a module")
    if source.text not in bodies:
        raise ModelError(
            f"no module '{source.text}' before this one; {one_of(bodies, source.text)}",
            source.location,
        )
    cursor.expect("[")
    names: dict[str, str] = {}
    while True:
        old = cursor.name("a name")
        cursor.expect("=")
        names[old.text] = cursor.name("a name").text
        if not cursor.accept(","):
            break
    cursor.expect("]")
    cursor.expect("endmodule")
    return [
        replace(token, text=names.get(token.text, token.text)) if token.kind == "name" else token
        for token in bodies[source.text]
    ]


def _command(cursor: Cursor) -> Command:
    location = cursor.expect("[").location
    action = "" if cursor.now.text == "]" else cursor.name("an action").text
    cursor.expect("]")
    guard = parse_expression(cursor)
    cursor.expect("->")
    updates = [_update(cursor)]
    while cursor.accept("+"):
        updates.append(_update(cursor))
    cursor.expect(";")
    return Command(action, guard, tuple(updates), location)


def _update(cursor: Cursor) -> Update:
    location = cursor.now.location
    weight = None
    if not _begins_assignments(cursor):
        weight = parse_expression(cursor)
        cursor.expect(":")
    if cursor.accept("true"):
        return Update(weight, (), location)
    assignments = []
    while True:
        cursor.expect("(")
        name = cursor.name("a variable")
        cursor.expect("'")
        cursor.expect("=")
        assignments.append((name, parse_expression(cursor)))
        cursor.expect(")")
        if not cursor.accept("&"):
            return Update(weight, tuple(assignments), location)


def _begins_assignments(cursor: Cursor) -> bool:
    if cursor.now.text == "true":
        return cursor.ahead(1).text in (";", "+")
    return cursor.now.text == "(" and cursor.ahead(2).text == "'"


def _rewards(cursor: Cursor, program: Program) -> None:
    location = cursor.now.location
    name = cursor.take().text.strip('"') if cursor.now.kind == "text" else ""
    if name in program.rewards:
        raise ModelError(f'duplicate rewards "{name}"; rename one', location)
    rewards = program.rewards[name] = []
    while not cursor.accept("endrewards"):
        if cursor.now.kind == "end":
            cursor.now.refuse("'endrewards'")
        action: str | None = None
        if cursor.accept("["):
            action = "" if cursor.now.text == "]" else cursor.name("an action").text
            cursor.expect("]")
        guard = parse_expression(cursor)
        cursor.expect(":")
        rewards.append(Reward(action, guard, parse_expression(cursor)))
        cursor.expect(";")
