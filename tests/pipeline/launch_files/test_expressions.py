"""The expressions of launch files: no more than arithmetic and texts."""

import pytest

from tracerisk.pipeline.launch_files.expressions import evaluate


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3", 7),
        ("'a' + 'b'", "ab"),
        ("x if y == 'ur5' else 0", 2),
        ("not (x > 1 and x < 3)", False),
        ("y.upper()[0]", "U"),
        ("math.pi / 2 > 1.5", True),
        ("round(sqrt(x), 3)", 1.414),
        ("'ur' in y", True),
        ("str(x) + '/' + y", "2/ur5"),
    ],
)
def test_simple_expressions_have_their_value(text, value):
    assert evaluate(text, {"x": 2, "y": "ur5"}) == value


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("__import__('os')", "nothing is called '__import__'"),
        ("open('a')", "nothing is called 'open'"),
        ("(1).__class__", "is not a simple expression"),
        ("'a'.format(1)", "is not called here"),
        ("9 ** 99999", "too large"),
        ("((9 ** 999) ** 999) ** 999", "too large"),
        ("'a' * 10 ** 12", "grows over"),
        ("unknown", "nothing is called 'unknown'"),
        ("1 / 0", "cannot be evaluated"),
        ("math.tau_half", "cannot be evaluated"),
        ("1 +", "cannot be evaluated"),
        ("[i for i in 'ab']", "is not a simple expression"),
        ("a" * 20000, "more than"),
    ],
)
def test_all_else_is_refused(text, reason):
    with pytest.raises(ValueError, match=reason):
        evaluate(text, {})
