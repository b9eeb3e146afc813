"""Pages of the documentation site that stand at the top of the repository, for mkdocs."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

FROM_THE_TOP = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "CONTRIBUTING.md",
    "CHANGELOG.md": "CHANGELOG.md",
}
"""What is shown of the top of the repository, and as which page."""

_LINK = re.compile(r"\]\(([^)#:\s]+)(#[^)\s]*)?\)")


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


def _from_docs(link: re.Match[str]) -> str:
    target, anchor = link[1], link[2] or ""
    page = FROM_THE_TOP.get(target) or posixpath.relpath(target, "docs")
    return f"]({page}{anchor})"
