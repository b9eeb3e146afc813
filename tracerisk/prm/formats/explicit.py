"""Explicit files of transitions (.tra) and labels (.lab), as Storm and PRISM read them.

Storm: the kind of chain on the first line; labels by `#DECLARATION` and `#END`.
PRISM (manual, appendix "Explicit Model Files"): the numbers of states and transitions on the
first line; labels by numbers, `0="init"`. Reading infers which is which.
"""

from __future__ import annotations

import enum
import math
import re
from collections.abc import Iterator

from tracerisk.errors import Location, ModelError, TooLargeError
from tracerisk.prm.formats.explicit_chain import (
    INITIAL,
    ChainKind,
    ExplicitChain,
    names_from_labels,
)
from tracerisk.prm.numbers.gc_pause import collection_paused
from tracerisk.text.bounded import whole_number

MOST_STATES = 2_000_000
_UNNAMED = 1_000
"""How many states there may be that no transition names, so that small files need not be whole."""
_PIECE = 1_000_000
"""How many characters of a text are split into lines at a time."""
_NEAR = 50_000
"""How many numbers of lines before are kept."""
_END = 1_000
"""How many characters at the end of a text are looked at first."""
_LONG = 19
"""From so many digits on, two numbers are looked at one by one."""
_DECLARED = re.compile(r'(\d+)="([^"]+)"')


class Dialect(enum.Enum):
    """Whose files."""

    STORM = "storm"
    PRISM = "prism"


def write_transitions(chain: ExplicitChain, dialect: Dialect = Dialect.STORM) -> str:
    """Return the text of a .tra file; each number reads back to the same bits.

    An absorbing state leads to itself with 1, as both tools ask.
    """
    rows = [
        sorted((t, p) for t, p in row.items() if p > 0.0) or [(state, 1.0)]
        for state, row in enumerate(chain.rows)
    ]
    if dialect is Dialect.STORM:
        head = chain.kind.value
    else:
        head = f"{len(rows)} {sum(map(len, rows))}"
    lines = [f"{state} {t} {p!r}" for state, row in enumerate(rows) for t, p in row]
    return "\n".join((head, *lines)) + "\n"


def write_labels(chain: ExplicitChain, dialect: Dialect = Dialect.STORM) -> str:
    """Return the text of a .lab file."""
    if dialect is Dialect.STORM:
        of_state: dict[int, list[str]] = {}
        for label, states in chain.labels.items():
            for state in states:
                of_state.setdefault(state, []).append(label)
        lines = [f"{state} {' '.join(of_state[state])}" for state in sorted(of_state)]
        return "\n".join(("#DECLARATION", " ".join(chain.labels), "#END", *lines)) + "\n"
    labels = list(chain.labels)
    numbers: dict[int, list[str]] = {}
    for number, label in enumerate(labels):
        for state in chain.labels[label]:
            numbers.setdefault(state, []).append(str(number))
    head = " ".join(f'{number}="{label}"' for number, label in enumerate(labels))
    lines = [f"{state}: {' '.join(numbers[state])}" for state in sorted(numbers)]
    return "\n".join((head, *lines)) + "\n"


def read_explicit(
    transitions: str,
    labels: str,
    *,
    transitions_file: str = "transitions",
    labels_file: str = "labels",
    kind: ChainKind | None = None,
    most_states: int = MOST_STATES,
) -> ExplicitChain:
    """Return the chain of a .tra and a .lab file, given as texts.

    `kind` says what the numbers are where the file does not, as PRISM's do not (dtmc if not
    given). States are named by the first label that they have alone, else `s` and their number.
    Raises ModelError with the position of what is malformed; TooLargeError beyond `most_states`.
    """
    found, count, rows = _read_transitions(transitions, transitions_file, kind, most_states)
    sets = _read_labels(labels, labels_file, count)
    starts = sets.get(INITIAL, frozenset())
    if not starts:
        raise ModelError(f"no state has the label '{INITIAL}'; label one", Location(labels_file, 1))
    names = names_from_labels(count, sets)
    several = tuple(sorted(starts)) if len(starts) > 1 else ()
    return ExplicitChain(found, min(starts), rows, sets, names, starts=several)


