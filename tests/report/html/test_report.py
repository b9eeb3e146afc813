import base64
import hashlib
import json
import math
import re
from dataclasses import replace
from fractions import Fraction
from html import unescape
from itertools import combinations, pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from markupsafe import Markup

from tests.report.html.conftest import HOSTILE
from tracerisk.adder.blocks.override import Override
from tracerisk.common.hardware.model import Basis, Component, FailureFigure, Hardware
from tracerisk.common.text.printable import without_controls
from tracerisk.common.verdict import VERDICTS, Coverage, Reason, Verdict, kind_of, verdict_line
from tracerisk.errors import Location
from tracerisk.prm import FaultTree, HybridModel, solve
from tracerisk.prm.review.change_records import RunVerdicts
from tracerisk.prm.trees.events import BasicEvent, Share
from tracerisk.report.html import figures
from tracerisk.report.html.notes import drift as drift_of_pin
from tracerisk.report.html.page import _with_code, page, rendered
from tracerisk.report.html.report import render_report
from tracerisk.report.html.report_input import SourceBlock, SourceFile
from tracerisk.report.html.repository.history import history_section
from tracerisk.report.html.section import Data, Section, json_in_script
from tracerisk.report.html.sources import shown_sources
from tracerisk.report.series.history import HistoryPoint


@pytest.fixture(scope="module")
def document(arm, report_of, parsed):
    return parsed(render_report(report_of(arm)))


def texts(elements):
    return [" ".join(each.text_content().split()) for each in elements]


def classed(root, kind, tag="*"):
    return root.xpath(f".//{tag}[contains(concat(' ', @class, ' '), ' {kind} ')]")


def rows(document, name):
    return document.xpath(f"//table[@id='{name}-table']/tbody/tr")


def test_the_one_sentence_is_the_heading_of_the_page(document, arm):
    (heading,) = document.xpath("//h1")
    # Ten cycles in the mean, each of a motor among seven, the gripper, or both power units.
    assert solve(arm).mission.failure_probability == pytest.approx(7.1e-6, rel=1e-4)
    figure = "7.100\xa0\N{MULTIPLICATION SIGN}\xa010⁻⁶"
    sentence = "Probability that a hardware failure ends a mission of arm.py:"
    assert heading.text_content() == f"{sentence} {figure}, one in 141,000 missions"
    assert "not harm" in document.text_content()


def test_a_component_with_a_common_cause_is_used_and_counted_once(report_of, parsed):
    tree = FaultTree.of(
        "pick fails",
        {"pick fails": ("or", "power", "all power"), "power": ("and", "power[1]", "power[2]")},
        {
            **{
                f"power[{number}]": BasicEvent(
                    f"power[{number}]", "power {own}", component="power", share=Share.OWN
                )
                for number in (1, 2)
            },
            "all power": BasicEvent(
                "all power", "power {common cause}", component="power", share=Share.COMMON_CAUSE
            ),
        },
    )
    values = {"power {own}": 1e-4, "power {common cause}": 1e-5}
    model = HybridModel.of("arm.py", {"pick": tree}, {"pick": "done"}, values=values)
    figure = FailureFigure("probability", 1e-6, Basis.MINUTE)
    described = tuple(Component(name, (figure,), 2) for name in ("power", "brake"))
    hardware = Hardware("cell.yaml", described, "panda")
    page = parsed(render_report(report_of(model, hardware=hardware)))
    cells = [[*texts(row.xpath("./*"))] for row in rows(page, "hardware")]
    assert [(row[0], row[-1]) for row in cells] == [("power", "used"), ("brake", "not used")]
    (count,) = page.xpath("//ul[@class='counts']//a[@href='#importance']")
    assert " ".join(count.text_content().split()) == "1 component"


def test_headings_are_in_order_and_sections_named_by_theirs(document):
    levels = [int(each.tag[1]) for each in document.xpath("//h1|//h2|//h3|//h4")]
    assert levels[0] == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    for section in document.xpath("//section"):
        label = section.get("aria-labelledby")
        assert len(document.xpath(f"//*[@id='{label}']")) == 1


