"""The evidence that the values of a controller's blocks take, and whether it fits its run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.text.digests import sha256
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.workspace.project import file_version

if TYPE_CHECKING:
    from tracerisk.adder.quantify.evidence_shares import EvidenceShares
    from tracerisk.common.evidence.cells import Evidence
    from tracerisk.config import Settings
    from tracerisk.pipeline.workspace.controller import Controller


def kept_evidence(controller: Controller) -> Evidence | None:
    """Return the evidence that is kept of a controller, `None` for none.

    Raises InputError where the file is malformed.
    """
    path = controller.root / EVIDENCE_NAME
    if not path.exists():
        return None
    return _evidence_in(path, file_version(path)).get(controller.file)


def needed_evidence(controller: Controller) -> Evidence:
    """Return the evidence that is kept of a controller, whether it is stale or not.

    Raises InputError where there is none, and as `kept_evidence`.
    """
    evidence = kept_evidence(controller)
    if evidence is None:
        raise InputError(
            f"holds no evidence of {controller.file}; `tracerisk evidence {controller.path}` "
            "gathers it",
            Location(str(controller.root / EVIDENCE_NAME)),
        )
    return evidence


@lru_cache(maxsize=1)
def _evidence_in(
    path: Path,
    version: tuple[int, ...] | None,  # noqa: ARG001 - key of the cache
) -> Mapping[str, Evidence]:
    from tracerisk.common.evidence.file import read_evidence

    return read_evidence(path)


def evidence_of_last_run(controller: Controller) -> Evidence | None:
    """Return the evidence of the run that the lock knows, at the lines of now, if it is unedited.

    Raises as `kept_evidence`.
    """
    evidence = kept_of_last_run(controller)
    if evidence is None:
        return None
    from tracerisk.pipeline.freshness.evidence_lines import at_lines_now

    return at_lines_now(evidence, controller)


def kept_of_last_run(controller: Controller) -> Evidence | None:
    """Return the evidence of the run that the lock knows, at the lines kept, if it is unedited.

    No source is read. Raises as `kept_evidence`.
    """
    evidence = kept_evidence(controller)
    entry = controller.project.lock.controllers.get(controller.file)
    if evidence is None or evidence.edited is not None or entry is None:
        return None
    from tracerisk.pipeline.freshness.run_inputs import RunInputs

    is_of_run = evidence.fingerprint == RunInputs.from_data(entry.inputs).fingerprint
    return evidence if is_of_run else None


def used_evidence(
    controller: Controller, settings: Settings, fingerprint: str
) -> EvidenceShares | None:
    """Return the evidence that values take: what the settings ask for, of this very run.

    Raises as `kept_evidence`.
    """
    evidence = _used(controller, settings, fingerprint)
    if evidence is None:
        return None
    # Few controllers have any, and a check is to begin at once.
    from tracerisk.adder.quantify.evidence_shares import EvidenceShares

    return EvidenceShares(evidence)


def _used(controller: Controller, settings: Settings, fingerprint: str) -> Evidence | None:
    if not settings.evidence:
        return None
    evidence = kept_evidence(controller)
    return (
        evidence if evidence and evidence.fingerprint == fingerprint and evidence.counts else None
    )


def evidence_digest(controller: Controller, settings: Settings, fingerprint: str) -> str:
    """Return a digest of the evidence that values take; empty where they take none."""
    used = _used(controller, settings, fingerprint)
    if used is None:
        return ""
    from tracerisk.common.evidence.file import dump_evidence

    # Cells that fill the table alone change no figure.
    drawn = replace(used, cells=tuple(cell for cell in used.cells if cell.drawn))
    return sha256(dump_evidence({controller.file: drawn}).encode())


def edited_evidence(root: Path) -> tuple[str, ...]:
    """Return what of the evidence below a root was edited, a sentence for each controller.

    A file that is malformed is one too.
    """
    path = root / EVIDENCE_NAME
    try:
        everything = _evidence_in(path, file_version(path))
    except InputError as error:
        return (f"{error}",)
    return tuple(
        f"{EVIDENCE_NAME} was edited: {item.edited.words}; `tracerisk evidence {name}` tries it "
        "again"
        for name, item in sorted(everything.items())
        if item.edited is not None
    )


def evidence_gap(controller: Controller, settings: Settings, fingerprint: str) -> str:
    """Return why values take no evidence although the settings ask for it; empty for no reason.

    Raises as `kept_evidence`.
    """
    return unfit(kept_evidence(controller), fingerprint) if settings.evidence else ""


def unfit(evidence: Evidence | None, fingerprint: str) -> str:
    """Return why the evidence kept of a controller is not that of a run; empty for no reason."""
    if evidence is None:
        return "there is none"
    if evidence.edited is not None:
        return f"it was edited: {evidence.edited.words}"
    if evidence.fingerprint != fingerprint:
        return "it is of another version of the controller, its settings or tracerisk"
    if not evidence.is_complete:
        return f"{evidence.drawn} of {evidence.declared} drawn failures are tried"
    if not evidence.success:
        return "no scenario declares `success`, what the mission is"
    return ""