def _lines(text: str, start: int = 0) -> Iterator[tuple[int, list[tuple[int, str]]]]:
    """Yield the number of each line that is not blank, and its words with their columns.

    The first `start` lines are left out.
    """
    for number, line in _numbered(text):
        if number > start and line.strip():
            yield number, _words(line)


def _numbered(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines and their numbers; of a long text not all are held at once."""
    number = begin = 0
    while begin < len(text):
        end = text.find("\n", begin + _PIECE) + 1 or len(text)
        for line in text[begin:end].splitlines():
            number += 1
            yield number, line
        begin = end


def _words(line: str) -> list[tuple[int, str]]:
    """Return the words of a line with their columns."""
    return [(match.start() + 1, match.group()) for match in re.finditer(r"\S+", line)]


def _read_transitions(
    text: str, file: str, kind: ChainKind | None, most_states: int
) -> tuple[ChainKind, int, tuple[dict[int, float], ...]]:
    first, words = next(_lines(text), (1, []))
    if not words:
        raise ModelError(
            "the file is empty; it begins with dtmc, ctmc or the numbers of states and transitions",
            Location(file, 1, 1),
        )
    declared: tuple[int, int] | None = None
    if len(words) == 1:
        word = words[0][1].lower()
        if word not in ("dtmc", "ctmc"):
            raise ModelError(
                f"'{words[0][1]}' is not a kind of chain that is read; allowed: ctmc, dtmc",
                Location(file, first, words[0][0]),
            )
        stated = ChainKind(word)
        if kind is not None and kind is not stated:
            raise ModelError(
                f"the file holds a {stated.value}, not a {kind.value}", Location(file, first, 1)
            )
        kind = stated
    elif len(words) == 2:
        declared = (_whole(words[0], file, first), _whole(words[1], file, first))
    head = first if len(words) < 3 else 0
    if declared is not None and declared[0] > most_states:
        raise TooLargeError(
            f"{file}:{first}: {declared[0]} states are announced; at most {most_states} are read"
        )
    _check_end(text, file, most_states)
    count = sum(number > head and bool(line.strip()) for number, line in _numbered(text))
    # Each transition names two states; a greater number is not a state of this file.
    named = max(2 * count, _UNNAMED)
    if declared is not None and declared[0] > named:
        raise TooLargeError(
            f"{file}:{first}: {declared[0]} states are announced, and {count} transitions name at "
            f"most {2 * count}"
        )
    allowed = min(named, most_states, declared[0] if declared is not None else named)
    with collection_paused():
        found, highest, last = _rows(text, head, file, allowed, most_states, declared, count)
    if declared is not None and count != declared[1]:
        raise ModelError(
            f"{declared[1]} transitions are announced and {count} are there; "
            "the file is cut off or its first line is wrong",
            Location(file, last or first),
        )
    size = declared[0] if declared is not None else highest + 1
    if size == 0:
        raise ModelError("the file holds no transition", Location(file, first))
    kind = kind or ChainKind.DTMC
    if kind is ChainKind.DTMC:
        _check_sums(found, text, head, file)
    return (
        kind,
        size,
        tuple(
            row if (row := found.get(state)) and not (len(row) == 1 and state in row) else {}
            for state in range(size)
        ),
    )


def _check_end(text: str, file: str, most_states: int) -> None:
    """Raise TooLargeError, before all is read, when the last lines name too many states.

    Tools write the states in order.
    """
    begin = text.rfind("\n", 0, max(0, len(text) - _END)) + 1
    for line in text[begin:].splitlines() if begin > 0 else ():
        word = (line.split() or [""])[0]
        if len(word) < _LONG and word.isascii() and word.isdigit() and int(word) >= most_states:
            raise TooLargeError(
                f"{file}: state {int(word)} in the last lines; at most {most_states} states are "
                "read"
            )


def _rows(
    document: str,
    head: int,
    file: str,
    allowed: int,
    most_states: int,
    declared: tuple[int, int] | None,
    count: int,
) -> tuple[dict[int, dict[int, float]], int, int]:
    """Return the ways out of each state, the highest state, and the last line.

    States are below `allowed`; `count` lines follow the `head`.
    """
    found: dict[int, dict[int, float]] = {}
    never: set[int] = set()
    highest, last = -1, 0
    # Numbers that stand in lines near each other, and weights, are one object each.
    states: dict[str, int] = {}
    weights: dict[str, float] = {}
    for number, line in _numbered(document):
        words = line.split()
        if number <= head or not words:
            continue
        last = number
        a, b, text = words[:3] if len(words) in (3, 4) else ("", "", "")
        source, target, weight = states.get(a), states.get(b), weights.get(text)
        if source is None or target is None or weight is None:
            source, target, weight = _transition(line, words, file, number)
            if max(len(states), len(weights)) >= _NEAR:
                states.clear()
                weights.clear()
            source, target = states.setdefault(a, source), states.setdefault(b, target)
            weight = weights.setdefault(text, weight)
        greater = max(source, target)
        if greater > highest:
            highest = greater
            if highest >= allowed:
                raise _beyond(line, highest, file, number, most_states, declared, count)
        row = found.get(source)
        if row is None:
            found[source] = {target: weight}
        elif target in row:
            raise ModelError(
                f"duplicate transition from {source} to {target}; add the two up",
                Location(file, number, _words(line)[0][0]),
            )
        else:
            row[target] = weight
        if weight == 0.0:
            never.add(source)
    for source in never:
        found[source] = {target: p for target, p in found[source].items() if p > 0.0}
    return found, highest, last


def _beyond(
    line: str,
    state: int,
    file: str,
    number: int,
    most_states: int,
    declared: tuple[int, int] | None,
    count: int,
) -> ModelError | TooLargeError:
    """Return the error of a state that the file cannot have."""
    if state >= most_states:
        return TooLargeError(
            f"{file}:{number}: state {state}; at most {most_states} states are read"
        )
    if declared is not None and state >= declared[0]:
        return ModelError(
            f"state {state}, but the file has {declared[0]} states",
            Location(file, number, _words(line)[0][0]),
        )
    return TooLargeError(
        f"{file}:{number}: state {state}, but {count} transitions name at most "
        f"{2 * count} states; number the states from 0 on"
    )


def _transition(line: str, words: list[str], file: str, number: int) -> tuple[int, int, float]:
    """Return source, target and weight of a line, which is split into words."""
    if len(words) not in (3, 4):
        raise ModelError(
            f"{len(words)} words; a transition is a state, the next state and a number",
            Location(file, number, _words(line)[0][0]),
        )
    source, target, text = words[:3]
    try:
        weight = float(text)
    except ValueError:
        weight = math.nan
    if not 0.0 <= weight < math.inf:
        raise ModelError(
            f"'{text}' is not a probability or rate; give a number of 0 or more",
            Location(file, number, _words(line)[2][0]),
        )
    both = source + target
    if len(both) < _LONG and both.isascii() and both.isdigit():
        # The usual case, without a look at where the words stand.
        return int(source), int(target), weight
    placed = _words(line)
    return _whole(placed[0], file, number), _whole(placed[1], file, number), weight


def _whole(word: tuple[int, str], file: str, line: int) -> int:
    column, text = word
    if not text.isascii() or not text.isdigit():
        raise ModelError(
            f"'{text}' is not a whole number of 0 or more", Location(file, line, column)
        )
    try:
        return whole_number(text)
    except ValueError as error:
        raise ModelError(f"cannot read {error}", Location(file, line, column)) from error


def _check_sums(rows: dict[int, dict[int, float]], text: str, head: int, file: str) -> None:
    for state in sorted(rows):
        row = rows[state]
        total = math.fsum(row.values())
        if row and abs(total - 1.0) > 1e-9:
            # A number may be written with zeros in front.
            first = next(n for n, words in _lines(text, head) if int(words[0][1]) == state)
            raise ModelError(
                f"the probabilities from state {state} sum to {total!r}; they must sum to 1",
                Location(file, first),
            )


def _read_labels(text: str, file: str, count: int) -> dict[str, frozenset[int]]:
    lines = list(_lines(text))
    if not lines:
        raise ModelError(
            'the file is empty; it begins with #DECLARATION or 0="init"', Location(file, 1, 1)
        )
    if lines[0][1][0][1].startswith("#"):
        return _storm_labels(lines, file, count)
    return _prism_labels(text, lines, file, count)


def _storm_labels(
    lines: list[tuple[int, list[tuple[int, str]]]], file: str, count: int
) -> dict[str, frozenset[int]]:
    number, words = lines[0]
    if [word for _, word in words] != ["#DECLARATION"]:
        raise ModelError(
            f"'{words[0][1]}' where #DECLARATION is expected", Location(file, number, words[0][0])
        )
    sets: dict[str, set[int]] = {}
    position = 1
    while position < len(lines) and lines[position][1][0][1] != "#END":
        for column, label in lines[position][1]:
            if label.startswith("#"):
                raise ModelError(
                    f"'{label}' where #END is expected", Location(file, lines[position][0], column)
                )
            sets.setdefault(label, set())
        position += 1
    if position == len(lines):
        raise ModelError("#END is missing after the labels", Location(file, lines[-1][0]))
    for number, words in lines[position + 1 :]:
        state = _state(words[0], file, number, count)
        for column, label in words[1:]:
            if label not in sets:
                raise ModelError(
                    f"label '{label}' is not declared; declared: {', '.join(sets) or 'none'}",
                    Location(file, number, column),
                )
            sets[label].add(state)
    return {label: frozenset(states) for label, states in sets.items()}


def _prism_labels(
    text: str, lines: list[tuple[int, list[tuple[int, str]]]], file: str, count: int
) -> dict[str, frozenset[int]]:
    first = lines[0][0]
    head = text.splitlines()[first - 1]
    declared: dict[int, str] = {}
    names: set[str] = set()
    for column, word in lines[0][1]:
        match = _DECLARED.fullmatch(word)
        if match is None:
            raise ModelError(
                f"'{word}' is not a declaration such as 0=\"init\"", Location(file, first, column)
            )
        label = _whole((column, match[1]), file, first)
        if label in declared or match[2] in names:
            raise ModelError(
                f"{word} is declared twice", Location(file, first, head.index(word) + 1)
            )
        declared[label] = match[2]
        names.add(match[2])
    sets: dict[str, set[int]] = {label: set() for label in declared.values()}
    for number, words in lines[1:]:
        column, word = words[0]
        if not word.endswith(":"):
            raise ModelError(
                f"'{word}' where a state and a colon are expected", Location(file, number, column)
            )
        state = _state((column, word[:-1]), file, number, count)
        for place in words[1:]:
            label = _whole(place, file, number)
            if label not in declared:
                raise ModelError(
                    f"label {label} is not declared; declared: "
                    f"{', '.join(map(str, sorted(declared)))}",
                    Location(file, number, place[0]),
                )
            sets[declared[label]].add(state)
    return {label: frozenset(states) for label, states in sets.items()}


def _state(word: tuple[int, str], file: str, line: int, count: int) -> int:
    state = _whole(word, file, line)
    if state >= count:
        raise ModelError(
            f"state {state}, but the chain has states 0 to {count - 1}",
            Location(file, line, word[0]),
        )
    return state
