import base64

import pytest

from tests.browser import emulate, requests, violations
from tracerisk.common.verdict import Coverage, Verdict
from tracerisk.report.html.page import page
from tracerisk.report.html.repository.history import history_section
from tracerisk.report.html.repository.overview import OverviewRow, overview_lead, overview_section
from tracerisk.report.series.history import HistoryPoint

WIDTHS = (360, 768, 1280, 1920)


@pytest.fixture(scope="module")
def opened(browser, full_page, tmp_path_factory):
    """The full page in the browser, as it is after loading; and what the browser said."""
    file = tmp_path_factory.mktemp("page") / "report.html"
    file.write_text(full_page, encoding="utf-8")
    browser.get("about:blank")
    browser.get_log("performance")
    browser.get_log("browser")
    browser.get(file.as_uri())
    browser.report = file.as_uri()
    browser.requests = requests(browser)
    browser.complaints = browser.get_log("browser")
    return browser


@pytest.fixture(autouse=True)
def as_loaded(request):
    """The page as it was: no theme chosen, nothing selected, light and wide."""
    if "opened" in request.fixturenames:
        page = request.getfixturevalue("opened")
        if page.current_url != page.report:
            page.get(page.report)
        page.execute_script("tracerisk.select({}); localStorage.clear();")
        page.execute_script("document.querySelector('[data-theme-choice=auto]').click()")
        emulate(page, "light")
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def _state_of(browser, selector, property_name):
    script = "return getComputedStyle(document.querySelector(arguments[0]))[arguments[1]]"
    return browser.execute_script(script, selector, property_name)


def test_a_page_from_a_file_fetches_nothing_and_logs_no_error(opened):
    assert [url for url in opened.requests if not url.startswith("data:")] == [opened.report]
    assert opened.complaints == []


def test_hostile_texts_do_nothing(browser, hostile_page, tmp_path):
    file = tmp_path / "hostile.html"
    file.write_text(hostile_page, encoding="utf-8")
    browser.get_log("browser")
    browser.get(file.as_uri())
    assert browser.execute_script("return window.pwned ?? null") is None
    assert browser.execute_script("return document.images.length") == 0
    assert browser.get_log("browser") == []
    assert "{{ 7 * 7 }}" in browser.find_element("id", "findings").text


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(opened, scheme):
    emulate(opened, scheme)
    opened.execute_script(
        "for (const each of document.querySelectorAll('details')) each.open = true"
    )
    serious, reported = violations(opened, scheme)
    assert not serious, reported


def test_the_page_follows_the_scheme_until_a_theme_is_chosen(opened):
    light = _state_of(opened, "body", "backgroundColor")
    emulate(opened, "dark")
    dark = _state_of(opened, "body", "backgroundColor")
    assert light != dark
    opened.execute_script("document.querySelector('[data-theme-choice=light]').click()")
    assert _state_of(opened, "body", "backgroundColor") == light
    chosen = opened.execute_script(
        "return [...document.querySelectorAll('[data-theme-choice]')].map(e => e.ariaPressed)"
    )
    assert chosen == ["false", "true", "false"]


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("width", WIDTHS)
def test_only_drawings_tables_and_sources_scroll_sideways(opened, width):
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    opened.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    assert opened.execute_script("return document.documentElement.scrollWidth") <= width


def test_choosing_a_component_marks_it_wherever_it_is(opened):
    script = "return [...document.querySelectorAll('.is-selected')].map(e => e.dataset.component)"
    assert opened.execute_script(script) == []
    opened.execute_script(
        "document.querySelector('#importance button[data-component=motor]').click()"
    )
    marked = opened.execute_script(script)
    assert set(marked) == {"motor"}
    assert len(marked) > 10
    assert opened.execute_script("return tracerisk.selected.component") == "motor"
    opened.execute_script("document.querySelector('#functions button.is-selected').click()")
    assert opened.execute_script(script) == []


def test_a_function_is_chosen_from_the_chain_and_let_go_by_escape(opened):
    opened.execute_script(
        "window.told = []; document.addEventListener('tracerisk:select', e => told.push(e.detail));"
        "document.querySelector('#chain [data-state=pick] rect')"
        ".dispatchEvent(new MouseEvent('click', {bubbles: true}))"
    )
    marked = opened.execute_script(
        "return [...document.querySelectorAll('.line.is-selected')].map(e => e.id)"
    )
    assert marked == ["source-2-9", "source-2-10"]
    opened.find_element("tag name", "body").send_keys("\ue00c")
    reported = opened.execute_script("return told")
    assert [each["function"] for each in reported] == ["pick", None]


