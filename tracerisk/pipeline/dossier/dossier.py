"""The dossier: all that an assessor needs to recompute a figure, in one archive."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.adder.figures.derive import derive_function
from tracerisk.adder.sources.read import read_blocks
from tracerisk.common import trace_json
from tracerisk.common.hardware.shipped import shipped_bytes
from tracerisk.common.text.digests import sha256
from tracerisk.common.text.printable import printable_json, without_controls
from tracerisk.errors import InputError, Location
from tracerisk.instrument.source.language import is_c_like
from tracerisk.pipeline.dossier.assumptions import assumptions
from tracerisk.pipeline.dossier.calculation import hand_calculation
from tracerisk.pipeline.dossier.environment import environment
from tracerisk.pipeline.dossier.guide import CONSTRAINTS, guide, packed_name
from tracerisk.pipeline.dossier.record import whole_file
from tracerisk.pipeline.dossier.sheet import sheet
from tracerisk.pipeline.freshness.run_inputs import settings_data
from tracerisk.prm.formats import model_json
from tracerisk.prm.hybrid.mission_tree import MissionTree, mission_tree
from tracerisk.prm.other_models.formats.conversion import logic_of_functions, logic_of_tree
from tracerisk.prm.other_models.formats.open_psa.writer import dumps_open_psa
from tracerisk.report.html.record import report_record

if TYPE_CHECKING:
    from tracerisk.adder.blocks.block import RiskBlock
    from tracerisk.adder.figures.derivation import FunctionDerivation
    from tracerisk.adder.quantify.evidence_shares import EvidenceShares
    from tracerisk.common.record import RecordedFile
    from tracerisk.config import ActiveMode, Settings
    from tracerisk.report.html.report_input import ReportInput

FUNCTIONS, MISSION, MODEL = "model/functions.xml", "model/mission.xml", "model/model.json"
CALCULATION, ASSUMPTIONS, GUIDE = "calculation.md", "assumptions.md", "README.md"
SHEET = "sheet.md"
REPORT, RECORD, TRACE, DIGESTS = "report.html", "record.json", "trace.json", "SHA256SUMS"
_ROUNDED = 1e-3  # relative; blocks have four digits
_DATE = (1980, 1, 1, 0, 0, 0)  # the first that an archive can hold
_MODE = 0o100644 << 16


def dossier(
    report: ReportInput,
    page: str,
    root: Path,
    *,
    settings: Settings,
    evidence: EvidenceShares | None = None,
) -> bytes:
    """Return the archive; the same report gives the same bytes.

    `page` is the report as HTML, `root` the folder from which its record names files; `settings`
    and `evidence` are what its blocks were computed with.
    Raises InputError for a file that has changed since the record was made, or a block that does
    not follow from the run; ModelError for a model without a component.
    """
    assert report.record is not None, "a dossier is of a report with its record"
    here, mission = environment(), mission_tree(report.model)
    derivations = _derivations(report, root, settings.active, evidence)
    if not isinstance(derivations, str):
        assert report.trace is not None, "the derivations are of it"
        _check_follow(derivations, settings.tolerance, report.trace.controller)
    calculation = hand_calculation(report.model, report.assessment, mission, derivations)
    files = _files(report, root)
    sources = {
        file.path: files[packed_name(file.path)]
        for file in report.record.files
        if file.role == "source"
    }
    held = assumptions(report, _other_than_default(settings, root), sources)
    contents: dict[str, bytes] = {
        REPORT: page.encode(),
        RECORD: _json({**report_record(report), "environment": asdict(here)}),
        CONSTRAINTS: here.constraints.encode(),
        CALCULATION: _text(calculation),
        SHEET: _text(sheet(report)),
        ASSUMPTIONS: _text(held),
        MODEL: model_json.dumps(report.model).encode(),
        **_open_psa(report, mission),
        **files,
    }
    if report.trace is not None:
        contents[TRACE] = trace_json.dumps(report.trace).encode()
    contents[GUIDE] = _text(guide(report, mission, [*contents, GUIDE, DIGESTS], here))
    lines = [f"{sha256(data)}  {name}\n" for name, data in sorted(contents.items())]
    contents[DIGESTS] = "".join(lines).encode()
    return _archive(contents)


def _other_than_default(settings: Settings, root: Path) -> dict[str, object]:
    """Return the settings that a figure depends on and that are not the default."""
    data = settings_data(settings, root.resolve())
    return {name: value for name, value in data.items() if name not in ("tracerisk", "accept")}


def _check_follow(
    derivations: Sequence[FunctionDerivation], tolerance: float, controller: str
) -> None:
    """Raise InputError at a block whose value the run of a controller does not give."""
    for function in derivations:
        for component in function.components:
            block = component.block
            if block is None or not block.is_kept:
                continue
            text, computed = float(block.text), float(block.computed)
            if abs(text - computed) > (tolerance + _ROUNDED) * max(text, computed):
                raise InputError(
                    f"the block of {function.function} says {block.text} of {component.name},"
                    f" and this run gives {block.computed}: the run is of other sources or other "
                    "hardware data, or one of the two was changed by hand; "
                    f"`tracerisk run {controller}` makes both again",
                    Location(function.file),
                )


def _text(text: str) -> bytes:
    return without_controls(text).encode()


def _open_psa(report: ReportInput, mission: MissionTree | None) -> dict[str, bytes]:
    texts = {FUNCTIONS: dumps_open_psa(logic_of_functions(report.model)).encode()}
    if mission is not None:
        logic = logic_of_tree(mission.tree, mission.figures, name=report.model.name)
        texts[MISSION] = dumps_open_psa(logic).encode()
    return texts


def _derivations(
    report: ReportInput, root: Path, active: ActiveMode, evidence: EvidenceShares | None
) -> Sequence[FunctionDerivation] | str:
    """Return how the blocks follow from the run, or why that is not known."""
    trace, hardware = report.trace, report.hardware
    if trace is None or hardware is None:
        return report.no_trace

    blocks = _blocks(report)
    root = root.resolve()
    return [
        derive_function(
            trace,
            hardware,
            function.ref,
            active=active,
            block=blocks.get((root / function.ref.file, function.ref.name)),
            evidence=evidence,
        )
        for function in trace.functions
    ]


def _blocks(report: ReportInput) -> Mapping[tuple[Path, str], RiskBlock]:
    """Return the blocks of Python sources, by file and function."""
    paths = [Path(source.name) for source in report.sources if not is_c_like(source.name)]
    return {
        (path.resolve(), placed.function): placed.block
        for path in paths
        for placed in read_blocks(whole_file(path), str(path))
    }


def _files(report: ReportInput, root: Path) -> dict[str, bytes]:
    """Return the files of the record, with their names in the archive."""
    assert report.record is not None
    files: dict[str, bytes] = {}
    for file in report.record.files:
        name = base = packed_name(file.path)
        number = 1
        while name in files:
            number += 1
            name = f"{base}.{number}"
        files[name] = _bytes_of(file, report, root)
    return files


def _bytes_of(file: RecordedFile, report: ReportInput, root: Path) -> bytes:
    if file.state == "with tracerisk":
        assert report.hardware is not None, "a shipped description is one"
        return shipped_bytes(report.hardware)
    path = root / file.path
    data = whole_file(path)
    if sha256(data) != file.sha256:
        raise InputError(
            "has changed while the dossier was made; make it again", Location(str(path))
        )
    return data


def _json(value: object) -> bytes:
    text = json.dumps(value, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False)
    return f"{printable_json(text)}\n".encode()


def _archive(contents: Mapping[str, bytes]) -> bytes:
    """Return the archive, the same for the same contents."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in sorted(contents.items()):
            entry = zipfile.ZipInfo(name, _DATE)
            entry.external_attr, entry.create_system = _MODE, 3
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data, compresslevel=9)
    return stream.getvalue()
