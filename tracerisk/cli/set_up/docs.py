"""`tracerisk docs`: print a page of the documentation, or list the pages."""

from __future__ import annotations

import argparse
import re
import zipfile
from pathlib import Path

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import print_json, show, terminal_width, use_color
from tracerisk.errors import InputError, one_of

PACKED = "pages.zip"
"""The pages in an installed package, beside this file; a checkout has them in `docs/`."""

_CHECKOUT = Path(__file__).parents[3] / "docs"
_HEADING = re.compile(r"^(#+) (.+)$", re.MULTILINE)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "page",
        metavar="PAGE[#SECTION]",
        nargs="?",
        help="page to print, such as howto-robot or theory#groups (default: list all)",
    )
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    if options.page is None:
        titles = {name: _title(page_text(name)) for name in page_names()}
        if options.json:
            pages = [{"name": name, "title": title} for name, title in titles.items()]
            print_json("docs", pages=pages)
        else:
            width = max(map(len, titles))
            show(*(f"{name:{width}}  {title}" for name, title in titles.items()))
        return 0
    asked, _, section = options.page.partition("#")
    name = asked.removeprefix("docs/").removesuffix(".md")
    if name not in page_names():
        raise InputError(f"unknown page '{asked}'; {one_of(page_names(), name)}")
    text = page_text(name)
    if section:
        text = section_of(text, section)
        if not text:
            slugs = [_slug(heading[2]) for heading in _HEADING.finditer(page_text(name))]
            raise InputError(f"'{name}' has no section '{section}'; {one_of(slugs, section)}")
    if options.json:
        print_json("docs", page=name, section=section or None, text=text)
    elif use_color():
        _print_styled(text)
    else:
        print(text, end="")
    return 0


def page_names() -> list[str]:
    """Return the names of all pages, sorted."""
    names = (path.name for path in _folder().iterdir())
    return sorted(name.removesuffix(".md") for name in names if name.endswith(".md"))


def page_text(name: str) -> str:
    """Return the text of a page, which there is, as Markdown."""
    return (_folder() / f"{name}.md").read_text(encoding="utf-8")


def _folder() -> Path | zipfile.Path:
    packed = Path(__file__).with_name(PACKED)
    return zipfile.Path(packed) if packed.is_file() else _CHECKOUT


def section_of(text: str, slug: str) -> str:
    """Return a section with those below it, by the anchor of its heading; "" if there is none."""
    headings = list(_HEADING.finditer(text))
    for number, heading in enumerate(headings):
        if _slug(heading[2]) == slug:
            level = len(heading[1])
            ends = (after.start() for after in headings[number + 1 :] if len(after[1]) <= level)
            return text[heading.start() : next(ends, len(text))]
    return ""


def _slug(heading: str) -> str:
    """Return the anchor of a heading, as sites of documentation make it."""
    return re.sub(r"\s+", "-", re.sub(r"[^\w\s-]", "", heading.lower()).strip())


def _title(text: str) -> str:
    heading = _HEADING.search(text)
    return heading[2] if heading is not None else ""


def _print_styled(text: str) -> None:
    from rich.console import Console
    from rich.markdown import Markdown

    Console(width=terminal_width(), force_terminal=True).print(Markdown(text))
