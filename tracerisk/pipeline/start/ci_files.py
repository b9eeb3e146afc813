"""The files by which GitHub and GitLab check the blocks and compare changes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata, resources
from pathlib import Path
from typing import Literal

from tracerisk.common.text.bounded import file_text

Ci = Literal["github", "gitlab", "none"]

_ON_GITHUB = re.compile(r"Source, (https://github\.com/([\w.-]+/[\w.-]+?))(?:\.git)?/?")
_FROM_INDEX = "tracerisk[large]"
"""What the job of GitLab installs by default."""
_GITLAB_JOB = "tracerisk.gitlab-ci.yml"
_INCLUDE = f"include: {{local: {_GITLAB_JOB}}}"
_WHY = "CI: checks the blocks, and says what a change does to the risk, in "


@dataclass(frozen=True, slots=True)
class StartFile:
    """A file that is to be written."""

    path: str
    """The path from the root."""
    content: bytes
    """The whole new content."""
    why: str
    """What the file is for, in words."""
    is_new: bool = True
    """Whether the file does not exist yet; false where lines are added to it."""


@dataclass(frozen=True, slots=True)
class Origin:
    """Where the installed package comes from."""

    repository: str
    """Address of its repository on GitHub; empty where that is unknown."""
    name: str
    """The repository as GitHub has it, such as `cell/tracerisk`."""
    version: str
    """The version of the package."""

    @property
    def is_release(self) -> bool:
        """Whether the version is one that was published."""
        return re.fullmatch(r"[0-9.]+", self.version) is not None

    @property
    def action(self) -> str:
        """How a workflow of GitHub names our Action."""
        if not self.repository:
            return "OWNER/tracerisk@v0.1.0"
        return f"{self.name}@{self._revision}"

    @property
    def package(self) -> str:
        """What pip installs in the job of GitLab."""
        if self.is_release:
            return f"{_FROM_INDEX}=={self.version}"
        if not self.repository:
            return _FROM_INDEX
        return f"{_FROM_INDEX} @ git+{self.repository}@{self._revision}"

    @property
    def _revision(self) -> str:
        return f"v{self.version}" if self.is_release else "main"


def origin() -> Origin:
    """Return where the installed package came from, by its metadata."""
    try:
        urls = metadata.metadata("tracerisk").get_all("Project-URL") or []
        version = metadata.version("tracerisk")
    except metadata.PackageNotFoundError:
        return Origin("", "", "")
    fullmatches = (_ON_GITHUB.fullmatch(url) for url in urls)
    source = next((hit for hit in fullmatches if hit is not None), None)
    return Origin("", "", version) if source is None else Origin(source[1], source[2], version)


def ci_files(root: Path, ci: Ci) -> Iterator[StartFile]:
    """Yield the files of a CI that a repository lacks."""
    if ci == "github":
        files = [_on_github()]
    elif ci == "gitlab":
        files = _on_gitlab(root)
    else:
        files = []
    yield from (file for file in files if not (root / file.path).exists())


def _on_github() -> StartFile:
    where = origin()
    why = f"{_WHY}a comment on the pull request"
    if not where.repository:
        why += "; replace OWNER in it by who keeps tracerisk, and the tag by one that is there"
    content = template("github.yaml").replace(b"ACTION", where.action.encode())
    return StartFile(".github/workflows/risk.yml", content, why)


def _on_gitlab(root: Path) -> list[StartFile]:
    """Return the job, and the file that includes it, which may hold jobs of the user."""
    package = origin().package
    why = f"{_WHY}a note on the merge request where TRACERISK_TOKEN is set"
    if package == _FROM_INDEX:
        why += "; set TRACERISK_PACKAGE to where you keep tracerisk"
    own = root / ".gitlab-ci.yml"
    if own.exists() and _GITLAB_JOB not in file_text(own, errors="replace"):
        why += f"; add to .gitlab-ci.yml: {_INCLUDE}"
    job = template("gitlab.yaml").replace(
        f'TRACERISK_PACKAGE: "{_FROM_INDEX}"'.encode(), f'TRACERISK_PACKAGE: "{package}"'.encode()
    )
    included = StartFile(own.name, f"{_INCLUDE}\n".encode(), f"includes {_GITLAB_JOB}")
    return [StartFile(_GITLAB_JOB, job, why), included]


def template(name: str) -> bytes:
    """Return a file as it is shipped."""
    return resources.files("tracerisk.pipeline.start").joinpath(f"templates/{name}").read_bytes()
