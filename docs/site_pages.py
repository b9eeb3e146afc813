"""What mkdocs does not do by itself for the documentation site.

It shows pages that stand at the top of the repository, names the version that they are of, and
writes formulas as MathML, which browsers typeset without a script.
"""

from __future__ import annotations

import html
import os
import posixpath
import re
from importlib.metadata import version
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

FROM_THE_TOP = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "CONTRIBUTING.md",
    "CHANGELOG.md": "CHANGELOG.md",
}
"""What is shown of the top of the repository, and as which page."""

_LINK = re.compile(r"\]\(([^)#:\s]+)(#[^)\s]*)?\)")
_FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Name the version, or let `mike`, which publishes several beside each other, offer them."""
    if "MIKE_DOCS_VERSION" in os.environ:
        config.extra["version"] = {"provider": "mike"}
    else:
        config.site_name += f" {version('tracerisk')}"
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages, with their links as they are from within `docs/`."""
    top = Path(config.config_file_path).parent
    for name, page in FROM_THE_TOP.items():
        text = (top / name).read_text(encoding="utf-8")
        files.append(File.generated(config, page, content=_LINK.sub(_from_docs, text)))
    return files


def on_page_markdown(markdown: str, **_: object) -> str:
    """Lead links out of `docs/` to the pages that stand for what they name."""
    for name, page in FROM_THE_TOP.items():
        markdown = markdown.replace(f"](../{name}", f"]({page}")
    return markdown


def on_page_content(content: str, **_: object) -> str:
    """Write formulas as MathML."""
    return _FORMULA.sub(_mathml, content)


def on_post_page(output: str, **_: object) -> str:
    """Give the dialog of the search a name, which the theme leaves out."""
    dialog = 'data-md-component="search" role="dialog"'
    return output.replace(dialog, f'{dialog} aria-label="Search"')


def _mathml(formula: re.Match[str]) -> str:
    display = "block" if formula[1] == "div" else "inline"
    return convert(html.unescape(formula[2]), display=display)


def _from_docs(link: re.Match[str]) -> str:
    target, anchor = link[1], link[2] or ""
    page = FROM_THE_TOP.get(target) or posixpath.relpath(target, "docs")
    return f"]({page}{anchor})"