def test_the_clock_stays_within_the_run_and_says_who_listens(opened):
    reported = opened.execute_script("""
        const {clock} = tracerisk, told = [];
        const end = clock.subscribe((time, source) => told.push([time, source]));
        clock.setEnd(10);
        clock.set(4, 'test'); clock.set(4, 'again'); clock.set(99, 'test'); clock.set(-1);
        end();
        clock.set(5);
        clock.setEnd(0);
        return told;
    """)
    assert reported == [[0, None], [4, "test"], [10, "test"], [0, None]]


def test_a_link_unfolds_what_it_leads_to(opened):
    opened.execute_script(
        "for (const each of document.querySelectorAll('details')) each.open = false"
    )
    opened.execute_script("location.hash = '#source-2-10'")
    wait = pytest.importorskip("selenium.webdriver.support.wait").WebDriverWait(opened, 5)
    script = "return document.getElementById('source-2-10').closest('details').open"
    assert wait.until(lambda page: page.execute_script(script))


def test_print_is_light_and_shows_what_is_folded(opened):
    emulate(opened, "dark", "print")
    red = _state_of(opened, "body", "color")
    assert red == "rgb(27, 29, 33)"
    assert _state_of(opened, ".contents", "display") == "none"
    emulate(opened, "dark")
    opened.execute_script(
        "for (const each of document.querySelectorAll('details')) each.open = false;"
        "window.unfolded = 0; addEventListener('beforeprint', () => "
        "unfolded = document.querySelectorAll('details[open]').length)"
    )
    pdf = base64.b64decode(opened.print_page())
    assert pdf.startswith(b"%PDF-")
    folded = opened.execute_script(
        "return document.querySelectorAll('details:not([data-print=folded])').length"
    )
    assert opened.execute_script("return unfolded") == folded
    assert opened.execute_script("return document.querySelectorAll('details[open]').length") == 0


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious_on_the_page_over_all_controllers(
    browser, arm, report_of, tmp_path, scheme
):
    assessment = report_of(arm).assessment
    verdict = Verdict("partial", (), Coverage(8, 10))
    rows = [
        OverviewRow("cells/arm.py", verdict, assessment, link="#controllers", report="arm.html"),
        OverviewRow("gone.py", None, None, error="gone.py: cannot be read"),
    ]
    went = [
        HistoryPoint(f"{n}a2b3c4d", "2026-01-02", "Add <b>", "c.py", 1e-6 * n, None) for n in (1, 4)
    ]
    lead = overview_lead("repository", rows)
    text = page("All", lead, [overview_section(rows), history_section("arm.py", went)])
    file = tmp_path / "all.html"
    file.write_text(text, encoding="utf-8")
    emulate(browser, scheme)
    browser.get(file.as_uri())
    serious, reported = violations(browser, scheme)
    assert not serious, reported


def test_what_is_wider_than_the_window_says_so_until_it_is_not(opened):
    wide = "return document.querySelectorAll('#functions .scroll + .more-sideways').length"
    wait = pytest.importorskip("selenium.webdriver.support.wait").WebDriverWait(opened, 5)
    for width, is_reported in ((360, True), (1920, False), (360, True)):
        metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        opened.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        wait.until(lambda it, reported=is_reported: bool(it.execute_script(wide)) is reported)
    emulate(opened, "light", "print")
    assert _state_of(opened, ".more-sideways", "display") == "none"


def test_a_name_without_room_goes_on_below_after_an_underscore(browser, arm, report_of, tmp_path):
    name = "cells/the_first_of_them/machine_tending.py"
    rows = [OverviewRow(name, None, report_of(arm).assessment)]
    file = tmp_path / "all.html"
    file.write_text(page("All", overview_lead("cells", rows), [overview_section(rows)]))
    metrics = {"width": 400, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.get(file.as_uri())
    row = "const row = document.querySelector('#controllers-table tbody th');"
    assert browser.execute_script(f"{row} return row.textContent").startswith("machine_tending.py")
    tops = (
        f"{row} const letters = row.childNodes; const range ="
        " document.createRange(); return [...letters].slice(0, 3).filter(e => e.nodeType === 3)"
        ".map(e => {range.selectNodeContents(e); return range.getClientRects().length})"
    )
    # Each part of the name, up to an underscore, is whole.
    assert browser.execute_script(tops) == [1, 1]


def test_the_foot_of_a_printed_page_stands_below_its_text(opened):
    emulate(opened, "light", "print")
    left = "return ['main', '.top', 'footer p'].map(e => document.querySelector(e)).map(e =>"
    left += " e.getBoundingClientRect().left + parseFloat(getComputedStyle(e).paddingLeft))"
    assert len(set(opened.execute_script(left))) == 1
