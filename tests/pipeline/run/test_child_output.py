"""What a controller prints is shown as it comes, in whatever parts, and does nothing else."""

import random

import pytest

from tracerisk.common.text.printable import colorless, escaped
from tracerisk.pipeline.run.child_output import PrintableParts

PIECES = (
    *("\x1b[31m", "\x1b]52;c;aGk=\x07", "\x1b", "[", "31m", "\r", "\n", "\r\n", "::", ":", "error::x"),
    *("##", "#", "[group]", "vso[x]", " ", "\t", "a", "größer", "\u202e", "日本", "ns::f", "\udcff"),
)  # fmt: skip


def shown_in_parts(data, cuts):
    parts = PrintableParts()
    texts = [
        parts.of(data[begin:end]) for begin, end in zip([0, *cuts], [*cuts, len(data)], strict=True)
    ]
    return "".join([*texts, parts.rest()])


@pytest.mark.parametrize("seed", range(20))
def test_the_parts_are_shown_as_the_whole_is(seed):
    chance = random.Random(seed)
    for _ in range(200):
        pieces = chance.choices(PIECES, k=chance.randint(1, 15))
        data = "".join(pieces).encode("utf-8", "surrogateescape")
        cuts = sorted(chance.randint(0, len(data)) for _ in range(chance.randint(0, 8)))
        text = colorless(data.decode("utf-8", "replace"))
        whole = escaped(text.replace("\r\n", "\n").replace("\r", "\n"))
        assert shown_in_parts(data, cuts) == whole, (data, cuts)


@pytest.mark.parametrize(
    "text", ["Enter a number: ", "10 %", "done.", "# of parts: ", "a ## b", "path ::"]
)
def test_a_question_without_a_line_end_is_shown_at_once(text):
    assert PrintableParts().of(text.encode()) == text


def test_blanks_without_end_take_no_memory():
    parts = PrintableParts()
    assert sum(len(parts.of(b" " * 10_000)) for _ in range(100)) <= 10_000
    assert parts.of(b"::error::x\n").lstrip().startswith("./")
