"""What of the metadata is made when a distribution is built: the long description and its links."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

REPOSITORY = "TRACERISK_REPOSITORY"
"""The variable that says where the repository is; without it there are no links to it."""

_LINK = re.compile(r"\]\((?!https?:|#)([^)\s]+)\)")
_PICTURE = re.compile(r"(!\[[^\]]*\])\((?!https?:)([^)\s]+)\)")
_VERSION = re.compile(r'^__version__ = "(.+)"$', re.MULTILINE)


class CustomMetadataHook(MetadataHookInterface):
    """Takes the README with absolute links, and names the pages of the repository."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set `readme` and `urls`; raise ValueError where tag and package differ in the version."""
        root = Path(self.root)
        version = metadata["version"]
        said = _VERSION.search((root / "tracerisk" / "__init__.py").read_text(encoding="utf-8"))
        is_release = re.fullmatch(r"[0-9.]+", version) is not None
        if is_release and (said is None or said[1] != version):
            raise ValueError(
                f"the tag says version {version}, but tracerisk/__init__.py has "
                f"{said[1] if said else 'none'}: they are changed together, see CONTRIBUTING.md"
            )
        text = (root / "README.md").read_text(encoding="utf-8")
        repository = os.environ.get(REPOSITORY, "").rstrip("/")
        if repository:
            files = f"{repository}/blob/{f'v{version}' if is_release else 'HEAD'}"
            # A page about a file is no picture: those are taken as they are.
            text = _PICTURE.sub(rf"\1({files.replace('/blob/', '/raw/', 1)}/\2)", text)
            text = _LINK.sub(rf"]({files}/\1)", text)
            metadata["urls"] = {
                "Documentation": f"{files}/docs/tutorial.md",
                "Source": repository,
                "Changelog": f"{files}/CHANGELOG.md",
                "Issues": f"{repository}/issues",
            }
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
