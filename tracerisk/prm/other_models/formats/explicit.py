"""Explicit files of transitions (.tra) and labels (.lab), as Storm and PRISM read them.

Storm: the kind of chain on the first line; labels by `#DECLARATION` and `#END`.
PRISM (manual, appendix "Explicit Model Files"): the numbers of states and transitions on the
first line; labels by numbers, `0="init"`. Reading infers which is which.
"""

from __future__ import annotations

import math
import re

from tracerisk.errors import Location, ModelError, TooLargeError
from tracerisk.prm.numbers.gc_pause import collection_paused
from tracerisk.prm.other_models.formats.explicit_chain import (
    INITIAL,
    ChainKind,
    ExplicitChain,
    names_from_labels,
)
from tracerisk.prm.other_models.formats.explicit_labels import read_labels
from tracerisk.prm.other_models.formats.explicit_lines import (
    LONG,
    Dialect,
    lines_of,
    pieces,
    whole,
    words_of,
)

MOST_STATES = 2_000_000
MOST_TRANSITIONS = 8_000_000
_UNNAMED = 1_000
"""How many states there may be that no transition names, so that small files need not be whole."""
_END = 1_000
"""How many characters at the end of a text are looked at first."""
_PLAIN = re.compile(r"(?:[0-9]{1,18} [0-9]{1,18} [0-9][0-9.eE+-]*+\n)*+")
"""Lines as tools write them, which are read many at a time."""


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
    chain_kind, count, rows = _read_transitions(transitions, transitions_file, kind, most_states)
    sets = read_labels(labels, labels_file, count)
    starts = sets.get(INITIAL, frozenset())
    if not starts:
        raise ModelError(f"no state has the label '{INITIAL}'; label one", Location(labels_file, 1))
    names = names_from_labels(count, sets)
    several = tuple(sorted(starts)) if len(starts) > 1 else ()
    return ExplicitChain(chain_kind, min(starts), rows, sets, names, starts=several)


def _read_transitions(
    text: str, file: str, kind: ChainKind | None, most_states: int
) -> tuple[ChainKind, int, tuple[dict[int, float], ...]]:
    first, words = next(lines_of(text), (1, []))
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
        declared = (whole(words[0], file, first), whole(words[1], file, first))
    head = first if len(words) < 3 else 0
    if declared is not None and declared[0] > most_states:
        raise TooLargeError(
            f"{file}:{first}: {declared[0]} states are declared; at most {most_states} are "
            "supported"
        )
    _check_end(text, file, most_states)
    count = sum(len(piece.splitlines()) for piece in pieces(text)) - head
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
        rows, highest, there, last = _rows(text, head, file, allowed, most_states, declared)
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
        _check_sums(rows, text, head, file)
    return (
        kind,
        size,
        tuple(
            row if (row := rows.get(state)) and not (len(row) == 1 and state in row) else {}
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
        if len(word) < LONG and word.isascii() and word.isdigit() and int(word) >= most_states:
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
    rows: dict[int, dict[int, float]] = {}
    highest, ways, last, number = -1, 0, 0, 0
    never: set[int] = set()
    for piece in pieces(document):
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
            row = rows.get(source)
            if row is None:
                rows[source] = {target: weight}
            else:
                row[target] = weight
        if 0.0 in weights:
            never.update(s for s, weight in zip(sources, weights, strict=True) if weight == 0.0)
    if sum(map(len, rows.values())) < ways:
        raise _twice(document, head, file)
    for source in never:
        rows[source] = {target: p for target, p in rows[source].items() if p > 0.0}
    return rows, highest, ways, last


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
    for number, words in lines_of(document, head):
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
            Location(file, number, words_of(line)[0][0]),
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
            Location(file, number, words_of(line)[0][0]),
        )
    source, target, text = words[:3]
    try:
        weight = float(text)
    except ValueError:
        weight = math.nan
    if not 0.0 <= weight < math.inf:
        raise ModelError(
            f"'{text}' is not a probability or rate; give a number of 0 or more",
            Location(file, number, words_of(line)[2][0]),
        )
    both = source + target
    if len(both) < LONG and both.isascii() and both.isdigit():
        # The usual case, without a look at where the words stand.
        return int(source), int(target), weight
    placed = words_of(line)
    return whole(placed[0], file, number), whole(placed[1], file, number), weight


def _check_sums(rows: dict[int, dict[int, float]], text: str, head: int, file: str) -> None:
    sums = ((state, math.fsum(row.values())) for state, row in rows.items() if row)
    wrong = min(((state, total) for state, total in sums if abs(total - 1.0) > 1e-9), default=None)
    if wrong is not None:
        state, total = wrong
        # A number may be written with zeros in front.
        first = next(n for n, words in lines_of(text, head) if int(words[0][1]) == state)
        raise ModelError(
            f"the probabilities from state {state} sum to {total!r}; they must sum to 1",
            Location(file, first),
        )
