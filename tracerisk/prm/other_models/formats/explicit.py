"""Explicit files of transitions (.tra) and labels (.lab), as Storm and PRISM read them.

Storm: the kind of chain on the first line; labels by `#DECLARATION` and `#END`.
PRISM (manual, appendix "Explicit Model Files"): the numbers of states and transitions on the
first line; labels by numbers, `0="init"`. Reading infers which is which.
"""

from __future__ import annotations

import enum
import math
import re
from collections.abc import Callable, Iterator

from tracerisk.common.text.bounded import whole_number
from tracerisk.errors import Location, ModelError, TooLargeError
from tracerisk.prm.numbers.gc_pause import collection_paused
from tracerisk.prm.other_models.formats.explicit_chain import (
    INITIAL,
    ChainKind,
    ExplicitChain,
    names_from_labels,
)

MOST_STATES = 2_000_000
MOST_TRANSITIONS = 8_000_000
_UNNAMED = 1_000
"""How many states there may be that no transition names, so that small files need not be whole."""
_PIECE = 1_000_000
"""How many characters of a text are split into lines at a time."""
_END = 1_000
"""How many characters at the end of a text are looked at first."""
_LONG = 19
"""From so many digits on, a number is looked at by itself."""
_PLAIN = re.compile(r"(?:[0-9]{1,18} [0-9]{1,18} [0-9][0-9.eE+-]*+\n)*+")
"""Lines as tools write them, which are read many at a time."""
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
    number = 0
    for piece in _pieces(text):
        for line in piece.splitlines():
            number += 1
            yield number, line


def _pieces(text: str) -> Iterator[str]:
    """Yield whole lines, about a million characters at a time."""
    begin = 0
    while begin < len(text):
        end = text.find("\n", begin + _PIECE) + 1 or len(text)
        yield text[begin:end]
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
            "the file is empty; it must begin with dtmc, ctmc or the numbers of states and "
            "transitions",
            Location(file, 1, 1),
        )
    declared: tuple[int, int] | None = None
    if len(words) == 1:
        word = words[0][1].lower()
        if word not in ("dtmc", "ctmc"):
            raise ModelError(
                f"'{words[0][1]}' is not a supported kind of chain; allowed: ctmc, dtmc",
                Location(file, first, words[0][0]),
            )
        stated = ChainKind(word)
        if kind is not None and kind is not stated:
            raise ModelError(
                f"the file contains a {stated.value}, not a {kind.value}", Location(file, first, 1)
            )
        kind = stated
    elif len(words) == 2:
        declared = (_whole(words[0], file, first), _whole(words[1], file, first))
    head = first if len(words) < 3 else 0
    if declared is not None and declared[0] > most_states:
        raise TooLargeError(
            f"{file}:{first}: {declared[0]} states are declared; at most {most_states} are "
            "supported"
        )
    _check_end(text, file, most_states)
    count = sum(len(piece.splitlines()) for piece in _pieces(text)) - head
    if count > MOST_TRANSITIONS:
        raise TooLargeError(
            f"{file}: {count} lines; at most {MOST_TRANSITIONS} transitions are supported"
        )
    # Each line names two states at most; a greater number is not a state of this file.
    named = max(2 * count, _UNNAMED)
    if declared is not None and declared[0] > named:
        raise TooLargeError(
            f"{file}:{first}: {declared[0]} states are declared, but {count} lines name at most "
            f"{2 * count}"
        )
    allowed = min(named, most_states, declared[0] if declared is not None else named)
    with collection_paused():
        found, highest, there, last = _rows(text, head, file, allowed, most_states, declared)
    if declared is not None and there != declared[1]:
        raise ModelError(
            f"{declared[1]} transitions are declared, but the file has {there}; it is truncated "
            "or its first line is wrong",
            Location(file, last or first),
        )
    size = declared[0] if declared is not None else highest + 1
    if size == 0:
        raise ModelError("the file contains no transitions", Location(file, first))
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
                "supported"
            )


