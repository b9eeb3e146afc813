"""Error factors of a hardware description, in the uncertainty of a model of blocks."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.adder.quantify.evidence_shares import EvidenceShares
from tracerisk.api import build
from tracerisk.common.evidence.cells import Cell, Evidence
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.pipeline.failure_data.figure_spreads import hardware_spreads, with_distributions
from tracerisk.prm.hybrid.from_blocks import build_model
from tracerisk.prm.numbers.distributions import Lognormal
from tracerisk.prm.other_models.formats import linked_json
from tracerisk.prm.other_models.linked import linked
from tracerisk.prm.questions.uncertainty import propagate
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

PICK = FunctionRef("cell.py", QualifiedName("pick"))
SEEN = Exposure(moving_s=60.0, active_s=60.0, longest_moving_s=9, longest_active_s=9, starts=3,
                travel_s=6.0, wear=(1.5, 0.4, 0.1, 0.08, 0.02, 0.001, 1e-5))  # fmt: skip
TRACE = Trace(
    controller="cell.py",
    robot="panda",
    scene="bench",
    end=RunEnd("ended", "returned", 1.0),
    elements=(Element("one", "joint"), Element("two", "joint")),
    functions=(TracedFunction(PICK, 1, 1),),
    visits=(Visit(PICK, 0.0, 60.0, "succeeded", {"one": SEEN, "two": SEEN}),),
)
PER_MINUTE = "{value: 1e-6, per: minute, error_factor: 3}"
PER_DEMAND = "{value: 1e-6, per: demand, error_factor: 10, value_is: mean}"


@pytest.fixture
def modelled(tmp_path):
    """Return the model of a description's blocks, the description and the run's instances."""

    def make(text, evidence=None):
        path = tmp_path / "hardware.yaml"
        path.write_text("components:\n" + text)
        hardware = read_hardware(path)
        computed = compute_blocks(TRACE, hardware, active="moving+holding", evidence=evidence)
        blocks = list(computed.blocks.values())
        return build_model(blocks, name="cell.py"), hardware, computed.instances

    return make


def motor(figures: str, more: str = "") -> str:
    return f'  motor: {{probability: {figures}, twin: {{joints: "*"}}{more}}}\n'


def test_one_figure_is_the_component_and_spreads_the_mission_as_its_lognormal(modelled):
    model, hardware, instances = modelled(motor(PER_MINUTE))
    spreads = hardware_spreads(model, hardware, instances)
    assert spreads.notes == ()
    found = propagate(model, samples=4000, figures=spreads.figures)
    # Two motors, each needed; rare failures follow the factor.
    assert found.percentiles == pytest.approx([2e-6 / 3, 2e-6, 6e-6], rel=0.01)
    assert [each.name for each in found.inputs] == ["motor"]


def test_several_figures_are_drawn_each_by_itself_with_the_part_that_the_run_says(modelled):
    model, hardware, instances = modelled(motor(f"[{PER_MINUTE}, {PER_DEMAND}]"))
    # One minute against three demands.
    assert instances[0].figure_shares == pytest.approx((0.25, 0.75), rel=1e-5)
    spreads = hardware_spreads(model, hardware, instances)
    found = propagate(model, samples=4000, figures=spreads.figures)
    assert {each.name for each in found.inputs} == {
        "motor: probability per minute",
        "motor: probability per demand",
    }
    rng = np.random.default_rng(3)
    z = rng.standard_normal((2, 400_000))
    low, high = Lognormal(3.0).sigma, Lognormal(10.0).sigma
    drawn = 2e-6 * np.exp(low * z[0]) + 6e-6 * np.exp(high * z[1] - high**2 / 2)
    assert found.percentiles == pytest.approx(np.percentile(drawn, (5, 50, 95)), rel=0.03)


def test_what_has_no_error_factor_is_certain(modelled):
    text = motor(f"[{PER_MINUTE}, {{value: 1e-6, per: demand}}]")
    model, hardware, instances = modelled(text)
    found = propagate(model, figures=hardware_spreads(model, hardware, instances).figures)
    assert found.percentiles == pytest.approx([2e-6 / 3 + 6e-6, 8e-6, 6e-6 + 6e-6], rel=0.01)


def test_without_a_run_all_of_several_figures_is_off_by_the_widest_factor(modelled):
    model, hardware, _ = modelled(motor(f"[{PER_MINUTE}, {PER_DEMAND}]"))
    spreads = hardware_spreads(model, hardware)
    (figure,) = spreads.figures["motor"]
    assert (figure.share, figure.distribution) == (1.0, Lognormal(10.0, "mean"))
    assert spreads.notes == (
        "motor: only a run shows which part each of its 2 figures has; here all of it is off by the "
        "widest error factor, 10",
    )


def test_units_and_their_common_cause_have_one_draw(modelled):
    model, hardware, _ = modelled(
        motor(PER_MINUTE, ", redundancy: true, common_cause: {beta: 0.1}")
    )
    found = propagate(model, samples=4000, figures=hardware_spreads(model, hardware).figures)
    assert found.percentiles == pytest.approx([1e-7 / 3, 1e-7, 3e-7], rel=0.01)


def test_units_of_a_group_with_spares_have_their_factor(modelled):
    model, hardware, instances = modelled(motor(PER_MINUTE, ", spare: cold"))
    spreads = hardware_spreads(model, hardware, instances)
    assert list(spreads.figures) == ["motor"]
    found = propagate(model, samples=4000, figures=spreads.figures)
    # A cold pair fails with half the square of its unit.
    assert found.percentiles == pytest.approx(
        [found.point / 9, found.point, found.point * 9], rel=0.02
    )


def test_groups_with_spares_that_are_renewed_are_left_out_and_reported(modelled):
    text = motor(PER_MINUTE, ", spare: cold, detected: each_visit") + (
        f"  power: {{probability: {PER_MINUTE}, active: always}}\n"
    )
    model, hardware, instances = modelled(text)
    spreads = hardware_spreads(model, hardware, instances)
    assert list(spreads.figures) == ["power"]
    assert spreads.notes == (
        "motor: the error factors of a group with spares detected at each visit are left out, for "
        "its figure in the model is that of the group",
    )


def test_a_value_set_by_hand_has_no_error_factor_of_the_description(modelled):
    model, hardware, _ = modelled(motor(PER_MINUTE))
    assert hardware_spreads(model, hardware, by_hand=["motor"]).figures == {}


def test_alike_figures_are_numbered(modelled):
    model, hardware, instances = modelled(motor(f"[{PER_MINUTE}, {PER_MINUTE}]"))
    names = [each.name for each in hardware_spreads(model, hardware, instances).figures["motor"]]
    assert names == ["probability per minute (1)", "probability per minute (2)"]


def test_a_model_holds_one_distribution_a_component_of_the_same_variance(modelled):
    model, hardware, instances = modelled(motor(f"[{PER_MINUTE}, {PER_DEMAND}]"))
    spreads = hardware_spreads(model, hardware, instances)
    (parameter,) = with_distributions(model, spreads.figures).parameters
    law = parameter.distribution
    assert isinstance(law, Lognormal)
    low, high = Lognormal(3.0), Lognormal(10.0, "mean")
    means = 0.25 * math.exp(low.sigma**2 / 2), 0.75
    variances = [
        mean**2 * math.expm1(each.sigma**2) for mean, each in zip(means, (low, high), strict=True)
    ]
    relative = sum(variances) / sum(means) ** 2
    assert math.expm1(law.sigma**2) == pytest.approx(relative, rel=1e-4)
    model, hardware, instances = modelled(motor(PER_DEMAND))
    spreads = hardware_spreads(model, hardware, instances)
    (parameter,) = with_distributions(model, spreads.figures).parameters
    assert parameter.distribution == Lognormal(10.0, "mean")


HARDWARE = """\
robot: panda
components:
  electric_motor:
    probability:
      - {value: 9.5e-08, per: minute, error_factor: 3}
      - {value: 1.0e-10, per: demand, error_factor: 10}
    quantity: 7
    twin: {joints: "*"}
