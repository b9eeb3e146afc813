"""Two runs side by side: both pages show the same instant."""

import pytest
from markupsafe import Markup

from tracerisk.report.html.evidence import render_beside
from tracerisk.report.html.page import asset, page
from tracerisk.report.html.section import Section

PAGES = {("joint", "dead", 1.0): "joint-dead.html", ("joint", "jam", 2.0): "joint-jam.html"}


def run_page(end_s: float) -> str:
    sections = (
        Section("run", "Run", Markup("<p>a run</p>"), js=f"tracerisk.clock.setEnd({end_s});"),
        Section("outcome", "Effect", Markup("<p>an effect</p>"), js=asset("beside.js")),
    )
    return page("a run", Markup("<h1>a run</h1>"), sections)


def test_both_runs_show_the_same_instant(browser, tmp_path):
    ends = {"without.html": 20.0, "joint-dead.html": 5.0, "joint-jam.html": 9.0}
    for name, end_s in ends.items():
        (tmp_path / name).write_text(run_page(end_s))
    (tmp_path / "beside.html").write_text(render_beside("cell.py", PAGES, "without.html"))

    def inside(number, script):
        frames = browser.find_elements("css selector", "iframe")
        browser.switch_to.frame(frames[number])
        try:
            return browser.execute_script(script)
        finally:
            browser.switch_to.default_content()

    def times():
        return [inside(number, "return window.tracerisk?.clock.time") for number in (0, 1)]

    def shown(expected):
        wait = pytest.importorskip("selenium.webdriver.support.ui")
        wait.WebDriverWait(browser, 20).until(lambda _: times() == expected)

    browser.get(f"{(tmp_path / 'beside.html').as_uri()}#joint-jam.html")
    shown([0, 0])
    inside(0, "tracerisk.clock.set(4.5, 'test')")
    shown([4.5, 4.5])
    inside(1, "tracerisk.clock.set(6.25, 'test')")
    shown([6.25, 6.25])
    # The shorter run stays at its end.
    inside(0, "tracerisk.clock.set(15, 'test')")
    shown([15, 9])


def test_no_other_page_is_shown():
    text = render_beside("<cell>.py", PAGES, "without.html")
    assert '["joint-dead.html", "joint-jam.html"]' in text
    assert "<cell>" not in text