def test_every_id_is_there_once_and_every_link_leads_to_one(document):
    ids = document.xpath("//@id")
    assert len(ids) == len(set(ids))
    links = document.xpath("//a/@href")
    assert links
    assert {link.removeprefix("#") for link in links} <= set(ids)


def test_the_chain_is_drawn_with_every_state_and_transition(document, arm):
    (drawing,) = document.xpath("//*[@id='chain']//svg")
    states = drawing.xpath(".//g/@data-state")
    assert sorted(states) == ["done", "move", "move_failure", "pick", "pick_failure"]
    edges = drawing.xpath(".//path/@data-edge")
    assert sorted(edges) == [
        "move move_failure", "move pick", "pick done", "pick move", "pick pick_failure",
    ]  # fmt: skip
    labels = texts(classed(drawing, "figure", "text"))
    tops = [state.top_event for state in solve(arm).states]
    assert sorted(labels) == sorted(["1/10", "9/10", "1", *(f"{top:.3e}" for top in tops)])
    assert len(rows(document, "transitions")) == len(edges)


def test_the_ways_on_of_a_state_add_up_with_its_failure(document):
    found = [texts(row.xpath("./*")) for row in rows(document, "transitions")]
    for state in ("move", "pick"):
        assert sum(float(row[2]) for row in found if row[0] == state) == pytest.approx(1.0, 1e-5)


def test_each_function_has_its_fault_tree_with_all_gates_and_events(document, arm):
    trees = classed(document, "tree", "details")
    assert len(trees) == len(arm.states)
    for state, shown in zip(arm.states, trees, strict=True):
        (drawing,) = shown.xpath(".//svg")
        assert set(drawing.xpath(".//g/@data-gate")) == {gate.name for gate in state.tree.gates}
        assert set(drawing.xpath(".//g/@data-event")) == {each.name for each in state.tree.events}
        inputs = [f"{gate.name} {child}" for gate in state.tree.gates for child in gate.inputs]
        assert sorted(drawing.xpath(".//path/@data-edge")) == sorted(inputs)
        assert len(shown.xpath(".//li")) == len(state.tree.gates)


def test_units_and_groups_of_a_tree_belong_to_their_component(document):
    (pick,) = [
        each for each in classed(document, "tree", "details") if each.get("data-function") == "pick"
    ]
    of_power = pick.xpath(".//g[@data-component='power']")
    assert {each.get("data-gate") or each.get("data-event") for each in of_power} == {
        "power", "power[1]", "power[2]",
    }  # fmt: skip
    assert texts(classed(pick.xpath(".//g[@data-gate='power']")[0], "mark")) == ["&"]


def test_only_the_riskiest_function_is_unfolded(document, arm):
    opened = [each for each in classed(document, "tree") if each.get("open") is not None]
    riskiest = max(solve(arm).states, key=lambda each: each.absorption_probability)
    assert [each.get("data-function") for each in opened] == [riskiest.name]


def test_of_a_large_tree_the_uppermost_part_is_drawn_and_the_rest_reported(report_of, parsed):
    tree = FaultTree.of("top", {"top": ("or", *(f"e{n}" for n in range(200)))})
    model = HybridModel.of("m", {"big": tree}, values={f"e{n}": 1e-9 for n in range(200)})
    page = parsed(render_report(report_of(model)))
    assert len(page.xpath("//*[@id='fault-trees']//svg//g/@data-event")) == 119
    assert "81 more below are not drawn." in page.text_content()


def test_of_a_long_chain_the_first_states_are_drawn_and_all_listed(report_of, parsed):
    tree = FaultTree.of("top", {"top": ("or", "a")}, {"a": 1e-9})
    model = HybridModel.of("m", {f"step{n}": tree for n in range(70)})
    page = parsed(render_report(report_of(model)))
    assert len(page.xpath("//*[@id='chain']//g[@data-function]/@data-state")) == 60
    assert "10 more are in the table" in page.text_content()
    assert len(rows(page, "transitions")) == 140


def test_the_tables_have_a_row_for_each_function_and_component(document, arm):
    pairs = sum(len(state.components) for state in solve(arm).states)
    assert len(rows(document, "functions")) == pairs
    assert texts(row.xpath("./th")[0] for row in rows(document, "importance")) == [
        each.name for each in solve(arm).components
    ]
    assert len(rows(document, "shares")) == len(arm.states)
    assert len(document.xpath("//dl[@class='meanings']//dt")) == 6