"""


@pytest.fixture
def sample(short_run, example):
    run, _ = short_run
    for name, data in run.files().items():
        example.write(name, data)
    folder = run.folder / ".tracerisk_cache"
    (example.folder / ".tracerisk_cache").mkdir(exist_ok=True)
    for path in folder.iterdir():
        (example.folder / ".tracerisk_cache" / path.name).write_bytes(path.read_bytes())
    example.write("hardware.yaml", HARDWARE)
    return example


def inputs(outcome):
    return {each["name"] for each in json.loads(outcome.out)["uncertainty"]["inputs"]}


def test_solve_draws_the_figures_of_a_description(sample):
    asked = ("--hardware", "hardware.yaml", "--uncertainty", "--samples", "200", "--json")
    outcome = sample.run("solve", "pick_and_place.py", *asked)
    assert outcome.code == 0, outcome.err
    assert inputs(outcome) == {
        "electric_motor: probability per minute",
        "electric_motor: probability per demand",
    }
    own = sample.run("solve", "pick_and_place.py", *asked, "--error-factor", "electric_motor=2")
    assert inputs(own) == {"electric_motor"}


def test_build_keeps_the_spread_in_the_model(sample):
    built = sample.run(
        "build", "pick_and_place.py", "--hardware", "hardware.yaml", "-o", "model.json"
    )
    assert built.code == 0, built.err
    held = {
        each["name"]: each.get("distribution")
        for each in json.loads(sample.read("model.json"))["parameters"]
    }
    assert held["electric_motor"]["lognormal"]["errorFactor"] == pytest.approx(3.0, rel=0.2)
    assert held["gripper"] is None
    outcome = sample.run("solve", "model.json", "--uncertainty", "--samples", "200", "--json")
    assert inputs(outcome) == {"electric_motor"}


def test_build_says_that_a_model_file_has_no_lots(sample):
    sample.write("hardware.yaml", HARDWARE.replace("motor:", "motor:\n    lot: A"))
    built = sample.run(
        "build", "pick_and_place.py", "--hardware", "hardware.yaml", "-o", "model.json"
    )
    assert built.code == 0, built.err
    assert "lots are left out (A): in a model file each component is off by itself" in built.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("solve", "pick_and_place.py"), "--hardware goes with --uncertainty; add it"),
        (("solve", "linked.json", "--uncertainty"), "--hardware goes with models of functions"),
        (("solve", "tree.xml", "--uncertainty"), "--hardware goes with models of functions"),
    ],
)
def test_a_description_without_use_is_an_error(example, arguments, message):
    example.write("pick_and_place.py", SOURCE)
    model = build({"place.py": SOURCE.encode()}, name="place")
    example.write("linked.json", linked_json.dumps(linked(model)))
    example.write("tree.xml", "<opsa-mef/>")
    example.write("hardware.yaml", HARDWARE)
    outcome = example.run(*arguments, "--hardware", "hardware.yaml")
    assert outcome.code == 2
    assert message in outcome.err


def test_a_description_without_error_factors_is_an_error(example):
    example.write("pick_and_place.py", SOURCE)
    example.write("hardware.yaml", HARDWARE.replace("electric_motor", "another"))
    outcome = example.run(
        "solve", "pick_and_place.py", "--uncertainty", "--hardware", "hardware.yaml"
    )
    assert outcome.code == 2
    assert "hardware.yaml: has no error factor for a component of the model" in outcome.err


SOURCE = """\
def place():
    # | RiskAnnotation
    # | @Function {
    # |   name = place
    # |   callSequence = 1
    # |   next = done 1
    # | }
    # | @Component {
    # |   name = electric_motor
    # |   probability = 1e-8
    # |   quantity = 7
    # |   redundancy = false
    # | }
    pass
