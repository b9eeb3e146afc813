"""The proof refuses what is wrong, whoever made it."""

import pytest

from tracerisk.adder.sources.edits import Edit, apply_edits
from tracerisk.adder.sources.python_lines import parse_python
from tracerisk.adder.sources.safety import check_rewrite, check_same_program
from tracerisk.errors import UnsafeRewriteError

SOURCE = parse_python(b"def f():\n    return 1\n", "c.py")


def test_a_byte_beside_the_blocks_is_refused() -> None:
    with pytest.raises(UnsafeRewriteError, match="would not give the same bytes"):
        check_rewrite(SOURCE, (), b"def f():\n    return 1\n\n", ())


def test_a_result_that_is_no_python_is_refused() -> None:
    with pytest.raises(UnsafeRewriteError, match="the file would no longer be read"):
        check_rewrite(SOURCE, (), b"def f():\nreturn 1\n", ())


def test_a_block_that_is_missing_is_refused(make_block) -> None:
    with pytest.raises(UnsafeRewriteError, match="would not be read back as they were written"):
        check_rewrite(SOURCE, (), b"def f():\n    return 1\n", (make_block("f"),))


@pytest.mark.parametrize(
    ("other", "line"),
    [
        ("def f():\n    return 2\n", 2),
        ("def f():\n    return True\n", 2),
        ("def f():\n    return 1.0\n", 2),
        ("def f():\n    return 1\npass\n", 1),
        ("def g():\n    return 1\n", 1),
    ],
)
def test_another_program_is_refused_with_the_line(other: str, line: int) -> None:
    with pytest.raises(UnsafeRewriteError) as caught:
        check_same_program(SOURCE, parse_python(other.encode(), "c.py"), "adding")
    assert str(caught.value) == (
        f"c.py:{line}: adding risk blocks would change what the program says"
    )


def test_lines_alone_make_no_other_program() -> None:
    moved = parse_python(b"# word\n\ndef f():\n\n    return (1)\n", "c.py")
    check_same_program(SOURCE, moved, "adding")


def test_edits_are_made_on_the_original_bytes_in_any_order() -> None:
    edits = [Edit(4, 5, b"five"), Edit(0, 1, b""), Edit(2, 2, b"--")]
    assert apply_edits(b"abcdef", edits) == b"b--cdfivef"
    with pytest.raises(ValueError, match="edits overlap"):
        apply_edits(b"abcdef", [Edit(0, 3, b""), Edit(2, 4, b"")])