def test_every_table_has_a_caption_and_scopes(document):
    for table in document.xpath("//table"):
        assert table.xpath("./caption")
        assert all(head.get("scope") for head in table.xpath(".//th"))
        widths = {
            sum(int(cell.get("colspan", 1)) for cell in row.xpath("./*"))
            for row in table.xpath("./thead/tr")
        }
        assert len(widths) == 1


def test_the_same_input_gives_the_same_bytes(arm, report_of):
    assert render_report(report_of(arm)) == render_report(report_of(arm))


def test_nothing_is_fetched_and_the_policy_knows_the_script_and_style(document):
    sources = document.xpath("//@src") + document.xpath("//link/@href") + document.xpath("//@data")
    assert sources == ["data:,"]
    (policy,) = document.xpath("//meta[@http-equiv]/@content")
    assert policy.startswith("default-src 'none';")
    assert "unsafe" not in policy
    for element in (document.xpath("//script[not(@type)]")[0], document.xpath("//style")[0]):
        digest = hashlib.sha256(element.text.encode()).digest()
        assert f"'sha256-{base64.b64encode(digest).decode()}'" in policy
    assert not document.xpath("//@style")
    assert not re.search(r"url\((?!#)", document.xpath("//style")[0].text)


def test_each_printed_sheet_says_what_it_belongs_to(report_of, arm):
    page = render_report(report_of(arm))
    foot = re.search(r'@page \{ @bottom-left \{ content: "([^"]*)"; \} \}', page)
    assert foot is not None
    figure = re.search(r"Risk of arm\.py: (\d\.\d{3}e-\d\d)$", foot[1])
    assert figure is not None
    assert 'counter(page) " of " counter(pages)' in page


@pytest.mark.parametrize("name", HOSTILE)
def test_a_name_at_the_foot_of_a_sheet_ends_no_string_and_no_style(report_of, arm, name):
    page = render_report(report_of(replace(arm, name=name)))
    style = page[page.index("<style>") + 7 : page.index("</style>")]
    foot = style[style.rindex("@page") :]
    assert re.fullmatch(
        r'@page \{ @bottom-left \{ content: "(\\[0-9a-f]{6}|[^"\\<>])*"; \} \}', foot
    )


def test_a_source_is_shown_line_by_line_with_its_blocks(arm, report_of, parsed):
    text = "\ufeffdef move(arm):\r\n    # | RiskAnnotation\r\n\tarm.go('<b>')  # \f\r\n\r\nx = '''a\nb'''"
    source = SourceFile("a/b.py", text, (SourceBlock("move", 1, 2, 2),))
    page = parsed(render_report(report_of(arm, sources=(source,))))
    lines = classed(page, "line", "span")
    assert "".join(line.text_content() for line in lines).replace("\\x0c", "\f") == (
        text.removeprefix("\ufeff").replace("\r\n", "\n") + "\n"
    )
    assert [line.get("data-n") for line in lines] == ["1", "2", "3", "4", "5", "6"]
    (block,) = classed(page, "block", "span")
    assert (block.get("id"), block.get("data-function")) == ("source-1-2", "move")
    (link,) = page.xpath("//a[@class='note']")
    assert (link.get("href"), link.text) == ("#source-1-1", "step 1, line 1")


@given(st.text(st.characters(codec="utf-8", exclude_categories=("Cc",)), max_size=60))
@example("if \ufeff\u2028")
def test_a_source_keeps_every_character(text):
    html = rendered("sources.html.j2", sources=_shown(text))
    lines = re.findall(r'<span class="line".*?>(.*?)\n</span>', html, re.DOTALL)
    assert [unescape(re.sub(r"<[^>]*>", "", line)) for line in lines] == (
        [shown] if (shown := text.removeprefix("\ufeff")) else []
    )


def _shown(text):
    return shown_sources((SourceFile("a.py", text),))