"""


def shown(failed):
    """Evidence of twenty failures a motor, of which so many end the mission."""
    cells = []
    for unit, number in failed.items():
        for index in range(20):
            at = 1.5 + 3.0 * index
            stood_for = Exposure(moving_s=3.0, active_s=3.0)
            cell = Cell("motor", unit, "dead", at, "moving", "pick", True, at, (at, 0.0, 0.0))
            cells.append(replace(cell, stretch=stood_for, fails=index < number))
    return EvidenceShares(Evidence("f", "panda", 0, 40, ("done",), tuple(cells)))


@pytest.mark.parametrize("figures", ["{value: 1e-6, per: minute}", PER_MINUTE])
def test_what_few_failures_say_of_the_share_that_ends_the_mission_is_uncertain(modelled, figures):
    model, hardware, instances = modelled(motor(figures), shown({"one": 9, "two": 3}))
    assert instances[0].ending.share == pytest.approx(0.3)
    assert instances[0].ending.cells == pytest.approx(40.0)
    found = propagate(
        model, samples=4000, figures=hardware_spreads(model, hardware, instances).figures
    )
    assert found.point == pytest.approx(6e-7, rel=1e-5)
    rng = np.random.default_rng(3)
    drawn = 2e-6 * rng.beta(12.5, 28.5, 400_000)
    if "error_factor" in figures:
        drawn *= np.exp(Lognormal(3.0).sigma * rng.standard_normal(400_000))
    assert found.percentiles == pytest.approx(np.percentile(drawn, (5, 50, 95)), rel=0.02)
    assert "motor: share that ends the mission" in {each.name for each in found.inputs}
    given = with_distributions(model, hardware_spreads(model, hardware, instances).figures)
    again = propagate(given, samples=4000)
    assert again.percentiles == pytest.approx(np.percentile(drawn, (5, 50, 95)), rel=0.1)


@pytest.mark.parametrize(("share", "own"), [(1.0, 1.0), (0.5, 1.0), (1.0, 3.0)])
def test_masses_on_which_sources_disagree_widen_what_wears_by_load(modelled, share, own):
    factor = f", error_factor: {own:g}" if own > 1.0 else ""
    law = f"{{reference_load: 0.25, wearing_share: {share}, exponent: 3}}"
    model, hardware, instances = modelled(
        motor(f"{{value: 1e-6, per: minute{factor}}}", f", load_law: {law}")
    )
    spreads = hardware_spreads(model, hardware, instances, load_factor=1.25)
    (spread,) = spreads.figures["motor"]
    by_load = math.log(1.0 - share + share * 1.25**3)
    expected = math.exp(math.hypot(by_load, math.log(own)))
    assert spread.distribution.error_factor == pytest.approx(expected)


def test_masses_widen_nothing_that_has_no_load_law(modelled):
    model, hardware, instances = modelled(motor(PER_MINUTE))
    plain = hardware_spreads(model, hardware, instances)
    assert hardware_spreads(model, hardware, instances, load_factor=2.0) == plain


def test_what_few_failures_say_of_what_follows_them_is_uncertain_too(modelled):
    seen = shown({"one": 8, "two": 8}).evidence
    fates = ("stopped_safely", "unaware", "stopped_safely", "stopped_late")
    cells = [
        replace(cell, fate=fates[index % 4] if cell.fails else "carried_out")
        for index, cell in enumerate(seen.cells)
    ]
    found = EvidenceShares(replace(seen, cells=tuple(cells)))
    model, hardware, instances = modelled(motor("{value: 1e-6, per: minute}"), found)
    spreads = hardware_spreads(model, hardware, instances)
    assert spreads.outcomes == {"motor": pytest.approx(16.0)}
    drawn = propagate(model, samples=4000, figures=spreads.figures, outcomes=spreads.outcomes)
    rng = np.random.default_rng(3)
    undetected = 2e-6 * rng.beta(16.5, 24.5, 400_000) * rng.beta(9.0, 8.5, 400_000)
    assert drawn.undetected == pytest.approx(np.percentile(undetected, (5, 50, 95)), rel=0.03)
    names = {item.name for item in drawn.undetected_inputs}
    assert "motor: share of its failures that nobody notices" in names
    certain = hardware_spreads(model, hardware, instances, outcomes_by_hand=["motor"])
    assert certain.outcomes == {}
    assert certain.figures == spreads.figures


def joined(first: float, second: float, lots: tuple[str, str]) -> str:
    """Two components of one figure each, as likely to fail, with their error factors and lots."""
    return "".join(
        f"  c{number}: {{failure_rate: {{value: 1e-4, per: hour, error_factor: {factor}}}, "
        f"active: always{f', lot: {lot}' if lot else ''}}}\n"
        for number, (factor, lot) in enumerate(zip((first, second), lots, strict=True))
    )


@pytest.mark.parametrize(("first", "second"), [(5.0, 5.0), (3.0, 8.0)])
def test_components_of_one_lot_are_off_together(modelled, first, second):
    """The percentiles of a sum of figures of one lot are the sums of their percentiles."""

    def spread(lots):
        model, hardware, instances = modelled(joined(first, second, lots))
        figures = hardware_spreads(model, hardware, instances).figures
        return propagate(model, samples=40_000, seed=1, figures=figures)

    one = 1e-4 / 60
    together, apart = spread(("A", "A")), spread(("A", "B"))
    by_hand = (one / first + one / second, 2 * one, one * first + one * second)
    assert together.percentiles == pytest.approx(by_hand, rel=2e-3)
    assert apart.percentiles[2] < 0.9 * together.percentiles[2]
    assert apart.percentiles == spread(("", "")).percentiles
    # Each keeps its own mean, and so has the sum; its deviation is that of sums that move alike.
    sigmas = [math.log(factor) / 1.6448536269514722 for factor in (first, second)]
    means = [one * math.exp(sigma**2 / 2) for sigma in sigmas]
    variance = sum(
        m * n * math.expm1(s * t)
        for m, s in zip(means, sigmas, strict=True)
        for n, t in zip(means, sigmas, strict=True)
    )
    assert together.mean == pytest.approx(sum(means), rel=5e-3)
    assert together.deviation == pytest.approx(math.sqrt(variance), rel=0.05)
    (row,) = together.inputs
    assert (row.name, row.value) == ("lot A", 1.0)
    assert row.share == pytest.approx(1.0, abs=0.01)
    assert row.percentiles[2] == pytest.approx(max(first, second), rel=2e-3)


@pytest.mark.parametrize("figure_factor", [None, 2.0])
def test_the_use_of_a_component_may_be_off_beside_its_figures(modelled, figure_factor):
    """All figures of a component are multiplied by one lognormal factor of median 1."""
    own = f", error_factor: {figure_factor}" if figure_factor else ""
    model, hardware, instances = modelled(
        f"  motor: {{failure_rate: {{value: 1e-4, per: hour{own}}}, active: always, "
        "exposure_error_factor: 4}\n"
    )
    spreads = hardware_spreads(model, hardware, instances).figures
    spread = propagate(model, samples=40_000, seed=1, figures=spreads)
    one = 1e-4 / 60
    factor = math.exp(math.hypot(math.log(4.0), math.log(figure_factor or 1.0)))
    assert spread.percentiles == pytest.approx((one / factor, one, one * factor), rel=0.02)
    rows = {row.name: row for row in spread.inputs}
    assert set(rows) == {"motor: use", *(["motor"] if figure_factor else [])}
    assert rows["motor: use"].cut == 0
    assert rows["motor: use"].percentiles == pytest.approx((0.25, 1.0, 4.0), rel=2e-3)
    law = with_distributions(model, spreads).parameters[0].distribution
    assert isinstance(law, Lognormal)
    assert law.error_factor == pytest.approx(factor, rel=1e-12)


def test_the_use_is_that_of_all_figures_of_a_component(modelled):
    figures = "[{value: 1e-6, per: minute}, {value: 1e-6, per: demand, of: start}]"
    model, hardware, instances = modelled(motor(figures, ", exposure_error_factor: 4"))
    spread = propagate(
        model, samples=40_000, seed=1, figures=hardware_spreads(model, hardware, instances).figures
    )
    # Both together are off by 4; apart they would be by less.
    assert spread.percentiles[2] / spread.percentiles[1] == pytest.approx(4.0, rel=2e-3)
    assert [row.name for row in spread.inputs] == ["motor: use"]
