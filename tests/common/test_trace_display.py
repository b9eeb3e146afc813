"""A trace shows itself in a notebook."""

import subprocess
import sys
from dataclasses import replace

import pytest
from lxml import html

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit


def trace_of(*visits, elements=("joint1", "hand"), end_s=10.0):
    """A trace of visits told as `(function, start, seconds, {element: seconds in use})`."""
    refs = {name: FunctionRef("arm.py", QualifiedName(name)) for name, *_ in visits}

    def exposure(seconds):
        return None if seconds is None else Exposure(moving_s=seconds, active_s=seconds)

    return Trace(
        controller="arm.py",
        robot="panda",
        scene="tube_racks",
        end=RunEnd("ended", "the controller ended", end_s),
        elements=tuple(Element(name, "joint") for name in elements),
        functions=tuple(TracedFunction(ref, 1, n) for n, ref in enumerate(refs.values(), start=1)),
        visits=tuple(
            Visit(
                refs[name],
                start,
                seconds,
                "succeeded",
                {element: exposure(used) for element, used in exposures.items()},
            )
            for name, start, seconds, exposures in visits
        ),
    )


ERRAND = trace_of(
    ("move", 0.0, 4.0, {"joint1": 3.0}),
    ("pick", 4.0, 2.0, {"joint1": 0.5, "hand": 2.0}),
    ("move", 6.0, 4.0, {"joint1": 3.25}),
)


def rows(page):
    return [[cell.text_content() for cell in row.xpath("./th|./td")] for row in page.xpath(".//tr")]


def shown(trace):
    return html.fragment_fromstring(trace._repr_html_())


def test_functions_are_shown_with_the_seconds_of_each_element():
    assert rows(shown(ERRAND)) == [
        ["function", "visits", "seconds", "joint1", "hand"],
        ["move", "2", "8.00", "6.25", ""],
        ["pick", "1", "2.00", "0.50", "2.00"],
    ]


def test_each_visit_is_a_bar_where_and_as_long_as_it_was():
    _, *bars = shown(ERRAND).xpath(".//rect")
    x, width = ([float(bar.get(name)) for bar in bars] for name in ("x", "width"))
    assert [bar.xpath("string(title)") for bar in bars][1] == (
        "pick: from 4.00 s, 2.00 s, succeeded"
    )
    assert width[0] == width[2] == pytest.approx(2 * width[1])
    assert x[1] - x[0] == pytest.approx(width[0])
    assert x[2] - x[1] == pytest.approx(width[1])
    assert len({bar.get("y") for bar in bars}) == 2


def test_the_drawing_brings_its_own_ground_for_dark_notebooks():
    ground = shown(ERRAND).xpath(".//rect")[0]
    (drawing,) = shown(ERRAND).xpath(".//svg")
    assert ground.get("fill") == "#ffffff"
    assert drawing.get("viewbox").split()[2:] == [ground.get("width"), ground.get("height")]
    assert "color" not in ERRAND._repr_html_()


def test_hostile_names_are_text():
    hostile = "</td><script>alert(1)</script>'\" onload='x' &lt;" + "y" * 40
    trace = trace_of((hostile, 0.0, 1.0, {hostile: 1.0}), elements=(hostile,))
    trace = replace(trace, controller=hostile, robot=hostile)
    page = shown(trace)
    assert not page.xpath("//script | //*[@onload]")
    assert rows(page)[0][3] == rows(page)[1][0] == hostile
    assert page.xpath("string(.//h4)") == hostile
    assert page.xpath("string(.//text/title)") == hostile


def test_of_very_many_the_first_are_shown_and_the_rest_is_counted():
    elements = tuple(f"e{index}" for index in range(40))
    visits = [
        (f"f{index % 100}", index * 0.01, 0.01, dict.fromkeys(elements, 0.01))
        for index in range(2500)
    ]
    trace = trace_of(*visits, elements=elements, end_s=25.0)
    text = trace._repr_html_()
    page = html.fragment_fromstring(text)
    assert len(rows(page)) == 31
    assert len(rows(page)[0]) == 3 + 16
    assert "and 70 more functions and 24 more elements" in page.text_content()
    assert "the first 600 of 750 visits" in page.text_content()
    assert len(text) < 200_000


def test_a_log_without_times_says_what_was_in_use():
    trace = trace_of(("move", 0.0, None, {"joint1": None}), end_s=None)
    page = shown(trace)
    assert not page.xpath(".//svg")
    assert rows(page) == [["function", "visits", "seconds", "joint1"], ["move", "1", "", "in use"]]


def test_an_empty_trace_shows_how_it_ended():
    empty = replace(trace_of(), end=RunEnd("raised", "ValueError: <broken>", 0.0))
    assert "ValueError: <broken>" in shown(empty).text_content()
    assert "0 functions, 0 visits" in shown(empty).text_content()


def test_where_there_is_no_html_it_is_a_few_lines():
    formatters = pytest.importorskip("IPython.core.formatters", reason="IPython is not installed")
    data, _ = formatters.DisplayFormatter().format(ERRAND)
    assert data["text/html"] == ERRAND._repr_html_()
    assert data["text/plain"].split("\n") == [
        "Trace of arm.py: on panda in scene tube_racks, 10.0 s simulated, the controller ended",
        "  move: 2 visits, 8.00 s",
        "  pick: 1 visit, 2.00 s",
        "2 functions, 3 visits, 0 findings, 0 functions that can move the arm but never ran",
    ]


def test_showing_a_trace_imports_nothing_heavy():
    script = (
        "import sys; from tracerisk.trace import Trace, RunEnd;"
        "Trace('a', '', '', RunEnd('ended', '', 1.0), (), (), ())._repr_html_();"
        "print(sorted({'numpy', 'mujoco', 'jinja2', 'tracerisk.prm'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert done.stdout.decode().strip() == "[]"


def test_a_command_in_an_assumption_names_the_file_as_the_trace_does():
    said = "drafted: 1 value; `tracerisk scenario src/a.py --write` writes it, as src/a.py asks"
    bare = Trace("src/a.py", "", "", RunEnd("ended", "", 1.0), (), (), (), assumptions=(said,))
    typed = bare.with_files(lambda file: f"../{file}")
    assert "`tracerisk scenario ../src/a.py --write`" in typed.assumptions[0]
