"""Which cases of a family each run of the tests takes: always the same, and of every kind."""

import itertools
from types import SimpleNamespace

import pytest

from tests import slow


def case(name: str, *marks: pytest.MarkDecorator, **indices: int) -> SimpleNamespace:
    """A test as pytest has it, as far as the choice looks at it."""
    given = [each.mark for each in marks]
    made = SimpleNamespace(nodeid=f"test_a.py::{name}", own_markers=given)
    made.iter_markers = lambda name: (mark for mark in made.own_markers if mark.name == name)
    if indices:
        made.callspec = SimpleNamespace(indices=indices)
    return made


def crossed(but: int, *, times: int = 1) -> list[tuple[int, int]]:
    """What is quick of a test with four verbs on three systems."""
    pairs = [*itertools.product(range(4), range(3))]
    mark = pytest.mark.slow(but=but)
    cases = [case(f"test_b[{pair}]", mark, verb=pair[0], system=pair[1]) for pair in pairs]
    slow.take_some(cases, times)
    return [pair for pair, each in zip(pairs, cases, strict=True) if not each.own_markers]


def test_each_value_of_crossed_arguments_is_taken_before_any_comes_again():
    quick = crossed(4)
    assert len(quick) == 4
    assert {verb for verb, _ in quick} == {0, 1, 2, 3}
    assert {system for _, system in quick} == {0, 1, 2}


def test_the_choice_is_the_same_each_time_and_a_larger_one_holds_it():
    assert crossed(4) == crossed(4)
    assert set(crossed(2)) < set(crossed(4)) < set(crossed(9))
    assert crossed(3, times=3) == crossed(9)
    assert len(crossed(3, times=100)) == 12


def test_the_choice_does_not_hang_on_the_other_cases_of_the_family():
    mark = pytest.mark.slow(but=2)
    names = [f"test_b[{row}]" for row in "abcdefgh"]
    cases = [case(name, mark, row=index) for index, name in enumerate(names)]
    slow.take_some(cases, 1)
    quick = [each.nodeid for each in cases if not each.own_markers]
    again = [each for each in cases if each.nodeid in quick or each.nodeid.endswith("[a]")]
    for each in again:
        each.own_markers[:] = [mark.mark]
    slow.take_some(again, 1)
    assert [each.nodeid for each in again if not each.own_markers] == quick


def test_what_is_slow_by_itself_stays_so_and_what_is_quick_too():
    long, one = case("test_c", pytest.mark.slow), case("test_d")
    row = case("test_e[1]", pytest.mark.slow, pytest.mark.slow(but=1), row=0)
    slow.take_some([long, one, row], 1)
    assert [bool(each.own_markers) for each in (long, one, row)] == [True, False, True]


def test_a_test_of_one_case_has_no_quick_ones():
    with pytest.raises(pytest.UsageError, match=r"^test_a.py::test_c is one case, of which none"):
        slow.take_some([case("test_c", pytest.mark.slow(but=1))], 1)
