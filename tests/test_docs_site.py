"""The documentation as a whole: the site builds without a warning, links and names lead somewhere."""

import os
import re
import subprocess
import sys
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from tests.browser import emulate, requests, violations

ROOT = Path(__file__).parents[1]
PAGES = sorted([*(ROOT / "docs").glob("*.md"), *ROOT.glob("*.md")])
THEORY = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, built from what is here."""
    if find_spec("material") is None or find_spec("mkdocs") is None:
        pytest.skip("mkdocs-material is not installed (extra docs)")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder],
        cwd=ROOT,
        capture_output=True,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    return folder


def test_the_site_has_every_page(site):
    for page in PAGES:
        name = "index" if page.name == "README.md" else page.stem
        assert (site / f"{name}.html").exists(), page.name


def test_the_site_asks_nothing_of_the_network(site):
    asked = re.compile(r"<(?:script|link|img|iframe)\b[^>]*?\b(?:src|href)=\"?(?:https?:)?//[^>]*>")
    for page in site.rglob("*.html"):
        assert asked.findall(page.read_text(encoding="utf-8")) == [], page.name


@pytest.fixture
def opened(browser, site):
    """The site in the browser, from the disk; and what the browser fetched and complained of."""

    def open_page(name: str, scheme: str = "light") -> Any:
        browser.get("about:blank")
        emulate(browser, scheme)
        browser.get_log("performance")
        browser.get_log("browser")
        browser.get((site / name).as_uri())
        browser.execute_script("localStorage.clear()")
        return browser

    yield open_page
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    emulate(browser, "light")


def test_the_search_finds_pages_from_a_disk(opened, site):
    page = opened("index.html")
    page.execute_script("document.querySelector('#__search').click()")
    page.find_element("css selector", ".md-search__input").send_keys("common cause")
    wait = pytest.importorskip("selenium.webdriver.support.wait").WebDriverWait(page, 20)
    hits = wait.until(lambda p: p.find_elements("css selector", ".md-search-result__link"))
    assert any("theory.html" in hit.get_attribute("href") for hit in hits)
    fetched = [url for url in requests(page) if not url.startswith("data:")]
    assert len(fetched) > 3
    assert [url for url in fetched if not url.startswith(site.as_uri())] == []
    assert page.get_log("browser") == []


def test_light_and_dark_are_chosen_in_turn(opened):
    page = opened("index.html", "dark")
    shown = "return getComputedStyle(document.body).backgroundColor"
    dark, colours = page.execute_script(shown), []
    for _ in range(3):
        page.execute_script(
            "[...document.querySelectorAll('[data-md-component=palette] label')]"
            ".find(label => !label.hidden).click()"
        )
        colours.append(page.execute_script(shown))
    light, chosen_dark, as_the_system = colours
    assert light != dark
    assert chosen_dark == as_the_system == dark


def test_paper_is_light_whatever_the_screen(opened):
    page = opened("tutorial.html", "dark")
    emulate(page, "dark", "print")
    colours = page.execute_script(
        "const link = document.querySelector('.md-content p a');"
        "return [document.body, link].map((e, i) =>"
        " getComputedStyle(e)[i ? 'color' : 'backgroundColor'].match(/\\d+/g).map(Number))"
    )
    paper, ink = (sum(colour[:3]) for colour in colours)
    assert paper == 3 * 255
    assert ink < 400


@pytest.mark.slow(but=3)
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["index", "tutorial", "command", "formats", "python"])
def test_axe_finds_nothing_serious(opened, name, scheme):
    page = opened(f"{name}.html", scheme)
    serious, reported = violations(page, scheme)
    assert not serious, reported


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("name", ["index", "theory", "behaviours", "hardware", "gallery"])
def test_no_page_is_wider_than_a_phone(opened, name):
    page = opened(f"{name}.html")
    metrics = {"width": 400, "height": 900, "deviceScaleFactor": 1, "mobile": True}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    assert page.execute_script("return document.documentElement.scrollWidth") <= 400


def test_every_formula_is_typeset(site):
    page = (site / "theory.html").read_text(encoding="utf-8")
    assert page.count("<math") > 100
    assert "arithmatex" not in page
    assert re.findall(r"<m[io][^>]*>\\\w+</m[io]>", page) == [], "a command that is not known"


def test_the_site_says_of_which_version_it_is(site):
    name = re.escape(f"tracerisk {version('tracerisk')}")
    assert re.search(f"<title>[^<]*{name}</title>", (site / "index.html").read_text("utf-8"))


def headings(page: Path) -> set[str]:
    """The anchors of a page, as GitHub and the site make them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title).strip().lower().replace(" ", "-") for title in titles}


@pytest.mark.slow(but=12)
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere_in_plain_markdown_too(page):
    text = re.sub(r"^```.*?^```$", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    for path, anchor in re.findall(r"\]\(((?!https?:)[^)#\s]*)(?:#([^)\s]+))?\)", text):
        target = page if not path else (page.parent / path)
        assert target.exists(), f"{page.name}: {path}"
        if anchor:
            assert anchor in headings(target), f"{page.name}: {path}#{anchor}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_of_this_repository_that_a_page_names_are_there(page):
    text = page.read_text(encoding="utf-8")
    named = re.findall(
        r"`((?:tracerisk|tests|benchmarks|sample_controllers|docs|action)/[\w./*-]*)`", text
    )
    if page.name == "theory.md":
        named += [
            f"tracerisk/{name}" for name in re.findall(r"`((?:prm|pipeline)/[\w./*]*)`", text)
        ]
    for name in named:
        assert list(ROOT.glob(name.rstrip("/"))), f"{page.name}: {name}"


def test_every_section_of_the_theory_says_where_its_code_is():
    rows = re.findall(r"^\| \[([^]]+)\]\(#[\w-]+\) \| (.*) \|$", THEORY, re.MULTILINE)
    sections = re.findall(r"^## (.*)$", THEORY, re.MULTILINE)
    assert [title for title, _ in rows] == sections[2:]
    assert sections[:2] == ["What is computed", "Where it stands in the code"]
    assert all(re.findall(r"`tracerisk/[\w/]+(?:\.py|/)`", code) for _, code in rows)
