"""Common cause groups: their shares on paper, their expansion by brute force and with SCRAM."""

import re
import shutil
import subprocess
from fractions import Fraction
from itertools import combinations, product
from math import comb
from pathlib import Path

import pytest

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm import BasicEvent, FaultTree, Gate, GateKind
from tracerisk.prm.numbers.probability import Probability, pair_of, value_of
from tracerisk.prm.other_models.logic.common_cause import (
    CommonCauseGroup,
    CommonCauseLaw,
    ShareOf,
    expand_common_cause,
)
from tracerisk.prm.trees.failure_models import Constant, Exponential

BETA, MGL = CommonCauseLaw.BETA, CommonCauseLaw.MGL
ALPHA, PHI = CommonCauseLaw.ALPHA, CommonCauseLaw.PHI


def pumps(count, k, **marks):
    units = tuple(f"pump{number}" for number in range(1, count + 1))
    events = tuple(BasicEvent(unit, "pump", **marks) for unit in units)
    return FaultTree("top", (Gate("top", GateKind.ATLEAST, units, k),), events), units


def test_the_beta_factor_leaves_a_unit_alone_or_hits_all():
    group = CommonCauseGroup("g", ("a", "b", "c"), BETA, (0.1,))
    assert group.shares == {1: 0.9, 3: 0.1}


def test_the_letters_of_mgl_are_conditional_on_one_another():
    beta, gamma, delta = 0.1, 0.4, 0.3
    shares = CommonCauseGroup("g", tuple("abcd"), MGL, (beta, gamma, delta)).shares
    # NUREG/CR-5485: four units.
    assert shares == pytest.approx(
        {
            1: 1 - beta,
            2: beta * (1 - gamma) / 3,
            3: beta * gamma * (1 - delta) / 3,
            4: beta * gamma * delta,
        },
        rel=1e-15,
    )


def test_alpha_factors_depend_on_how_units_are_tested():
    factors = (0.95, 0.03, 0.02)
    together = CommonCauseGroup("g", tuple("abc"), ALPHA, factors).shares
    whole = 0.95 + 2 * 0.03 + 3 * 0.02
    assert together == pytest.approx({1: 0.95 / whole, 2: 0.03 / whole, 3: 3 * 0.02 / whole})
    apart = CommonCauseGroup("g", tuple("abc"), ALPHA, factors, staggered=True).shares
    assert apart == pytest.approx({1: 0.95, 2: 0.03 / 2, 3: 0.02})


@pytest.mark.parametrize("law", [BETA, MGL, ALPHA])
@pytest.mark.parametrize("count", [2, 3, 5])
def test_the_shares_of_the_events_that_hit_a_unit_sum_to_one(law, count):
    factors = {BETA: (0.2,), MGL: (0.2,) * (count - 1), ALPHA: (0.5,) * count}[law]
    shares = CommonCauseGroup("g", tuple("abcde"[:count]), law, factors).shares
    whole = sum(comb(count - 1, level - 1) * share for level, share in shares.items())
    assert whole == pytest.approx(1.0, rel=1e-15)


def test_fewer_levels_end_with_the_last_one():
    shares = CommonCauseGroup("g", tuple("abcd"), MGL, (0.1, 0.4)).shares
    assert shares == pytest.approx({1: 0.9, 2: 0.1 * 0.6 / 3, 3: 0.1 * 0.4 / 3})


def by_hand(count, k, shares, value):
    """Sum over which of the sets of units are hit, in exact rationals."""
    sets = [
        (set(hit), Fraction(shares[level]) * Fraction(value))
        for level in shares
        for hit in combinations(range(count), level)
    ]
    total = Fraction(0)
    for outcome in product((False, True), repeat=len(sets)):
        chance, failed = Fraction(1), set()
        for happens, (units, p) in zip(outcome, sets, strict=True):
            chance *= p if happens else 1 - p
            failed |= units if happens else set()
        if len(failed) >= k:
            total += chance
    return total


GROUPS = [
    (2, 2, BETA, (0.1,)),
    (3, 2, BETA, (0.05,)),
    (3, 3, MGL, (0.1, 0.3)),
    (3, 2, ALPHA, (0.9, 0.07, 0.03)),
    (3, 3, PHI, (0.9, 0.07, 0.03)),
]


@pytest.mark.parametrize("value", [0.2, 1e-6])
@pytest.mark.parametrize(("count", "k", "law", "factors"), GROUPS)
def test_an_expanded_tree_is_the_sum_over_all_sets(exact, count, k, law, factors, value):
    tree, units = pumps(count, k)
    group = CommonCauseGroup("pumps", units, law, factors)
    expanded = expand_common_cause(tree, [group])
    values = {name: Fraction(p) for name, p in expanded.values({"pump": value}).items()}
    by_sets = float(by_hand(count, k, group.shares, value))
    assert float(exact.top(expanded.tree, values)) == pytest.approx(by_sets, rel=1e-14)
    found = expanded.tree.probability({name: float(p) for name, p in values.items()})
    assert found.p == pytest.approx(by_sets, rel=1e-13)


