"""Numbers and JSON of others, within bounds."""

import pytest

from tracerisk.common.text.bounded import MOST_DIGITS, finite_number, loads_json, whole_number


@pytest.mark.parametrize("text", ["9" * (MOST_DIGITS + 1), "x", "1e3"])
def test_a_whole_number_that_is_none_or_too_long_is_refused(text):
    with pytest.raises(ValueError, match=r"."):
        whole_number(text)


@pytest.mark.parametrize("text", ["1e999", "-1e999", "nan", "inf", "0" * 500])
def test_a_number_that_is_not_finite_or_too_long_is_refused(text):
    with pytest.raises(ValueError, match="a number"):
        finite_number(text)


@pytest.mark.parametrize("text", ["[" * 200_000, '{"a": 1e999}', "[NaN]", "[" + "9" * 5000 + "]"])
def test_json_past_a_bound_is_a_value_error(text):
    with pytest.raises(ValueError, match=r"deeply|a number"):
        loads_json(text)


def test_json_within_bounds_is_as_python_reads_it():
    assert loads_json(b'{"a": [1, 2.5, -3e-5, true, null]}') == {"a": [1, 2.5, -3e-5, True, None]}
