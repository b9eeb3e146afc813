"""What others named or raised is only shown: by a terminal, and by the log of a CI job."""

import ast
from pathlib import Path

import pytest

from tracerisk import cli
from tracerisk.common.text.printable import MOST_CHARACTERS, printable


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("::error title=t::msg.py:1: stale", "./::error title=t::msg.py:1: stale"),
        ("a\n  ::add-mask::x", "a\n./  ::add-mask::x"),
        ("a ##[error]x", "a # #[error]x"),
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


def test_a_verb_prints_only_through_what_makes_it_printable():
    """Whole documents (a model, a schema, a completion) are written as they are."""
    bare = []
    for file in Path(cli.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            is_call = isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
            if is_call and node.func.id == "print" and "escaped" not in ast.unparse(node):
                bare.append(f"{file.name}: {ast.unparse(node)}")
    assert sorted(bare) == [
        "__init__.py: print('tracerisk: interrupted', file=sys.stderr)",
        "build.py: print(text, end='')",
        "completion.py: print(shtab.complete(parser, shell=options.shell))",
        "docs.py: print(text, end='')",
        "parser.py: print(f'tracerisk {__version__}')",
    ]


def test_the_exception_of_a_controller_is_only_shown_and_not_without_end(example):
    example.write("loud.py", "raise ValueError('\\x1b[2J\\n::error::pwned ' + 'x' * 50_000_000)\n")
    outcome = example.run("run", "loud.py")
    assert outcome.code == 4
    text = outcome.out + outcome.err
    assert "ValueError: \\x1b[2J" in text
    assert "\x1b" not in text
    assert len(text) < 4 * MOST_CHARACTERS
    assert not any(line.lstrip().startswith("::") for line in text.splitlines())
