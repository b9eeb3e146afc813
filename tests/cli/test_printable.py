"""What others named or raised is only shown: by a terminal, and by the log of a CI job."""

from __future__ import annotations

import pytest

from tracerisk.cli.output import MOST_CHARACTERS, printable


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("::error title=t::msg.py:1: stale", "./::error title=t::msg.py:1: stale"),
        ("a\n  ::add-mask::x", "a\n./  ::add-mask::x"),
        ("##[error]x", "./##[error]x"),
        ("a\rb\x1b[31mred\x07", "a\\rb\\x1b[31mred\\x07"),
        ("\u202etxt.exe", "\\u202etxt.exe"),
        ("a::b\n\tc \u00fc", "a::b\n\tc \u00fc"),
    ],
)
def test_what_would_act_is_only_shown(text, shown):
    assert printable(text) == shown


def test_a_text_without_end_is_cut():
    assert len(printable("x" * 50_000_000)) < MOST_CHARACTERS + 50


def test_a_file_name_is_no_workflow_command(example):
    name = "::error title=t::msg.py"
    example.write(name, "def f():\n    # | RiskAnnotation\n    # | @Function {\n    pass\n")
    outcome = example.run("check", name)
    assert outcome.code == 2
    lines = (outcome.out + outcome.err).splitlines()
    assert any(name in line for line in lines)
    assert not any(line.lstrip().startswith("::") for line in lines)
