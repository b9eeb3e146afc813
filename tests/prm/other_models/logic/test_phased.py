"""Missions of phases, against sums over the phases in which each event occurs."""

import itertools
import random

import pytest

from tests.slow import slow_but_every
from tests.storm import of_gates, storm_probability
from tracerisk.errors import ModelError
from tracerisk.prm.other_models.formats.open_psa import loads_open_psa
from tracerisk.prm.other_models.logic.phased import phased_probability

mpmath = pytest.importorskip("mpmath", reason="mpmath gives the exact figures")

HOURS = 50.0


def model_of(gates, events, phases):
    """Read a model from Open-PSA text; a phase has a fraction and the house events that are on."""
    houses = sorted({house for _, on in phases for house in on} | {"h0", "h1"})
    text = ["<opsa-mef><define-fault-tree name='t'>"]
    kinds = {"event": "basic-event", "house": "house-event", "gate": "gate"}
    for name, (kind, k, inputs) in gates.items():
        least = f" min='{k}'" if kind == "atleast" else ""
        below = "".join(f"<{kinds[what]} name='{of}'/>" for what, of in inputs)
        text.append(f"<define-gate name='{name}'><{kind}{least}>{below}</{kind}></define-gate>")
    text.append("</define-fault-tree><model-data>")
    for name, law in events.items():
        text.append(f"<define-basic-event name='{name}'>{law}</define-basic-event>")
    text += [
        f"<define-house-event name='{house}'><constant value='false'/></define-house-event>"
        for house in houses
    ]
    text.append("</model-data><define-alignment name='m'>")
    for number, (fraction, on) in enumerate(phases):
        text.append(f"<define-phase name='p{number}' time-fraction='{fraction!r}'>")
        for house in houses:
            state = "true" if house in on else "false"
            text.append(
                f"<set-house-event name='{house}'><constant value='{state}'/></set-house-event>"
            )
        text.append("</define-phase>")
    return loads_open_psa("".join([*text, "</define-alignment></opsa-mef>"]), "m.xml")


def exponential(rate):
    return f"<exponential><float value='{rate!r}'/><system-mission-time/></exponential>"


def glm(at_start, rate, repair):
    figures = "".join(f"<float value='{figure!r}'/>" for figure in (at_start, rate, repair))
    return f"<GLM>{figures}<system-mission-time/></GLM>"


def drawn(rng):
    names = [f"e{number}" for number in range(rng.randint(1, 4))]
    rates = {name: rng.choice([None, 10.0 ** rng.uniform(-6, -1)]) for name in names}
    laws = {
        name: f"<float value='{0.01!r}'/>" if rate is None else exponential(rate)
        for name, rate in rates.items()
    }
    gates = {}
    leaves = [("event", name) for name in names] + [("house", "h0"), ("house", "h1")]
    for name in ("g0", "g1"):
        inputs = rng.sample(leaves, rng.randint(2, len(leaves)))
        gates[name] = (rng.choice(["and", "or", "atleast"]), rng.randint(1, len(inputs)), inputs)
    inputs = [("gate", "g0"), ("gate", "g1"), ("event", rng.choice(names))]
    gates["top"] = (rng.choice(["and", "or", "atleast"]), 2, inputs)
    cuts = sorted(rng.randint(1, 7) / 8 for _ in range(rng.randint(0, 2)))
    ends = [*dict.fromkeys(cuts), 1.0]
    fractions = [end - begin for begin, end in itertools.pairwise([0.0, *ends])]
    phases = [
        (fraction, [house for house in ("h0", "h1") if rng.random() < 0.5])
        for fraction in fractions
    ]
    return gates, rates, laws, phases, ends


def happens(gates, name, true):
    kind, k, inputs = gates[name]
    count = sum(happens(gates, of, true) if what == "gate" else of in true for what, of in inputs)
    return count >= {"and": len(inputs), "or": 1, "atleast": k}[kind]