def test_events_are_named_by_the_units_that_they_hit():
    tree, units = pumps(3, 2)
    expanded = expand_common_cause(tree, [CommonCauseGroup("p", units, BETA, (0.1,))]).tree
    assert [(event.name, event.parameter) for event in expanded.events] == [
        ("[pump1]", "pump {1 of 3}"),
        ("[pump2]", "pump {1 of 3}"),
        ("[pump3]", "pump {1 of 3}"),
        ("[pump1 pump2 pump3]", "pump {3 of 3}"),
    ]
    assert Gate("pump2", GateKind.OR, ("[pump2]", "[pump1 pump2 pump3]")) in expanded.gates


def test_a_model_of_the_members_is_shared_out():
    tree, units = pumps(2, 2, model=Exponential(1e-9))
    expanded = expand_common_cause(tree, [CommonCauseGroup("p", units, BETA, (0.1,))])
    at = expanded.tree.values_at(100.0)
    assert at == pytest.approx({"pump {1 of 2}": 0.9e-7, "pump {2 of 2}": 0.1e-7}, rel=1e-7)
    pair = ShareOf(Exponential(1.0), 1.0, "pump").probability(40.0)
    assert pair == Exponential(1.0).probability(40.0)


def test_shares_of_constants_need_no_mission_time():
    tree, units = pumps(2, 2, model=Constant(1e-3))
    expanded = expand_common_cause(tree, [CommonCauseGroup("p", units, BETA, (0.1,))])
    found = expanded.tree.solve()
    assert found.values == pytest.approx({"pump {1 of 2}": 0.9e-3, "pump {2 of 2}": 1e-4})
    assert found.probability == pytest.approx(1e-4 + (1 - 1e-4) * 0.9e-3**2, rel=1e-13)


def test_two_groups_of_one_parameter_keep_their_own_factors():
    units = ("a", "b", "c", "d")
    tree = FaultTree(
        "top",
        (Gate("top", GateKind.AND, units),),
        tuple(BasicEvent(unit, "unit") for unit in units),
    )
    one = CommonCauseGroup("one", units[:2], BETA, (0.1,))
    two = CommonCauseGroup("two", units[2:], BETA, (0.2,))
    values = expand_common_cause(tree, [one, two]).values({"unit": 1e-3})
    assert values == pytest.approx(
        {
            "unit {1 of 2}": 0.9e-3,
            "unit {2 of 2}": 0.1e-3,
            "unit {1 of 2, two}": 0.8e-3,
            "unit {2 of 2, two}": 0.2e-3,
        }
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((("a",), BETA, (0.1,)), "'g': 1 members; it needs at least 2"),
        ((("a", "a"), BETA, (0.1,)), "'g': duplicate member"),
        ((("a", "b"), BETA, (0.1, 0.2)), "2 factors of beta-factor for 2 members; allowed: 1"),
        ((("a", "b"), MGL, (0.1, 0.2)), "2 factors of MGL for 2 members; allowed: 1"),
        ((("a", "b"), ALPHA, ()), "0 factors of alpha-factor for 2 members; allowed: 1 to 2"),
        ((("a", "b"), BETA, (1.1,)), "'g': factor 1 is 1.1; allowed: 0 to 1"),
        ((("a", "b"), ALPHA, (0.0, 0.0)), "'g': all factors are 0"),
        ((("a", "b"), PHI, (0.5, 0.4)), "'g': the factors sum to 0.9; phi-factors"),
        ((("a", "b"), BETA, (0.5,), True), "'g': staggered is for alpha-factor only"),
    ],
)
def test_groups_that_do_not_fit_their_law_are_refused(arguments, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        CommonCauseGroup("g", *arguments)


def test_a_group_that_needs_too_many_events_is_refused():
    units = tuple(map(str, range(20)))
    with pytest.raises(TooLargeError, match="1048575 events for 20 members; allowed: 100000"):
        CommonCauseGroup("g", units, ALPHA, (0.05,) * 20)


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ([("g", ("a", "x"))], "group 'g': member 'x' is not a basic event; allowed: a, b, c"),
        ([("g", ("a", "b")), ("h", ("b", "c"))], "'h': member 'b' is in group 'g' too;"),
        ([("g", ("a", "c"))], "members 'a' and 'c' have the parameters 'unit' and 'c'"),
    ],
)
def test_members_that_do_not_fit_the_tree_are_refused(groups, message):
    events = (BasicEvent("a", "unit"), BasicEvent("b", "unit"), BasicEvent("c"))
    tree = FaultTree("top", (Gate("top", GateKind.AND, ("a", "b", "c")),), events)
    made = [CommonCauseGroup(name, members, BETA, (0.1,)) for name, members in groups]
    with pytest.raises(ModelError, match=re.escape(message)):
        expand_common_cause(tree, made)


