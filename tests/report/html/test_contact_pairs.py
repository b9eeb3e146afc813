"""Contacts and payload in the report: one row a function and pair of bodies."""

from dataclasses import replace

import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.traced.elements import Contact, Element, Payload
from tracerisk.report.html.figures import NOTHING
from tracerisk.report.html.report import render_report
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

HEADINGS = [
    "function",
    "link, or thing held",
    "other body",
    "greatest force N",
    "touching seconds of the run",
    "first at seconds",
    "visits with this touch",
]


def trace_of(visits):
    refs = [FunctionRef("arm.py", QualifiedName(name)) for name in ("move", "pick")]
    return Trace(
        controller="arm.py",
        robot="panda",
        scene="racks",
        end=RunEnd("ended", "the controller ended", 12.5),
        elements=(
            Element("hand", "gripper"),
            *(Element(name, "contact", part=name) for name in ("link3", "link7", "left")),
        ),
        functions=tuple(TracedFunction(ref, 1, n) for n, ref in enumerate(refs, 1)),
        visits=tuple(
            Visit(refs[which], 0.0, 1.0, "succeeded", {}, payloads, contacts)
            for which, payloads, contacts in visits
        ),
    )


VISITS = (
    (
        1,
        (Payload("hand", "tube", 0.025, 1.0, 10.0, 14.0),),
        (
            Contact("left", "tube", 3.0, 1.0, 12.0, expected=True),
            Contact("tube", "table", 3.5, 0.25, 1234.5, expected=False),
        ),
    ),
    (
        0,
        (),
        (
            Contact("link3", "link7", 5.0, 0.5, 0.0, expected=False),
            Contact("link3", "link7", 5.6, 0.25, 0.0, expected=False),
        ),
    ),
    (
        1,
        (Payload("hand", "tube", 0.025, 3.0, 12.0, 20.0),),
        (Contact("tube", "table", 8.0, 0.5, 40.0, expected=False),),
    ),
)


@pytest.fixture
def shown(arm, report_of, parsed):
    def show(trace):
        return parsed(render_report(report_of(arm, trace=trace)))

    return show


def table(document, name):
    """The rows of a table as texts, headings first."""
    (found,) = document.xpath(f"//table[@id='{name}-table']")
    return [
        [" ".join(" ".join(cell.itertext()).split()) for cell in row.xpath("./th|./td")]
        for row in found.xpath(".//tr")
    ]


def test_unexpected_contacts_are_reported_by_function_and_bodies(shown):
    heads, *rows = table(shown(trace_of(VISITS)), "unexpected-contacts")
    assert heads == HEADINGS
    assert rows == [
        [
            "move",
            "link3",
            "link7 of the arm itself",
            f"{NOTHING} not simulated",
            "0.75",
            "5.00",
            "1",
        ],
        ["pick", "tube held", "table", "1234", "0.75", "3.50", "2"],
    ]


def test_expected_contacts_stand_apart(shown):
    _, *rows = table(shown(trace_of(VISITS)), "contacts")
    assert rows == [["pick", "left", "tube", "12", "1.00", "3.00", "1"]]


def test_payload_has_mass_time_and_the_forces_weighted_by_time(shown):
    _, *rows = table(shown(trace_of(VISITS)), "payloads")
    assert rows == [["pick", "hand", "tube", "0.025", "4.00", "11.5", "20"]]


def test_rows_of_a_function_share_its_heading_and_follow_it(shown):
    held = [(1, (Payload("hand", f"tube{n}", 0.1, 1.0, 9.0, 9.0),), ()) for n in (2, 1)]
    document = shown(trace_of([*held, (0, (Payload("hand", "lid", 0.2, 1.0, 5.0, 5.0),), ())]))
    found = document.xpath("//table[@id='payloads-table']/tbody/tr")
    assert [row.get("data-function") for row in found] == ["move", "pick", "pick"]
    assert [len(row.xpath("./th")) for row in found] == [1, 1, 0]
    assert found[1].xpath("./th/@rowspan") == ["2"]
    assert found[1].xpath("./th/button/@data-function") == ["pick"]


def test_nothing_unexpected_is_said_so_and_many_rows_are_folded(shown):
    touches = tuple(Contact("left", f"tube{n}", 1.0, 1.0, 2.0, expected=True) for n in range(20))
    document = shown(trace_of([(1, (), touches)]))
    (section,) = document.xpath("//section[@id='touches']")
    assert "Nothing touched that should not have." in section.text_content()
    assert not document.xpath("//table[@id='unexpected-contacts-table']")
    (folded,) = section.xpath("./details[not(@open)]")
    assert len(folded.xpath(".//tbody/tr")) == 20
    assert "20 rows" in folded.xpath("./summary")[0].text_content()


def test_nothing_touched_is_reported_and_nothing_known_is_not(shown, arm, report_of, parsed):
    nothing = trace_of([(1, (), ())])
    (section,) = shown(nothing).xpath("//section[@id='touches']")
    assert "Nothing touched anything, and nothing was held." in section.text_content()
    logged = replace(nothing, elements=(Element("gripper", "component"),))
    assert not shown(logged).xpath("//section[@id='touches']")
    without = parsed(render_report(report_of(arm)))
    assert not without.xpath("//section[@id='touches']")


def test_hostile_names_are_text(shown, hostile):
    contacts = tuple(Contact(name, name, 1.0, 1.0, 2.0, expected=False) for name in hostile)
    payloads = tuple(Payload(name, name, 1.0, 1.0, 2.0, 3.0) for name in hostile)
    document = shown(trace_of([(0, payloads, contacts)]))
    assert len(document.xpath("//script[not(@type)]")) == 1
    assert len(document.xpath("//style")) == 1
    assert not document.xpath("//img | //@onmouseover | //@onerror")
    for name in ("unexpected-contacts", "payloads"):
        (found,) = document.xpath(f"//table[@id='{name}-table']")
        printed = found.text_content()
        assert all(printed.count(text) == 2 for text in hostile if text.isprintable())