def exact(gates, rates, phases, ends):
    """Sum over all phases in which each event may occur, the last for none at all."""
    total = mpmath.mpf(0)
    names = list(rates)
    with mpmath.workdps(40):
        chances = {}
        for name, rate in rates.items():
            if rate is None:
                by = [mpmath.mpf(0.01)] * len(ends)
            else:
                by = [-mpmath.expm1(-mpmath.mpf(rate) * HOURS * end) for end in ends]
            chances[name] = [now - before for before, now in itertools.pairwise([0, *by, 1])]
        for when in itertools.product(range(len(ends) + 1), repeat=len(names)):
            if any(
                happens(
                    gates, "top", {n for n, at in zip(names, when, strict=True) if at <= j} | {*on}
                )
                for j, (_, on) in enumerate(phases)
            ):
                total += mpmath.fprod(chances[n][at] for n, at in zip(names, when, strict=True))
    return total


@pytest.mark.parametrize("seed", slow_but_every(20, range(1000)))
def test_random_missions_are_sums_over_the_phases_in_which_events_occur(seed):
    gates, rates, laws, phases, ends = drawn(random.Random(seed))
    model = model_of(gates, laws, phases)
    found = phased_probability(model, model.alignments[0], "top", HOURS)
    share = exact(gates, rates, phases, ends)
    with mpmath.workdps(40):
        rest = float(1 - share)
    assert found.p == pytest.approx(float(share), rel=1e-12, abs=1e-35)
    assert found.q == pytest.approx(rest, rel=1e-12, abs=1e-35)


def program(gates, rates, phases, ends):
    """The mission as a chain of PRISM that goes from phase to phase: `k` of them have begun."""
    text = ["dtmc", "module mission", f"k : [0..{len(phases)}] init 0;"]
    text += [f"[go] k<{len(phases)} & !failed -> (k'=k+1);", "endmodule"]
    for name, rate in rates.items():
        text += [f"module {name}", f"x{name} : bool init false;", f"[go] x{name} -> true;"]
        before = mpmath.mpf(0)
        for number, end in enumerate(ends):
            now = 0.01 if rate is None else -mpmath.expm1(-mpmath.mpf(rate) * HOURS * end)
            p = as_text((now - before) / (1 - before))
            text.append(f"[go] !x{name} & k={number} -> {p} : (x{name}'=true) + 1-{p} : true;")
            before = now
        text.append("endmodule")
    shapes = {
        name: (kind, k, [below for _, below in inputs]) for name, (kind, k, inputs) in gates.items()
    }
    tops = []
    for number, (_, on) in enumerate(phases, 1):
        leaves = {name: f"x{name}" for name in rates}
        leaves |= {house: str(house in on).lower() for house in ("h0", "h1")}
        tops.append(f"k={number} & {of_gates(shapes, 'top', leaves)}")
    text += [f"formula failed = {' | '.join(tops)};", 'label "failed" = failed;']
    return "\n".join(text)


def as_text(number):
    """A number of mpmath in the 40 digits that it has, which Storm reads as a fraction."""
    return mpmath.nstr(number, 40, min_fixed=-100, max_fixed=100)


@pytest.mark.parametrize("seed", slow_but_every(50, range(1000)))
def test_storm_finds_the_same_exactly(seed, tmp_path):
    gates, rates, laws, phases, ends = drawn(random.Random(seed))
    model = model_of(gates, laws, phases)
    found = phased_probability(model, model.alignments[0], "top", HOURS)
    with mpmath.workdps(40):
        text = program(gates, rates, phases, ends)
    exactly = storm_probability(tmp_path / "m.prism", text, 'P=? [F "failed"]')
    assert found.p == pytest.approx(float(exactly), rel=1e-12, abs=1e-35)
    assert found.q == pytest.approx(float(1 - exactly), rel=1e-12, abs=1e-35)