def test_a_value_that_lacks_is_named():
    tree, units = pumps(2, 2)
    expanded = expand_common_cause(tree, [CommonCauseGroup("p", units, BETA, (0.1,))])
    with pytest.raises(ModelError, match="parameter 'pump' has no value; allowed: valve"):
        expanded.values({"valve": 0.1})


def scram(path):
    command = ["scram", "--bdd", "--ccf", "1", "--probability", "1", str(path)]
    report = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout
    return float(re.search(r'<sum-of-products[^>]*probability="([^"]+)"', report)[1])


def trains(count, law, factors, q):
    """The pumps and valves of some trains, all of which must fail."""
    lines = [Gate("top", GateKind.AND, tuple(f"train{i}" for i in range(count)))]
    lines += [Gate(f"train{i}", GateKind.OR, (f"valve{i}", f"pump{i}")) for i in range(count)]
    names = {kind: tuple(f"{kind}{i}" for i in range(count)) for kind in ("valve", "pump")}
    events = tuple(BasicEvent(name, kind) for kind in names for name in names[kind])
    groups = [CommonCauseGroup(kind, names[kind], law, factors) for kind in names]
    expanded = expand_common_cause(FaultTree("top", tuple(lines), events), groups)
    return expanded, expanded.values(dict.fromkeys(names, q))


def trains_xml(count, law, factors, q):
    gates = "".join(
        f'<define-gate name="train{i}"><or><event name="valve{i}"/><event name="pump{i}"/></or>'
        "</define-gate>"
        for i in range(count)
    )
    above = "".join(f'<event name="train{i}"/>' for i in range(count))
    first = {BETA: count, MGL: 2}.get(law, 1)
    levels = "".join(
        f'<factor level="{level}"><float value="{factor}"/></factor>'
        for level, factor in enumerate(factors, start=first)
    )
    groups = "".join(
        f'<define-CCF-group name="{kind}" model="{law.value}"><members>'
        + "".join(f'<basic-event name="{kind}{i}"/>' for i in range(count))
        + f'</members><distribution><float value="{q}"/></distribution>'
        f"<factors>{levels}</factors></define-CCF-group>"
        for kind in ("valve", "pump")
    )
    return (
        f'<opsa-mef><define-fault-tree name="t"><define-gate name="top"><and>{above}</and>'
        f"</define-gate>{gates}</define-fault-tree>{groups}</opsa-mef>"
    )


@pytest.mark.slow(but=3)
@pytest.mark.skipif(shutil.which("scram") is None, reason="SCRAM is not installed")
@pytest.mark.parametrize(
    ("count", "law", "factors"),
    [
        (2, BETA, (0.2,)),
        (3, BETA, (0.2,)),
        (3, MGL, (0.2, 0.1)),
        (3, ALPHA, (0.7, 0.2, 0.1)),
        (3, PHI, (0.7, 0.2, 0.1)),
        (4, MGL, (0.2, 0.1)),
        (4, ALPHA, (0.7, 0.2, 0.05, 0.05)),
        (6, MGL, (0.2, 0.1)),
    ],
)
def test_scram_agrees(tmp_path, count, law, factors):
    model = tmp_path / "model.xml"
    model.write_text(trains_xml(count, law, factors, 0.1))
    expanded, values = trains(count, law, factors, 0.1)
    assert expanded.tree.probability(values).p == pytest.approx(scram(model), rel=1e-5)


SHIPPED = Path("/usr/share/scram/input/TwoTrain/common_cause.xml")


@pytest.mark.skipif(
    shutil.which("scram") is None or not SHIPPED.exists(), reason="SCRAM is not installed"
)
def test_scram_agrees_on_its_own_two_trains():
    expanded, values = trains(2, BETA, (0.2,), 0.1)
    assert expanded.tree.probability(values).p == pytest.approx(scram(SHIPPED), rel=1e-5)


def test_shares_keep_the_complement_of_members_that_nearly_surely_fail():
    tree, units = pumps(2, 1)
    expanded = expand_common_cause(tree, [CommonCauseGroup("g", units, BETA, (0.25,))])
    sure = value_of(Probability(1.0, 1e-30))
    found = expanded.tree.probability(expanded.values({"pump": sure}))
    assert found.q == pytest.approx(0.25**2 * 0.75, rel=1e-15)
    nearly = expanded.values({"pump": 1.0 - 2.0**-52})
    assert {name: pair_of(value).q for name, value in nearly.items()} == {
        "pump {1 of 2}": 0.25 + 0.75 * 2.0**-52,
        "pump {2 of 2}": 0.75 + 0.25 * 2.0**-52,
    }
