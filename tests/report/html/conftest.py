from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from lxml import html as lxml_html

from tracerisk.errors import Location
from tracerisk.prm import FaultTree, HybridModel, solve
from tracerisk.report.html.report import render_report
from tracerisk.report.html.report_input import Pin, ReportInput, SourceBlock, SourceFile

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
    pick = FaultTree.of(
        "pick fails",
        {"pick fails": ("or", "gripper", "power"), "power": ("and", "power[1]", "power[2]")},
        {"gripper": 7e-8, "power[1]": 1e-4, "power[2]": 1e-4},
    )
    move = FaultTree.of(
        "move fails",
        {"move fails": ("or", "motor"), "motor": ("or", *(f"motor[{n}]" for n in range(1, 8)))},
        {f"motor[{n}]": 9e-8 for n in range(1, 8)},
    )
    return HybridModel.of(
        "arm.py",
        {"move": move, "pick": pick},
        {"move": "pick", "pick": {"move": Fraction(9, 10), "done": Fraction(1, 10)}},
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
def hostile_page() -> str:
    """A page whose every name and text is hostile."""
    texts = [text for text in HOSTILE if text.isprintable()]
    trees = {
        name: FaultTree.of(f"{name} fails", {f"{name} fails": ("or", part)}, {part: 1e-6})
        for name, part in zip(texts, reversed(texts), strict=True)
    }
    model = HybridModel.of("".join(texts), trees)
    place = Location(HOSTILE[0], 1)
    pins = tuple(Pin(each, each, each, each, 3.0, place) for each in HOSTILE)
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
def sample_report(tmp_path_factory: pytest.TempPathFactory, example_in: Any) -> Path:
    """The report of a small controller, made at the end of its run."""
    from tests.conftest import quick_controller

    example = example_in(tmp_path_factory.mktemp("report"))
    example.write(
        "controller.py",
        quick_controller().replace("    act(arm)\n", "    act(arm)\n    home(arm)\n"),
    )
    outcome = example.run("run", "controller.py", "--report", "out.html", "--quiet")
    assert outcome.code == 0, outcome.err
    return Path(example.folder / "out.html")