def _rows(
    document: str,
    head: int,
    file: str,
    allowed: int,
    most_states: int,
    declared: tuple[int, int] | None,
) -> tuple[dict[int, dict[int, float]], int, int, int]:
    """Return the ways out of each state, the highest state, how many ways, and the last line.

    States are below `allowed`; the first `head` lines are left out.
    """
    found: dict[int, dict[int, float]] = {}
    highest, ways, last, number = -1, 0, 0, 0
    never: set[int] = set()
    for piece in _pieces(document):
        plain = _plain_piece(piece, allowed) if number >= head else None
        if plain is not None:
            sources, targets, weights = plain
            number = last = number + len(sources)
        else:
            sources, targets, weights = [], [], []
            for line in piece.splitlines():
                number += 1
                words = line.split()
                if number <= head or not words:
                    continue
                last = number
                source, target, weight = _transition(line, words, file, number)
                if max(source, target) >= allowed:
                    raise _beyond(line, max(source, target), file, number, most_states, declared)
                sources.append(source)
                targets.append(target)
                weights.append(weight)
        if not sources:
            continue
        highest = max(highest, max(sources), max(targets))
        ways += len(sources)
        for source, target, weight in zip(sources, targets, weights, strict=True):
            row = found.get(source)
            if row is None:
                found[source] = {target: weight}
            else:
                row[target] = weight
        if 0.0 in weights:
            never.update(s for s, weight in zip(sources, weights, strict=True) if weight == 0.0)
    if sum(map(len, found.values())) < ways:
        raise _twice(document, head, file)
    for source in never:
        found[source] = {target: p for target, p in found[source].items() if p > 0.0}
    return found, highest, ways, last


def _plain_piece(piece: str, allowed: int) -> tuple[list[int], list[int], list[float]] | None:
    """Return sources, targets and weights of lines; `None` where each needs a look of its own.

    Numbers that stand in several lines are one object each.
    """
    if _PLAIN.fullmatch(piece) is None:
        return None
    words = piece.split()
    texts = words[2::3]
    states = {word: int(word) for word in {*words[0::3], *words[1::3]}}
    try:
        weights = {text: float(text) for text in set(texts)}
    except ValueError:
        return None
    if max(states.values()) >= allowed or max(weights.values()) == math.inf:
        return None
    return (
        [states[word] for word in words[0::3]],
        [states[word] for word in words[1::3]],
        [weights[text] for text in texts],
    )


def _twice(document: str, head: int, file: str) -> ModelError:
    """Return the error of the first transition that stands there a second time."""
    seen: set[tuple[int, int]] = set()
    for number, words in _lines(document, head):
        way = int(words[0][1]), int(words[1][1])
        if way in seen:
            return ModelError(
                f"duplicate transition from {way[0]} to {way[1]}; add up the two",
                Location(file, number, words[0][0]),
            )
        seen.add(way)
    raise AssertionError("no transition stands there twice")


def _beyond(
    line: str,
    state: int,
    file: str,
    number: int,
    most_states: int,
    declared: tuple[int, int] | None,
) -> ModelError | TooLargeError:
    """Return the error of a state that the file cannot have."""
    if state >= most_states:
        return TooLargeError(
            f"{file}:{number}: state {state}; at most {most_states} states are supported"
        )
    if declared is not None and state >= declared[0]:
        return ModelError(
            f"state {state}, but the file has {declared[0]} states",
            Location(file, number, _words(line)[0][0]),
        )
    return TooLargeError(
        f"{file}:{number}: state {state}, too high for a file with so few lines; number the "
        "states from 0"
    )