def test_pins_are_reported_with_reason_and_drift(arm, report_of, parsed):
    place = Location("a.py", 1)
    pins = (
        Override("value", "move.motor.probability", "2e-7", place, "1e-7", "FMEA-112", 100.0),
        Override("value", "pick.next", "done 1", place),
    )
    source = SourceFile("a.py", "x\n")
    page = parsed(render_report(report_of(arm, pins=pins, sources=(source,))))
    first, second = (texts(row.xpath("./*")) for row in rows(page, "pins"))
    assert first == ["move.motor.probability", "2e-7", "1e-7", "+100 %", "FMEA-112", "a.py:1"]
    assert second[2:5] == ["\N{EN DASH}", "\N{EN DASH}", "none givenwithout a reason"]
    assert rows(page, "pins")[0].xpath(".//a/@href") == ["#source-1-1"]
    headings = rows(page, "pins")[0].xpath("./td/@data-heading")
    assert headings == ["set by hand", "computed now", "drift", "reason", "place"]


def test_a_figure_set_by_hand_is_said_where_it_drives_the_headline_and_at_its_component(
    arm, report_of, parsed
):
    place = Location("a.py", 1)
    first = solve(arm).components[0].component
    hardware = Hardware("cell.yaml", (Component(first, (), quantity=None),))
    page = parsed(render_report(report_of(arm, hardware=hardware)))
    assert "by hand" not in page.xpath("string(//*[@class='cause'])")
    assert texts(rows(page, "hardware")[0].xpath("./*"))[1] == "7"
    pins = (
        Override("value", f"Cell.move.{first}.probability", "2e-7", place, "1e-7"),
        Override("value", f"Cell.move.{first}.quantity", "2", place, "1"),
    )
    page = parsed(render_report(report_of(arm, hardware=hardware, pins=pins)))
    assert page.xpath("string(//*[@class='cause'])").startswith(f"Without failures of {first}, ")
    assert "(its figure is set by hand in Cell.move)" in page.xpath("string(//*[@class='cause'])")
    assert texts(rows(page, "hardware")[0].xpath("./*"))[-1] == "usedby hand in Cell.move"


@pytest.mark.parametrize(
    ("drift", "expected"),
    [
        (None, "\N{EN DASH}"), (0.0, "0 %"), (-3.456, "-3.46 %"), (999.9, "+1e+03 %"),
        (7188.6, "+7,190 %"), (-123456.0, "-123,000 %"), (2.5e7, "+2.5e+07 %"),
        (math.inf, "computed is zero"),
    ],
)  # fmt: skip
def test_a_drift_has_three_digits(drift, expected):
    pin = Override("value", "a.b", "1", Location("a.py", 1), "2", None, drift)
    assert drift_of_pin(pin) == expected


def test_without_a_run_the_page_says_why(arm, report_of, parsed):
    page = parsed(render_report(report_of(arm, no_trace="The trace is gone.")))
    assert page.xpath("//*[@id='coverage']/p")[0].text_content() == (
        "Not known without a run. The trace is gone."
    )
    assert "active" not in texts(page.xpath("//table[@id='functions-table']/thead//th"))


def test_what_became_of_the_scene_stands_with_the_summary(arm, report_of, parsed):
    page = parsed(render_report(report_of(arm, outcome=("objects: 9 of 10 <b>",))))
    assert "objects: 9 of 10 <b>" in texts(page.xpath("//section[@class='lead']//p"))


def test_a_difference_is_reported_in_the_words_of_diff(arm, report_of, parsed, eventful, review_of):
    review = review_of(eventful, notes=("a note",))
    page = parsed(render_report(report_of(arm, review=review)))
    section = page.get_element_by_id("difference")
    assert section.xpath("./h2")[0].text == "Since HEAD"
    # What changes do only together is less than noise here, and no row.
    assert len(rows(page, "difference-1-changes")) == len(eventful.changes)
    text = section.text_content()
    assert "FMEA|112 <b>" in text
    assert "a note" in text


