"""Instances beside their components, and the assumed figures that a result hangs on."""

from dataclasses import replace

import pytest

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.values import computed_count, computed_probability, computed_redundancy
from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.model import Basis, Component, FailureFigure, Hardware
from tracerisk.common.hardware.redundancy import ALL_NEEDED
from tracerisk.common.hardware.sources import assumed_sources
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.text.paper import Paper
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.prm import solve
from tracerisk.prm.hybrid.from_blocks import build_model
from tracerisk.report.run_figures import run_figures
from tracerisk.report.tables import render_parts
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

PICK = FunctionRef("cell.py", QualifiedName("pick"))


def exposed(seconds: float) -> Exposure:
    return Exposure(moving_s=seconds, active_s=seconds, longest_moving_s=9, longest_active_s=9)


def trace_of(**seconds: float) -> Trace:
    exposures = {name: exposed(value) for name, value in seconds.items()}
    return Trace(
        controller="cell.py",
        robot="panda",
        scene="bench",
        end=RunEnd("ended", "returned", 1.0),
        elements=tuple(Element(name, "joint") for name in seconds),
        functions=(TracedFunction(PICK, 1, 1),),
        visits=(Visit(PICK, 0.0, 10.0, "succeeded", exposures),),
    )


@pytest.fixture
def figures(tmp_path):
    """Return the run's figures for a description's components and its trace."""

    def make(components: str, trace: Trace, top: str = "", by_hand: str | None = None):
        path = tmp_path / "hardware.yaml"
        path.write_text(f"{top}components:\n{components}")
        hardware = read_hardware(path)
        blocks = list(compute_blocks(trace, hardware, active="moving+holding").blocks.values())
        if by_hand is not None:
            blocks = [pinned(block, by_hand) for block in blocks]
        instances = compute_blocks(trace, hardware, active="moving+holding").instances
        assessment = solve(build_model(blocks, name="cell.py"))
        return assessment, run_figures(assessment, hardware, instances, blocks)

    return make


def pinned(block: RiskBlock, name: str) -> RiskBlock:
    entries = [
        replace(each, probability=replace(each.probability, pinned=True, computed="1e-9"))
        if each.name == name
        else each
        for each in block.components
    ]
    return replace(block, components=tuple(entries))


MOTOR = '  motor: {failure_rate: {value: 3.6e-3, per: hour}, twin: {joints: "*"}%s}\n'


def test_instances_share_the_importance_of_their_component(figures):
    power = "  power: {failure_rate: {value: 3.6e-3, per: hour}, active: always}\n"
    assessment, found = figures(MOTOR % "" + power, trace_of(one=1.0, two=4.0))
    # A rate of 1e-6 a second: the motors fail with 5e-6, the power with 1e-5.
    assert [each.instance.element for each in found.importances] == ["two", "one"]
    assert [each.share for each in found.importances] == pytest.approx([0.8, 0.2])
    shares = [each.fussell_vesely for each in found.importances]
    assert shares == pytest.approx([0.8 / 3, 0.2 / 3], rel=1e-4)
    motor = next(each for each in assessment.components if each.name == "motor")
    assert sum(shares) == pytest.approx(motor.fussell_vesely, rel=1e-9)


def test_the_importance_of_an_instance_is_the_fall_of_a_model_without_it(figures):
    # Of three motors two are needed: with one that never fails the model is another.
    components = MOTOR % ", required: 2"
    trace, without = trace_of(one=1e3, two=2e3, three=4e3), trace_of(one=1e3, two=0.0, three=4e3)
    whole, found = figures(components, trace)
    left, _ = figures(components, without)
    f, f0 = (each.mission.failure_probability for each in (whole, left))
    two = next(each for each in found.importances if each.instance.element == "two")
    # Importances of instances are those of hazards, which a probability follows while it is rare.
    assert two.fussell_vesely == pytest.approx((f - f0) / f, rel=0.01)


def test_the_table_shows_components_whose_instances_differ_and_no_others(figures):
    components = MOTOR % "" + MOTOR.replace("motor", "encoder") % ", redundancy: true"
    _, found = figures(components, trace_of(one=1.0, two=4.0))
    text = render_parts(found.tables())
    assert "Instances that differ" in text
    rows = [line.split() for line in text.splitlines()]
    assert ["motor", "two", "4.00e-06", "80", "%", "80", "%"] in rows
    assert max(map(len, text.splitlines())) <= 80
    _, alike = figures(components, trace_of(one=1.0, two=1.005))
    assert alike.tables() == []


def test_of_many_instances_the_greatest_are_shown_and_the_rest_counted(figures):
    _, found = figures(MOTOR % "", trace_of(**{f"j{number}": number for number in range(1, 13)}))
    text = render_parts(found.tables())
    assert "j12" in text
    assert "j5" in text
    assert " j4 " not in text
    assert "and 4 more" in text
    assert len(found.data({PICK: "pick"})["instances"]) == 12


def test_instances_as_data_have_their_probability_by_function(figures):
    _, found = figures(MOTOR % "", trace_of(one=1.0, two=4.0))
    first = found.data({PICK: "cell.pick"})["instances"][0]
    assert (first["component"], first["instance"], first["units"]) == ("motor", "two", 1)
    assert first["per_visit"] == {"cell.pick": pytest.approx(4e-6, rel=1e-5)}


