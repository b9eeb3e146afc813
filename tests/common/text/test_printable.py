"""What others wrote moves no cursor, names no window and commands no log, wherever it is shown."""

import json
import random
import re

import pytest

from tracerisk.common.text.printable import (
    MOST_CHARACTERS,
    escaped,
    escaped_but_colors,
    one_line,
    printable,
    printable_json,
    printable_script,
    without_controls,
)

HOSTILE = (
    *("\x1b[2J", "\x1b]52;c;aGk=\x07", "\x1b]8;;http://a\x1b\\x\x1b]8;;\x1b\\", "\x9b31m", "\x00"),
    *("\r", "\x08\x08", "\x0b", "\x0c", "\x7f", "\x85", "\u2028", "\u2029", "\u202e", "\u2066"),
    *("\u200f", "\u061c", "\ufeff", "\udcff", "\ud800", "\U000e0041", "::error title=a::b", "\n::add-path::x"),
    *("##[command]x", "##vso[task.setvariable]x", "a##[group]", "\t ::debug::x", "\u3000::notice::y"),
)  # fmt: skip
CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff\U000e0000-\U000e007f]"
)


def commands_in(shown):
    """What a runner takes for commands: by the begin of a line, and the older ones anywhere."""
    lines = shown.splitlines()
    return [line for line in lines if line.lstrip().startswith("::") or re.search(r"##\w*\[", line)]


def is_harmless(shown):
    return CONTROL.search(shown) is None and not commands_in(shown)


@pytest.mark.parametrize("text", HOSTILE, ids=ascii)
@pytest.mark.parametrize("function", [printable, escaped, escaped_but_colors, one_line])
def test_a_hostile_text_is_only_shown(function, text):
    assert is_harmless(function(text))
    assert is_harmless(function(f"a {text} b\n{text}"))


def test_any_mixture_of_hostile_texts_is_only_shown():
    chance = random.Random(0)
    pieces = [
        *HOSTILE,
        "a",
        " ",
        "\n",
        "\n\n",
        ":",
        "::",
        "#",
        "##",
        "[",
        "größer",
        "\x1b",
        "\x1b[",
    ]
    for _ in range(3000):
        text = "".join(chance.choices(pieces, k=chance.randint(1, 12)))
        for function in (printable, escaped, escaped_but_colors, one_line):
            once = function(text)
            assert is_harmless(
                once.replace("\x1b[0m", "") if function is escaped_but_colors else once
            )
            assert escaped(once) == once, ascii(text)


@pytest.mark.parametrize(
    "text", ["ns::turn in größer.py", "a\tb\nc", "## Heading", "# [x](y)", "日本", "a\u200db"]
)
def test_what_is_harmless_stays_as_it_is(text):
    assert printable(text) == text


def test_what_is_endless_is_cut():
    assert printable("x" * 30_000).endswith(" ... and 10000 more characters")
    assert len(escaped("x" * 30_000)) == 30_000 > MOST_CHARACTERS


def test_our_own_colours_stay_and_other_sequences_do_not():
    assert escaped_but_colors("\x1b[1;31mred\x1b[0m\x1b[2Jx") == "\x1b[1;31mred\x1b[0m\\x1b[2Jx"


@pytest.mark.parametrize("text", HOSTILE, ids=ascii)
def test_json_keeps_its_meaning(text):
    data = {f"key {text}": [text, f"\\{text}", f'"{text}"']}
    for ascii_only in (False, True):
        shown = printable_json(json.dumps(data, ensure_ascii=ascii_only, indent=1))
        assert is_harmless(shown)
        assert json.loads(shown) == data
        assert shown.encode()


@pytest.mark.parametrize("text", HOSTILE, ids=ascii)
def test_a_script_shows_texts_without_controls(text):
    data = [text, f"\\{text}", f'"{text}"', "plain\n\t"]
    shown = json.loads(printable_script(json.dumps(data)))
    if text == "\r":  # a line end of a source there
        assert shown == data
    else:
        assert shown == [without_controls(each) for each in data]
