"""Which part of the failure probability the replay puts on which element."""

import pytest

from tracerisk.adder.figures.instances import ComponentInstances, Instance
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.model import Basis, Component, FailureFigure
from tracerisk.prm import solve
from tracerisk.report.html.report_input import SourceBlock, SourceFile
from tracerisk.report.html.run.risk_shares import risk_data, shares_by_function
from tracerisk.report.run_figures import RunFigures

MOVE = FunctionRef("arm.py", QualifiedName("move"))


def test_shares_of_single_points_add_up_to_the_whole(arm):
    shares = shares_by_function(solve(arm))
    assert sum(shares.values()) == pytest.approx(1.0, rel=1e-3)
    # Seven motors of 9e-8 in one function, the gripper of 7e-8 and two of 1e-4 in the other.
    assert shares["move", "motor"] == pytest.approx(6.3e-7 / 7.1e-7, rel=1e-3)
    assert shares["pick", "gripper"] == pytest.approx(7e-8 / 7.1e-7, rel=1e-3)
    assert shares["pick", "power"] == pytest.approx(1e-8 / 7.1e-7, rel=1e-3)
    assert set(shares) == {("move", "motor"), ("pick", "gripper"), ("pick", "power")}


def test_elements_share_a_component_as_they_fail_in_the_function(arm, report_of):
    figure = FailureFigure("probability", 9e-8, Basis.MINUTE, source="own")
    motors = (
        Instance("joint1", 2, {MOVE: 1.5e-8}, 1.5e-7, 0.75, 0.75),
        Instance("joint2", 1, {MOVE: 1e-8}, 1e-7, 0.25, 0.25),
    )
    figures = RunFigures((ComponentInstances(Component("motor", (figure,), 2), motors),), (), ())
    report = report_of(arm, figures=figures, names={MOVE: "move"})
    rows = {(row[1], row[2]): row[3] for row in risk_data(report)["shares"]}
    assert rows["motor", "joint1"] == pytest.approx(3 * rows["motor", "joint2"], rel=1e-6)
    whole = shares_by_function(report.assessment)["move", "motor"]
    assert rows["motor", "joint1"] + rows["motor", "joint2"] == pytest.approx(whole, abs=1e-8)
    assert rows["gripper", None] > 0.0


def test_each_function_leads_to_its_block(arm, report_of):
    source = SourceFile("arm.py", "def move():\n    pass\n", (SourceBlock("move", 1, 2, 2),))
    assert risk_data(report_of(arm, sources=(source,)))["blocks"] == {
        "move": ["#source-1-2", "arm.py:2"]
    }
