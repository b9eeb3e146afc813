"""The documentation as a whole: the site builds without a warning, links and names lead somewhere."""

import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

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


def headings(page: Path) -> set[str]:
    """The anchors of a page, as GitHub and the site make them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title).strip().lower().replace(" ", "-") for title in titles}


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