@pytest.mark.parametrize(
    ("verdicts", "words"),
    [
        ({"a.py": "complete", "b.py": "stuck"}, "for the run of b.py is stuck"),
        ({"a.py": "complete", "my b.py": "faulted"}, "for the run of my b.py is faulted"),
        ({"a.py": "faulted", "b.py": "faulted"}, "for the run is faulted"),
        ({"a.py": "partial"}, "Probability"),
    ],
)
def test_the_first_line_of_a_page_says_which_run_went_wrong(
    arm, report_of, parsed, verdicts, words
):
    verdicts = {name: Verdict(kind) for name, kind in verdicts.items()}
    page = parsed(render_report(report_of(arm, verdicts=verdicts)))
    assert words in page.xpath("//h1")[0].text_content()


def test_a_model_that_cannot_fail_says_so(report_of, parsed):
    model = HybridModel.of("idle.py", {"rest": FaultTree.of("rest", {"rest": ("or",)}, {})})
    page = parsed(render_report(report_of(model)))
    assert page.xpath("//h1")[0].text.startswith("No hardware failure that is modelled")
    cut = parsed(render_report(report_of(model, verdicts={"idle.py": Verdict("stuck")})))
    assert cut.xpath("//h1")[0].text.startswith(
        "Of what ran, for the run is stuck: no hardware failure that is modelled"
    )
    assert "No function leans on a component." in page.text_content()


def test_a_section_of_another_brings_its_style_script_and_data(arm, report_of, parsed):
    html = rendered("list.html.j2", lines=("<i>",), lead="", empty="")
    data = (Data.of_json("own-data", {"a": "</script><!--"}), Data.of_bytes("own-bytes", b"\0\xff"))
    section = Section("own", "Own & more", html, ".own{color:red}", "let own = 1;", data)
    page = parsed(render_report(report_of(arm, sections=(section,))))
    assert page.get_element_by_id("own-title").text == "Own & more"
    assert page.get_element_by_id("own-data").text == '{"a":"\\u003c/script\\u003e\\u003c!--"}'
    assert base64.b64decode(page.get_element_by_id("own-bytes").text) == b"\0\xff"
    assert ".own{color:red}" in page.xpath("//style")[0].text
    assert "let own = 1;" in page.xpath("//script[not(@type)]")[0].text


@pytest.mark.parametrize(
    ("js", "css"), [("'</SCRIPT>'", ""), ("'<!--'", ""), ("", "a::after{content:'</style>'}")]
)
def test_a_script_or_style_that_would_end_itself_is_refused(js, css):
    section = Section("own", "own", rendered("list.html.j2", lines=(), lead="", empty=""), css, js)
    with pytest.raises(ValueError, match="must not stand in a script or style"):
        page("title", section.html, (section,))


@given(st.dictionaries(st.text(max_size=20), st.text(max_size=20), max_size=3))
def test_json_in_a_script_reads_back_and_cannot_end_it(value):
    text = json_in_script(value)

    def shown(given):
        return "\r".join(map(without_controls, given.split("\r")))  # a page shows it as a blank

    assert json.loads(text) == {shown(key): shown(item) for key, item in value.items()}
    assert text.isascii()
    assert not set("<>&\u2028\u2029") & set(text)


def test_json_in_a_script_has_no_infinity():
    with pytest.raises(ValueError, match="JSON"):
        json_in_script(float("inf"))


def test_hostile_texts_are_texts(hostile_page, parsed):
    document = parsed(hostile_page)
    assert len(document.xpath("//script[not(@type)]")) == 1
    assert len(document.xpath("//style")) == 1
    assert not document.xpath("//img | //b[text()='']")
    assert not document.xpath("//@onmouseover | //@onerror")
    printed = document.text_content()
    for text in ("</script><script>window.pwned = 1</script>", "{{ 7 * 7 }}{% raw %}"):
        assert printed.count(text) > 5


def test_what_no_encoding_has_is_replaced(arm, report_of):
    page = render_report(report_of(arm, findings=("a\0b\udc80c\x1b[31m",)))
    assert r"a\x00b\udc80c\x1b[31m" in page
    assert page.encode("utf-8")


def test_what_turns_the_direction_of_writing_is_seen(arm, report_of):
    text = "# \u202e\u2066 if admin\u2069 \u2066begin"
    page = render_report(
        report_of(arm, findings=(text,), sources=(SourceFile("arm.py", text, ()),))
    )
    shown = r"# \u202e\u2066 if admin\u2069 \u2066begin"
    assert page.count(shown) == 2
    assert not re.search("[\u202a-\u202e\u2066-\u2069\u200e\u200f\u061c]", page)