def exact_with_repair(gates, laws, phases, ends):
    """The top in any phase, by all sets of failed events: what fails the mission is not left."""
    names = list(laws)
    sets = [
        {name for number, name in enumerate(names) if bits >> number & 1}
        for bits in range(2 ** len(names))
    ]
    share = mpmath.matrix(1, len(sets))
    for bits, failed in enumerate(sets):
        share[0, bits] = mpmath.fprod(
            at_start if name in failed else 1 - at_start
            for name, (at_start, _, _) in ((n, map(mpmath.mpf, laws[n])) for n in names)
        )
    lost = mpmath.mpf(0)
    begin = 0.0
    for (_, on), end in zip(phases, ends, strict=True):
        generator = mpmath.matrix(len(sets), len(sets))
        is_lost = [happens(gates, "top", failed | {*on}) for failed in sets]
        for bits, failed in enumerate(sets):
            for number, name in enumerate(names):
                way = mpmath.mpf(laws[name][2 if name in failed else 1])
                if not is_lost[bits]:
                    generator[bits, bits ^ 1 << number] += way
                    generator[bits, bits] -= way
        share = share * mpmath.expm(generator * (end - begin) * HOURS, method="taylor")
        for bits, gone in enumerate(is_lost):
            if gone:
                lost += share[0, bits]
                share[0, bits] = 0
        begin = end
    return lost, mpmath.fsum(share)


@pytest.mark.slow(but=10)
@pytest.mark.parametrize("seed", slow_but_every(50, range(1000)))
def test_random_missions_with_repair_are_those_of_all_sets_of_failed_events(seed):
    rng = random.Random(seed)
    gates, rates, _, phases, ends = drawn(rng)
    figures = {}
    for name, rate in rates.items():
        repair = rng.choice([0.0, 10.0 ** rng.uniform(-4, -0.5)])
        figures[name] = (rng.choice([0.0, 0.1]), rate or 0.0, repair)
    figures["e0"] = (*figures["e0"][:2], 0.1)
    model = model_of(gates, {n: glm(*law) for n, law in figures.items()}, phases)
    found = phased_probability(model, model.alignments[0], "top", HOURS)
    with mpmath.workdps(40):
        lost, kept = map(float, exact_with_repair(gates, figures, phases, ends))
    assert found.p == pytest.approx(lost, rel=1e-11, abs=1e-35)
    assert found.q == pytest.approx(kept, rel=1e-11, abs=1e-35)


def test_cutting_a_phase_in_two_changes_nothing():
    gates = {"top": ("and", 1, [("event", "a"), ("event", "b")])}
    laws = {name: exponential(0.01) for name in "ab"}
    whole = model_of(gates, laws, [(1.0, [])])
    parts = model_of(gates, laws, [(0.25, []), (0.75, [])])
    one, other = (
        phased_probability(model, model.alignments[0], "top", HOURS) for model in (whole, parts)
    )
    assert one == pytest.approx(other, rel=1e-14)
    assert one == pytest.approx(
        whole.fault_tree("top").probability({"a": one.p**0.5, "b": one.p**0.5})
    )


def test_a_failure_is_carried_into_the_phase_that_needs_the_unit():
    # In the first phase nothing is needed (both house events off), in the second the unit is.
    gates = {"top": ("and", 1, [("event", "a"), ("house", "h0")])}
    model = model_of(gates, {"a": exponential(0.01)}, [(0.8, []), (0.2, ["h0"])])
    found = phased_probability(model, model.alignments[0], "top", HOURS)
    assert found.p == pytest.approx(float(-mpmath.expm1(-0.01 * HOURS)), rel=1e-14)


@pytest.mark.parametrize(
    ("gates", "law", "message"),
    [
        (
            {"top": ("nor", 1, [("event", "a"), ("house", "h0")])},
            exponential(0.1),
            "gate 'top': nor is not coherent",
        ),
        (
            {"top": ("or", 1, [("event", "a"), ("house", "h0")])},
            f"<add><float value='0.1'/>{glm(0.0, 0.1, 1.0)}</add>",
            "event 'a' is tested, or repaired at no constant rate, and may have happened in one",
        ),
        (
            {"top": ("or", 1, [("event", "a"), ("house", "h0")])},
            f"<sub><float value='1'/>{exponential(0.1)}</sub>",
            "event 'a': its probability falls from",
        ),
    ],
)
def test_what_has_no_figure_of_all_phases_says_so(gates, law, message):
    model = model_of(gates, {"a": law}, [(0.5, []), (0.5, ["h0"])])
    with pytest.raises(ModelError, match=message):
        phased_probability(model, model.alignments[0], "top", HOURS)
