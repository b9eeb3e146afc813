"""Explicit files of labels (.lab): by `#DECLARATION` of Storm, by numbers of PRISM."""

from __future__ import annotations

import re
from collections.abc import Callable

from tracerisk.errors import Location, ModelError
from tracerisk.prm.other_models.formats.explicit_chain import ExplicitChain
from tracerisk.prm.other_models.formats.explicit_lines import (
    LONG,
    Dialect,
    lines_of,
    numbered_lines,
    whole,
    words_of,
)

_DECLARED = re.compile(r'(\d+)="([^"]+)"')


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


def read_labels(text: str, file: str, count: int) -> dict[str, frozenset[int]]:
    """Return the states of each label of a .lab file; raise ModelError where it is malformed."""
    first, words = next(lines_of(text), (1, []))
    if not words:
        raise ModelError(
            'the file is empty; it must begin with #DECLARATION or 0="init"', Location(file, 1, 1)
        )
    if words[0][1].startswith("#"):
        return _storm_labels(text, file, count)
    return _prism_labels(text, words, file, first, count)


def _storm_labels(text: str, file: str, count: int) -> dict[str, frozenset[int]]:
    lines = lines_of(text)
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
        label = whole((column, match[1]), file, first)
        if label in declared or match[2] in sets:
            raise ModelError(
                f"{word} is declared twice", Location(file, first, head.index(word) + 1)
            )
        declared[label] = sets[match[2]] = set()

    def numbered(place: tuple[int, str], line: int) -> set[int]:
        label = whole(place, file, line)
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
    for number, line in numbered_lines(text):
        words = line.split()
        if number <= head or not words:
            continue
        if not words[0].endswith(end):
            raise ModelError(
                f"'{words[0]}' where a state and a colon are expected",
                Location(file, number, words_of(line)[0][0]),
            )
        word = words[0].removesuffix(end)
        usual = len(word) < LONG and word.isascii() and word.isdigit()
        column = 0 if usual else words_of(line)[0][0]
        state = int(word) if usual else whole((column, word), file, number)
        if state >= count:
            raise ModelError(
                f"state {state}, but the chain has states 0 to {count - 1}",
                Location(file, number, words_of(line)[0][0]),
            )
        for place, label in enumerate(words[1:], start=1):
            if label not in known:
                known[label] = other(words_of(line)[place], number)
            known[label].add(state)