def test_words_between_backticks_are_code_and_names_stay_text():
    assert _with_code("`next` counts <b>") == "<code>next</code> counts &lt;b&gt;"
    assert _with_code("a ` alone") == "a ` alone"


def test_the_page_is_small(arm, report_of):
    assert len(render_report(report_of(arm)).encode()) < 60_000


def branching(count: int) -> HybridModel:
    """States of which each may go to any other one, or end the mission."""
    tree = FaultTree.of("top", {"top": ("or", "a")}, {"a": 1e-9})
    names = [f"step{n}" for n in range(count)]
    share = Fraction(1, count + 1)
    following = {name: dict.fromkeys([*names, "done"], share) for name in names}
    return HybridModel.of("m", dict.fromkeys(names, tree), following)


def test_no_two_ways_of_a_chain_share_a_stretch(report_of, parsed):
    page = parsed(render_report(report_of(branching(5))))
    (drawing,) = page.xpath("//*[@id='chain']//svg")
    ways = [each.get("d") for each in drawing.xpath(".//path[@data-edge]") if "Q" in each.get("d")]
    assert len(ways) == 5 * 5 - 4 + 4
    upright = [
        (float(lane), *sorted(map(float, ends))) for way in ways for lane, *ends in parts(way)
    ]
    for (x, low, high), (other, start, end) in combinations(upright, 2):
        assert x != other or high <= start or end <= low
    level = [float(height) for way in ways for height in heights(way)]
    assert len(level) == len(set(level)) == 2 * len(ways)


def parts(way):
    """The lane of a way, and from where to where it runs in it."""
    found = re.fullmatch(r".*Q(\S+) (\S+) \S+ \S+ V\S+ Q\S+ (\S+) .*", way)
    return [found.groups()]


def heights(way):
    """How high a way leaves, and how high it arrives."""
    found = re.fullmatch(r"M\S+ (\S+) .* Q\S+ \S+ \S+ (\S+) H.*", way)
    return found.groups()


def test_labels_of_a_chain_do_not_overlap(report_of, parsed):
    page = parsed(render_report(report_of(branching(4))))
    boxes = [
        tuple(float(each.get(name)) for name in ("x", "y", "width", "height"))
        for each in page.xpath("//*[@id='chain']//rect[@class='ground']")
    ]
    assert len(boxes) == 4 * 5 + 4
    for (x, y, w, h), (u, v, a, b) in combinations(boxes, 2):
        assert x + w <= u or u + a <= x or y + h <= v or v + b <= y


@pytest.mark.parametrize(
    ("share", "expected"),
    [
        (0.0, "0 %"),
        (2.7e-8, "< 0.01 %"),
        (1e-4, "0.01 %"),
        (0.0569, "5.69 %"),
        (0.99999, "> 99.9 %"),
        (1.0 - 1e-12, "100 %"),
        (1.0, "100 %"),
    ],
)
def test_a_share_is_none_or_all_only_where_it_is(share, expected):
    assert figures.percent(share).replace("\N{NO-BREAK SPACE}", " ") == expected


def test_readings_that_print_the_same_add_a_line_and_no_second_figure(report_of, parsed):
    alike = FaultTree.of("go fails", {"go fails": ("or", "motor")}, {"motor": 1e-9})
    again = {"go": {"go": Fraction(9, 10), "done": Fraction(1, 10)}}
    model = HybridModel.of("a.py", {"go": alike}, again)
    page = parsed(render_report(report_of(model)))
    (lead,) = page.xpath("//section[@class='lead']")
    assert not lead.xpath(".//*[@class='readings']")
    assert "10 fixed cycles (each fails with 1.000e-09)" in lead.text_content()
    assert lead.text_content().count("1.000\xa0\N{MULTIPLICATION SIGN}\xa010⁻⁸") == 1
    likely = FaultTree.of("go fails", {"go fails": ("or", "motor")}, {"motor": 0.01})
    often = HybridModel.of("a.py", {"go": likely}, again)
    assert len(parsed(render_report(report_of(often))).xpath("//*[@class='readings']/div")) == 3


