"""The work of hybrid models grows with their size, and no faster: instructions are counted."""

import sys
from dataclasses import replace
from fractions import Fraction

import pytest

from tracerisk.adder.blocks.block import Field, Transition
from tracerisk.prm import build_model, solve
from tracerisk.prm.hybrid import importance
from tracerisk.prm.hybrid.elements import DONE
from tracerisk.prm.hybrid.hybrid import endless_states
from tracerisk.prm.hybrid.solve import solve_figures

TWICE = 2.3
"""What is linear, with sorting and heaps, takes at most so many times more at twice the size."""


def instructions(work):
    """Return how many instructions of Python a call runs: the same number every time."""
    count = 0

    def trace(frame, event, _):
        nonlocal count
        frame.f_trace_opcodes = True
        count += event == "opcode"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        work()
    finally:
        sys.settrace(before)
    return count


@pytest.fixture(scope="module")
def long_mission(block, component):
    """Make the blocks of functions with components of their own, each with a way back."""

    def make(functions, components=2):
        names = [f"f{number}" for number in range(functions)]
        blocks = []
        for number, name in enumerate(names):
            onward = names[number + 1] if number + 1 < functions else DONE
            back = names[max(number - 2, 0)]
            parts = [component(f"c{number}_{each}", 1e-6) for each in range(components)]
            after = {onward: Fraction(9, 10), back: Fraction(1, 10)}
            blocks.append(block(name, number + 1, parts, after=after))
        return blocks

    return make


def grows_linearly(work, sizes=(40, 80, 160)):
    counts = [instructions(work(size)) for size in sizes]
    return counts[2] - counts[1] <= TWICE * (counts[1] - counts[0])


def test_building_a_model_takes_work_in_proportion_to_its_functions(long_mission):
    def work(size):
        blocks = long_mission(size)
        return lambda: build_model(blocks, name="long")

    assert grows_linearly(work)


def test_the_figures_take_work_in_proportion_to_the_functions(long_mission):
    def work(size):
        model = build_model(long_mission(size), name="long")
        return lambda: solve_figures(model)

    assert grows_linearly(work)


def test_each_way_is_followed_once_to_find_what_never_ends(long_mission):
    class Steps(tuple):
        read = 0

        def __iter__(self):
            Steps.read += 1
            return super().__iter__()

    model = build_model(long_mission(50), name="long")
    steps = {state.name: Steps(state.next) for state in model.states}
    assert endless_states(steps, model.entry) == []
    assert Steps.read == 2 * len(steps)  # once for what leads to `done`, once from the entry on


def test_importances_take_work_in_proportion_to_the_functions(long_mission):
    def work(size):
        model = build_model(long_mission(size), name="long")
        return lambda: solve(model)

    assert grows_linearly(work, sizes=(20, 40, 80))


def test_importances_of_many_components_take_work_in_proportion_to_them(long_mission):
    # The parts that grow with the square, for the components in a tree, would show here.
    def work(size):
        model = build_model(long_mission(3, components=size), name="wide")
        return lambda: solve(model)

    assert grows_linearly(work, sizes=(70, 140, 280))


def test_parameters_of_one_function_have_the_importance_of_chains_solved_anew(
    long_mission, monkeypatch
):
    # Ways back of 1/10 and figures of 1e-6; then a function that fails often, in a long loop.
    blocks = long_mission(12)
    often = replace(blocks[5].components[0], probability=Field(0.4, "0.4"))
    seldom_left = (Transition("f5", Fraction(98, 100)), Transition("f6", Fraction(2, 100)))
    blocks[5] = replace(
        blocks[5],
        components=(often, blocks[5].components[1]),
        next=Field(seldom_left, "f5 0.98, f6 0.02"),
    )
    model = build_model(blocks, name="long")
    found = solve(model).components
    monkeypatch.setattr(importance, "_change_in_one", lambda *_: None)
    expected = solve(model).components
    for one, other in zip(found, expected, strict=True):
        for measure in ("fussell_vesely", "without", "risk_achievement_worth", "tenfold"):
            assert getattr(one, measure) == pytest.approx(getattr(other, measure), rel=2e-15)
