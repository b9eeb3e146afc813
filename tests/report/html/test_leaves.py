"""The leaves of fault trees are the robot's units, and make what the model says."""

import math
from dataclasses import replace

import pytest

from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.prm import solve
from tracerisk.prm.hybrid.from_blocks import build_model
from tracerisk.report.html.model.leaves import leaves_of
from tracerisk.report.html.report import render_report
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.run_figures import run_figures
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

PICK = FunctionRef("cell.py", QualifiedName("pick"))
HARDWARE = """components:
  motor: {failure_rate: {value: 3.6e-3, per: hour}, twin: {joints: "*"}}
  power: {failure_rate: {value: 1e-3, per: hour}, quantity: 2, redundancy: true, active: always}
"""


def exposed(seconds: float) -> Exposure:
    return Exposure(
        moving_s=seconds, active_s=seconds, longest_moving_s=seconds, longest_active_s=seconds
    )


@pytest.fixture
def known_run(tmp_path):
    """Return the input of a report on a run in which two joints moved for unlike times."""

    def make(probability: str | None = None) -> ReportInput:
        trace = Trace(
            controller="cell.py",
            robot="panda",
            scene="bench",
            end=RunEnd("ended", "returned", 10.0),
            elements=(Element("shoulder", "joint"), Element("wrist", "joint")),
            functions=(TracedFunction(PICK, 1, 1),),
            visits=(
                Visit(
                    PICK, 0.0, 10.0, "succeeded", {"shoulder": exposed(9.0), "wrist": exposed(3.0)}
                ),
            ),
        )
        path = tmp_path / "hardware.yaml"
        path.write_text(HARDWARE)
        hardware = read_hardware(path)
        computed = compute_blocks(trace, hardware, active="moving+holding")
        blocks = list(computed.blocks.values())
        if probability is not None:
            blocks = [
                replace(
                    block,
                    components=tuple(
                        replace(
                            each,
                            probability=replace(
                                each.probability,
                                text=probability,
                                value=float(probability),
                                pinned=True,
                            ),
                        )
                        if each.name == "motor"
                        else each
                        for each in block.components
                    ),
                )
                for block in blocks
            ]
        model = build_model(blocks, name="cell.py")
        assessment = solve(model)
        return ReportInput(
            assessment=assessment,
            model=model,
            trace=trace,
            hardware=hardware,
            figures=run_figures(assessment, hardware, computed.instances, blocks),
            names=computed.names,
        )

    return make


def test_units_have_the_robots_names_and_their_own_figures(known_run):
    report = known_run()
    (state,) = report.model.states
    leaves = leaves_of(report, state)
    assert leaves.labels == {"motor[1]": "shoulder", "motor[2]": "wrist"}
    # 1e-6 a second, for nine and for three of them.
    assert leaves.figures["motor[1]"] == pytest.approx(9e-6, rel=1e-5)
    assert leaves.figures["motor[2]"] == pytest.approx(3e-6, rel=1e-5)
    whole = 1.0 - math.prod(1.0 - p for p in leaves.figures.values())
    model = 1.0 - (1.0 - state.probabilities["motor"]) ** 2
    # The block has four digits.
    assert whole == pytest.approx(model, rel=5e-4)


def test_the_page_draws_them_and_keeps_the_units_that_no_element_stands_for(known_run, parsed):
    (drawing,) = parsed(render_report(known_run())).xpath("//*[@id='fault-trees']//svg")
    names = drawing.xpath(".//g[contains(@class, 'event')]/text[@class='name']/text()")
    assert sorted(names) == ["power[1]", "power[2]", "shoulder", "wrist"]
    assert "9.000e-06" in drawing.xpath(".//text[@class='figure']/text()")


def test_a_figure_set_by_hand_stays_the_figure_of_every_unit(known_run, parsed):
    report = known_run("1e-3")
    (state,) = report.model.states
    leaves = leaves_of(report, state)
    assert (list(leaves.labels.values()), leaves.figures) == (["shoulder", "wrist"], {})
    assert leaves.notes == (
        "The units of motor are shown with the one figure that its block has for each; their own "
        "do not make the function's.",
    )
    page = parsed(render_report(report))
    assert leaves.notes[0] in page.xpath("//*[@id='fault-trees']")[0].text_content()
    figures = page.xpath("//*[@id='fault-trees']//svg//text[@class='figure']/text()")
    assert figures.count("0.001") == 2


def test_without_a_run_the_leaves_are_those_of_the_model(arm, report_of):
    report = report_of(arm)
    leaves = leaves_of(report, report.model.states[0])
    assert (leaves.labels, leaves.figures, leaves.label("motor[1]")) == ({}, {}, "motor[1]")