@pytest.mark.parametrize(
    ("verdict", "rest"),
    [
        (Verdict("complete", (), Coverage(7, 7)), "7 of 7 functions"),
        (Verdict("partial", (Reason("no-answer", "partial", "no one"),)), "no one"),
        (Verdict("faulted", (Reason("hit", "faulted", "arm.py:3: struck"),)), "arm.py:3: struck"),
        (Verdict("stuck", (Reason("idle", "stuck", "nothing can happen"),)), "nothing can"),
        (None, ""),
    ],
)
def test_a_verdict_is_a_chip_of_its_own_form(arm, report_of, parsed, verdict, rest):
    kind, lines = kind_of(verdict), (verdict_line(verdict), "more")
    page = parsed(render_report(report_of(arm, verdicts={"arm.py": verdict}, verdict=lines)))
    ((chip,),) = [classed(each, "chip") for each in classed(page, "verdict")]
    assert chip.text_content() == kind
    assert chip.tail.strip().startswith(rest)
    (lead,) = page.xpath("//section[@class='lead']")
    is_bad = kind in ("faulted", "stuck")
    assert (f"Of what ran, for the run is {kind}: probability" in lead.text_content()) is is_bad
    findings = page.get_element_by_id("findings").text_content()
    assert ("Nothing stood out." in findings) is (kind == "complete")


def test_no_two_verdicts_share_an_icon(arm, report_of, parsed):
    icons = [
        parsed(
            render_report(
                report_of(arm, verdicts={"arm.py": verdict}, verdict=(verdict_line(verdict),))
            )
        ).xpath("//p/b//path/@d")
        for verdict in (*map(Verdict, VERDICTS), None)
    ]
    assert len({icon for (icon,) in icons}) == len(VERDICTS) + 1


def test_the_replay_stands_before_what_changed_and_that_before_the_tables(
    arm, report_of, parsed, eventful, review_of
):
    shown = Section("timeline", "Replay", Markup("<p>r</p>"))
    tabled = Section("evidence", "Evidence", Markup("<p>e</p>"))
    report = report_of(arm, sections=(shown, tabled), review=review_of(eventful))
    document = parsed(render_report(report))
    names = document.xpath("//main/section/@id")
    assert names[:4] == ["timeline", "difference", "evidence", "functions"]
    (since,) = classed(document, "since")
    assert "cell.py" in since.text_content()
    assert since.xpath(".//a/@href") == ["#difference"]


def test_of_a_long_history_the_latest_commits_are_in_sight_and_the_others_folded(parsed):
    went = [HistoryPoint(f"c{n}", "2026-01-02", "Change", "c.py", 1e-6, None) for n in range(50)]
    for count, shown, folded in ((20, 20, 0), (21, 21, 0), (22, 20, 2), (50, 20, 30)):
        document = parsed(page("h", Markup(""), [history_section("a.py", went[:count])]))
        assert len(rows(document, "history")) == shown
        assert len(rows(document, "history-earlier")) == folded
        first = rows(document, "history")[0].text_content().split()[0]
        assert first.startswith(f"c{count - shown}")
    assert len(document.xpath("//details//table[@id='history-earlier-table']")) == 1


def test_a_history_page_gives_the_ratio_that_the_terminal_gives(parsed, eventful):
    faulted = Verdict("faulted", (), Coverage(1, 1))
    verdicts = RunVerdicts(Verdict("complete", (), Coverage(1, 1)), faulted)
    point = HistoryPoint("c1", "2026-01-02", "Change", "c.py", 1e-6, None)
    later = replace(point, commit="c2", failure_probability=2e-6, diff=eventful)
    broken = replace(later, commit="c3", diff=replace(eventful, verdicts=verdicts))
    document = parsed(page("h", Markup(""), [history_section("a.py", [point, later, broken])]))
    ratios = [row.xpath("./td")[1].text_content().strip() for row in rows(document, "history")]
    of_parent = f"x{2e-6 / eventful.before.failure_probability:.3g}"
    assert ratios == ["", of_parent, "not comparable"]