def test_assumed_figures_are_listed_with_their_share_the_greatest_first(figures):
    components = (
        "  small: {failure_rate: {value: 1e-6, per: hour, source: assumed of its size}, "
        "active: always}\n"
        "  great: {failure_rate: {value: 2e-6, per: hour}, active: always, "
        "source: Assumed like a motor}\n"
        "  known: {failure_rate: {value: 1e-6, per: hour}, active: always, source: data sheet}\n"
    )
    _, found = figures(components, trace_of(one=1.0))
    assert [(each.component, each.source) for each in found.assumed] == [
        ("great", "Assumed like a motor"),
        ("small", "assumed of its size"),
    ]
    assert [each.fussell_vesely for each in found.assumed] == pytest.approx([0.5, 0.25], rel=1e-6)
    text = render_parts(found.tables())
    assert "Assumed figures that drive the result" in text
    assert "known" not in text


def test_what_nobody_assumed_or_a_person_set_is_not_listed(figures):
    components = "  power: {failure_rate: {value: 1e-6, per: hour}, active: always%s}\n"
    _, found = figures(components % "", trace_of(one=1.0))
    assert (found.assumed, found.tables()) == ((), [])
    assumed = components % ", source: assumed"
    _, found = figures(assumed, trace_of(one=1.0), by_hand="power")
    assert found.assumed == ()
    _, found = figures(assumed, trace_of(one=1.0))
    assert [each.component for each in found.assumed] == ["power"]


def test_the_source_of_a_description_is_that_of_figures_without_one(tmp_path):
    path = tmp_path / "hardware.yaml"
    path.write_text(
        "source: >-\n  assumed: round\n  numbers\ncomponents:\n"
        "  bare: {failure_rate: {value: 1e-6, per: hour}, active: always}\n"
        "  told: {failure_rate: {value: 1e-6, per: hour}, active: always, source: a data book}\n"
    )
    assert assumed_sources(read_hardware(path)) == {"bare": "assumed: round numbers"}


def test_figures_of_a_component_that_are_not_all_assumed_are_counted(tmp_path):
    path = tmp_path / "hardware.yaml"
    path.write_text(
        "source: a data book\ncomponents:\n  hand:\n    active: always\n    probability:\n"
        "      - {value: 1e-6, per: minute, source: assumed}\n      - {value: 1e-6, per: visit}\n"
    )
    words = "assumed (1 of its 2 figures; the share is that of all)"
    assert assumed_sources(read_hardware(path)) == {"hand": words}


def test_own_part_and_common_cause_of_a_component_count_together(figures):
    more = ", redundancy: true, common_cause: {beta: 0.1}, source: assumed"
    _, found = figures(MOTOR % more, trace_of(one=1.0, two=1.0))
    (assumed,) = found.assumed
    assert (assumed.component, assumed.fussell_vesely) == ("motor", pytest.approx(1.0, rel=1e-5))


def test_a_component_added_by_hand_has_no_assumed_figure(figures):
    entry = ComponentEntry(
        "tool",
        computed_probability(1e-9),
        computed_count(1),
        computed_redundancy(ALL_NEEDED),
        added=True,
    )
    block = RiskBlock("pick", computed_count(1), None, (entry,))
    assessment = solve(build_model([block], name="cell.py"))
    hardware_figures = run_figures(assessment, _assumed_tool(), (), [block])
    assert hardware_figures.assumed == ()


def _assumed_tool():
    figure = FailureFigure("failure_rate", 1e-6, Basis.HOUR)
    return Hardware("hardware.yaml", (Component("tool", (figure,), source="assumed"),))


@pytest.mark.parametrize("width", [60, 80, 110, 160])
def test_instances_of_long_names_and_sources_fit_every_terminal(figures, width):
    long = "left_arm_of_the_station_for_machine_tending_joint_"
    lines = "".join(
        MOTOR.replace("motor", f"{name}_{long}") % ", source: assumed as of its larger brother"
        for name in ("motor", "encoder", "brake")
    )
    seconds = {f"{long}{number}": float(number) for number in range(1, 13)}
    _, found = figures(lines, trace_of(**seconds))
    text = render_parts(found.tables(width), paper=Paper(width))
    assert max(map(len, text.splitlines())) <= width
    assert "\N{HORIZONTAL ELLIPSIS}" not in text
    shown = [line.split()[0] for line in text.splitlines() if line.strip().startswith("and ")]
    assert shown == ["and"] * len(shown)
    assert shown


def test_a_wide_terminal_has_the_instances_of_components_side_by_side(figures):
    components = MOTOR % "" + MOTOR.replace("motor", "encoder") % ""
    _, found = figures(components, trace_of(one=1.0, two=4.0))
    narrow, wide = (render_parts(found.tables(width), paper=Paper(width)) for width in (109, 110))
    assert not any("motor" in line and "encoder" in line for line in narrow.splitlines())
    assert "motor encoder" in " ".join(wide.split())
    row = next(line.split() for line in wide.splitlines() if line.startswith("two "))
    assert [word for word in row if word in ("two", "80", "4.00e-06")] == [
        "two",
        "4.00e-06",
        "80",
    ] * 2


def test_of_components_that_matter_less_fewer_instances_are_shown(figures):
    components = MOTOR % "" + MOTOR.replace("motor", "encoder").replace("3.6e-3", "3.6e-5") % ""
    _, found = figures(components, trace_of(**{f"j{number}": number for number in range(1, 7)}))
    text = render_parts(found.tables())
    motor, encoder = text.split("encoder")
    assert [each in motor for each in ("j6", "j1")] == [True, True]
    assert [each in encoder for each in ("j6", "j4", "j3", "and 3 more")] == [
        True,
        True,
        False,
        True,
    ]


def test_assumed_figures_that_drive_nothing_are_counted_only(figures):
    components = "".join(
        f"  {name}: {{failure_rate: {{value: {rate}, per: hour}}, active: always, "
        "source: assumed}\n"
        for name, rate in {"great": 1e-4, "small": 1e-10}.items()
    )
    _, found = figures(components, trace_of(one=1.0))
    text = render_parts(found.tables())
    assert "(1 of 2)" in text
    assert "small" not in text
