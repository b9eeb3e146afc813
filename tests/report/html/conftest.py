from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest
from lxml import html as lxml_html

from tracerisk.adder.blocks.override import Override
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.model import Basis, Component, FailureFigure, Hardware
from tracerisk.common.traced.elements import Contact, Element, Exposure, Payload
from tracerisk.common.verdict import Uncovered
from tracerisk.errors import Location
from tracerisk.prm import BasicEvent, FaultTree, HybridModel, solve
from tracerisk.prm.review.risk_diff import Review, RiskDiff
from tracerisk.report.html.report import render_report
from tracerisk.report.html.report_input import ReportInput, SourceBlock, SourceFile
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

HOSTILE = (
    "</script><script>window.pwned = 1</script>",
    "<!-- <img src=x onerror='window.pwned = 2'>",
    "\"' onmouseover='window.pwned = 3' \"",
    "]]></style><style>*{display:none}</style>",
    "{{ 7 * 7 }}{% raw %}",
    "&lt;b&gt; &amp; \u2028\u2029 \u202e",
    "javascript:window.pwned=4",
)
"""Texts that would do harm where one of them were read as anything but text."""


@pytest.fixture(scope="session")
def arm() -> HybridModel:
    """Two functions in a cycle, over three components of which one is a pair."""

    def units(component: str, count: int) -> dict[str, BasicEvent]:
        names = [f"{component}[{number}]" for number in range(1, count + 1)]
        return {name: BasicEvent(name, component) for name in names}

    pick = FaultTree.of(
        "pick fails",
        {"pick fails": ("or", "gripper", "power"), "power": ("and", "power[1]", "power[2]")},
        {"gripper": 7e-8, **units("power", 2)},
    )
    move = FaultTree.of(
        "move fails",
        {"move fails": ("or", "motor"), "motor": ("or", *(f"motor[{n}]" for n in range(1, 8)))},
        units("motor", 7),
    )
    return HybridModel.of(
        "arm.py",
        {"move": move, "pick": pick},
        {"move": "pick", "pick": {"move": Fraction(9, 10), "done": Fraction(1, 10)}},
        values={"power": 1e-4, "motor": 9e-8},
    )


@pytest.fixture(scope="session")
def report_of() -> Callable[..., ReportInput]:
    def make(model: HybridModel, **more: Any) -> ReportInput:
        return ReportInput(assessment=solve(model), model=model, **more)

    return make


@pytest.fixture(scope="session")
def parsed() -> Callable[[str], Any]:
    def parse(text: str) -> Any:
        return lxml_html.document_fromstring(text.encode("utf-8"))

    return parse


@pytest.fixture(scope="session")
def hostile() -> tuple[str, ...]:
    return HOSTILE


@pytest.fixture(scope="session")
def hostile_page() -> str:
    """A page whose every name and text is hostile."""
    texts = [text for text in HOSTILE if text.isprintable()]
    trees = {
        name: FaultTree.of(f"{name} fails", {f"{name} fails": ("or", part)}, {part: 1e-6})
        for name, part in zip(texts, reversed(texts), strict=True)
    }
    model = HybridModel.of("".join(texts), trees)
    place = Location(HOSTILE[0], 1)
    pins = tuple(Override("value", each, each, place, each, each, 3.0) for each in HOSTILE)
    blocks = tuple(SourceBlock(name, 1, 1, 1) for name in texts)
    sources = tuple(SourceFile(each, f"x = '''{each}'''\n# {each}", blocks) for each in HOSTILE)
    report = ReportInput(
        assessment=solve(model),
        model=model,
        sources=sources,
        pins=pins,
        no_trace=HOSTILE[0],
        findings=HOSTILE,
        assumptions=HOSTILE,
    )
    return render_report(report)


@pytest.fixture(scope="session")
def full_page(arm: HybridModel, eventful: RiskDiff, review_of: Callable[..., Review]) -> str:
    """A page that has every section, of a run that showed something of everything."""
    move, pick = (FunctionRef("arm.py", QualifiedName(name)) for name in ("move", "pick"))
    elements = (Element("joint1", "joint"), Element("hand", "gripper"))
    trace = Trace(
        controller="arm.py",
        robot="panda",
        scene="tube_racks",
        end=RunEnd("ended", "the controller ended", 12.5),
        elements=elements,
        functions=(TracedFunction(move, 1, 1), TracedFunction(pick, 9, 2)),
        visits=(
            Visit(move, 0.0, 5.0, "succeeded", {"joint1": Exposure(moving_s=4.0, active_s=5.0)}),
            Visit(
                pick,
                5.0,
                7.5,
                "succeeded",
                {"hand": Exposure(grasping_s=3.0, active_s=3.0)},
                payloads=(Payload("hand", "tube_1", 0.025, 3.0, 12.0, 20.0),),
                contacts=(
                    Contact("finger", "tube_1", 6.0, 3.0, 12.0, expected=True),
                    Contact("finger", "table", 6.5, 0.5, 140.0, expected=False),
                ),
            ),
        ),
        uncovered=(Uncovered(FunctionRef("arm.py", QualifiedName("park")), 40),),
    )
    source = "\n".join(
        ["def move(arm):", "    # | RiskAnnotation", "    arm.go('x')  # on", ""] * 9
    )
    figure = FailureFigure("probability", 9e-8, Basis.MINUTE, source="assumed, like a servo's")
    place = Location("arm.py", 2)
    return render_report(
        ReportInput(
            assessment=solve(arm),
            model=arm,
            sources=(
                SourceFile("arm.py", source, (SourceBlock("move", 1, 2, 2),)),
                SourceFile("more/tool.py", source, (SourceBlock("pick", 9, 10, 10),)),
            ),
            pins=(
                Override(
                    "value", "move.motor.probability", "2e-7", place, "1e-7", "FMEA-112", 100.0
                ),
                Override("value", "pick.next", "done 1", place),
            ),
            trace=trace,
            exposures={"move": {"motor": 5.0}, "pick": {"gripper": 3.0}},
            findings=("arm.py:3: the arm touched the table (at 3.20 s)",),
            assumptions=("robot: panda, inferred from the names in the controller's strings",),
            hardware=Hardware("hardware.yaml", (Component("motor", (figure,), 7),), "panda"),
            review=review_of(eventful, notes=("a note",)),
        )
    )
