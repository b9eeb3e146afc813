"""What makes a source another, and what does not."""

import pytest

from tracerisk.instrument.source.code_digest import code_digest

SOURCE = b'''\
"""Pick.  # no comment"""


def pick(arm):
    speed = 0.5  # half
    # | RiskAnnotation
    arm.go(f"{speed}#a", 'it\\'s', r"\\d#")  # go

    return """
    # text

    """
'''


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (b"  # half", b""),
        (b"  # half", b"  # a third"),
        (b"    # | RiskAnnotation\n", b""),
        (b"def pick", b"# The pick.\n\n\ndef pick"),
        (b"speed = 0.5", b"speed  =  0.5"),
        (b"\n", b"\r\n"),
        (b"\n", b"\r"),
        (b'"""Pick.', b'# First.\n\n"""Pick.'),
        (b"def pick(arm):\n", b"def pick(arm):\n\n    # Go.\n"),
        (b'    """\n', b'    """'),
    ],
)
def test_comments_blank_lines_and_line_ends_say_nothing(before, after):
    changed = SOURCE.replace(before, after)
    assert changed != SOURCE
    assert code_digest(changed, "a.py") == code_digest(SOURCE, "a.py")


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (b"0.5", b"0.6"),
        (b"# no comment", b"# a comment"),
        (b"}#a", b"}#b"),
        (b"    # text\n\n", b"    # text\n"),
        (b"    # text", b"    # other"),
        (b'd#"', b'd# "'),
        (b"    return", b"  return"),
        (b"it\\'s", b"it\\'s # not"),
        (b"speed = 0.5", b"speed = 0.5 ; x = 1"),
    ],
)
def test_everything_else_does(before, after):
    changed = SOURCE.replace(before, after)
    assert changed != SOURCE
    assert code_digest(changed, "a.py") != code_digest(SOURCE, "a.py")


def test_nested_quotes_of_later_versions_hide_nothing():
    one, other = b'x = f"{d["#a"]}"\n', b'x = f"{d["#b"]}"\n'
    assert code_digest(one, "a.py") != code_digest(other, "a.py")


def test_the_digest_is_the_same_on_every_version_of_python():
    assert code_digest(b"x = f'{1}'  \n\n# end", "a.py") == code_digest(b"x = f'{1}'\n", "a.py")
    assert code_digest(SOURCE, "a.py") == DIGEST


DIGEST = "b9c41cefc3244845d3d6b70f065acb7585e14ebca3638c586f3a995cf0fef683"