def _transition(line: str, words: list[str], file: str, number: int) -> tuple[int, int, float]:
    """Return source, target and weight of a line, which is split into words."""
    if len(words) not in (3, 4):
        raise ModelError(
            f"{len(words)} words; expected a state, the next state and a number",
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
    sums = ((state, math.fsum(row.values())) for state, row in rows.items() if row)
    wrong = min(((state, total) for state, total in sums if abs(total - 1.0) > 1e-9), default=None)
    if wrong is not None:
        state, total = wrong
        # A number may be written with zeros in front.
        first = next(n for n, words in _lines(text, head) if int(words[0][1]) == state)
        raise ModelError(
            f"the probabilities from state {state} sum to {total!r}; they must sum to 1",
            Location(file, first),
        )


def _read_labels(text: str, file: str, count: int) -> dict[str, frozenset[int]]:
    first, words = next(_lines(text), (1, []))
    if not words:
        raise ModelError(
            'the file is empty; it must begin with #DECLARATION or 0="init"', Location(file, 1, 1)
        )
    if words[0][1].startswith("#"):
        return _storm_labels(text, file, count)
    return _prism_labels(text, words, file, first, count)


def _storm_labels(text: str, file: str, count: int) -> dict[str, frozenset[int]]:
    lines = _lines(text)
    number, words = next(lines)
    if [word for _, word in words] != ["#DECLARATION"]:
        raise ModelError(
            f"'{words[0][1]}' where #DECLARATION is expected", Location(file, number, words[0][0])
        )
    sets: dict[str, set[int]] = {}
    for number, words in lines:
        if words[0][1] == "#END":
            break
        for column, label in words:
            if label.startswith("#"):
                raise ModelError(
                    f"'{label}' where #END is expected", Location(file, number, column)
                )
            sets.setdefault(label, set())
    else:
        raise ModelError("#END is missing after the labels", Location(file, number))

    def undeclared(place: tuple[int, str], line: int) -> set[int]:
        raise ModelError(
            f"label '{place[1]}' is not declared; declared: {', '.join(sets) or 'none'}",
            Location(file, line, place[0]),
        )

    _fill(text, number, file, count, dict(sets), undeclared, end="")
    return {label: frozenset(states) for label, states in sets.items()}


def _prism_labels(
    text: str, words: list[tuple[int, str]], file: str, first: int, count: int
) -> dict[str, frozenset[int]]:
    head = text.splitlines()[first - 1]
    declared: dict[int, set[int]] = {}
    sets: dict[str, set[int]] = {}
    for column, word in words:
        match = _DECLARED.fullmatch(word)
        if match is None:
            raise ModelError(
                f"'{word}' is not a declaration such as 0=\"init\"", Location(file, first, column)
            )
        label = _whole((column, match[1]), file, first)
        if label in declared or match[2] in sets:
            raise ModelError(
                f"{word} is declared twice", Location(file, first, head.index(word) + 1)
            )
        declared[label] = sets[match[2]] = set()

    def numbered(place: tuple[int, str], line: int) -> set[int]:
        label = _whole(place, file, line)
        if label not in declared:
            raise ModelError(
                f"label {label} is not declared; declared: {', '.join(map(str, sorted(declared)))}",
                Location(file, line, place[0]),
            )
        return declared[label]

    _fill(text, first, file, count, {}, numbered, end=":")
    return {label: frozenset(states) for label, states in sets.items()}


def _fill(
    text: str,
    head: int,
    file: str,
    count: int,
    known: dict[str, set[int]],
    other: Callable[[tuple[int, str], int], set[int]],
    *,
    end: str,
) -> None:
    """Add the state of each line, which ends with `end`, to the sets of the line's labels.

    `known` are the sets by the words of labels; `other` finds that of a word, or raises.
    """
    for number, line in _numbered(text):
        words = line.split()
        if number <= head or not words:
            continue
        if not words[0].endswith(end):
            raise ModelError(
                f"'{words[0]}' where a state and a colon are expected",
                Location(file, number, _words(line)[0][0]),
            )
        word = words[0].removesuffix(end)
        usual = len(word) < _LONG and word.isascii() and word.isdigit()
        column = 0 if usual else _words(line)[0][0]
        state = int(word) if usual else _whole((column, word), file, number)
        if state >= count:
            raise ModelError(
                f"state {state}, but the chain has states 0 to {count - 1}",
                Location(file, number, _words(line)[0][0]),
            )
        for place, label in enumerate(words[1:], start=1):
            if label not in known:
                known[label] = other(_words(line)[place], number)
            known[label].add(state)
