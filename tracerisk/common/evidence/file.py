"""The file of evidence, `tracerisk.evidence`: read, written and merged.

It is JSON with a cell a line, so that git shows it line by line. Each cell has a digest of itself,
and the evidence of a controller one of all that stands above its cells and of their digests: so it
shows which cell was edited, and whether one was added or removed.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, asdict, fields, replace
from pathlib import Path
from typing import Any, get_args

from tracerisk.common.evidence.cells import (
    EFFECTS,
    FATES,
    MISSED_CHECKS,
    NOTICES,
    Cell,
    Edited,
    Evidence,
    Stratum,
    Use,
)
from tracerisk.common.text.bounded import file_text
from tracerisk.common.text.digests import sha256
from tracerisk.common.traced.elements import WEAR_EXPONENTS, Exposure
from tracerisk.errors import InputError, Location, one_of

_NO_USE = Exposure()
_VERSION = 3
_WITHOUT_FATES, _WITHOUT_DIGEST = 2, 1
"""Earlier versions, which are read too; that without digests has no fates either."""
_DIGITS = 16  # of a digest: it is against mistakes, and no secret
_MOST_CELLS = 100_000
_MOST_BYTES = 64 * 1024**2
_IDLE = {"idle": True, "in use": False}
_ENTRY_KEYS = ("cells", "declared", "fingerprint", "robot", "seed", "success")


def read_evidence(path: Path) -> dict[str, Evidence]:
    """Return the evidence of each controller, by its file from the root; none without the file.

    Raises InputError with the place of what is malformed.
    """
    try:
        size = path.stat().st_size
        if size > _MOST_BYTES:
            raise InputError(
                f"has {size} bytes, more than {_MOST_BYTES}; is it an evidence file?",
                Location(str(path)),
            )
        text = file_text(path, most=_MOST_BYTES)
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read: {error}", Location(str(path))) from error
    return loads_evidence(text, str(path))


def loads_evidence(text: str, name: str) -> dict[str, Evidence]:
    """Return what the text of a file holds; raise InputError, naming it, where it is malformed."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        line = getattr(error, "lineno", None)
        raise InputError(
            f"is not an evidence file: {error}; restore it from git, or remove it and run "
            "`tracerisk evidence FILE`",
            Location(name, line),
        ) from error
    return _Reader(name).file(data)


def dump_evidence(found: Mapping[str, Evidence]) -> str:
    """Return the text of the file: sorted, a cell a line."""
    lines = ["{", f' "version": {_VERSION},', ' "controllers": {']
    for number, (name, entry) in enumerate(sorted(found.items())):
        data = _entry_data(name, entry) if entry.edited is None else entry.edited.data
        lines += [f"  {json.dumps(name)}: {{"]
        lines += [
            f"   {json.dumps(key)}: {json.dumps(data[key])},"
            for key in sorted(data)
            if key != _CELLS
        ]
        cells = [f"    {json.dumps(item)}" for item in data[_CELLS]]
        lines += ['   "cells": [', ",\n".join(cells), "   ]"] if cells else ['   "cells": []']
        lines += ["  }" if number == len(found) - 1 else "  },"]
    return "\n".join([*lines, " }", "}"]) + "\n"


def _entry_data(name: str, entry: Evidence) -> dict[str, Any]:
    names = {value: key for key, value in _IDLE.items()}
    before = [
        [unit, mode, names[is_idle], share]
        for (unit, mode, is_idle), share in sorted(entry.before.items())
    ]
    data = {
        **({"before": before} if before else {}),
        "declared": entry.declared,
        "fingerprint": entry.fingerprint,
        "robot": entry.robot,
        "seed": entry.seed,
        "success": list(entry.success),
        _CELLS: [_cell_data(item) for item in sorted(entry.cells, key=lambda cell: cell.key)],
    }
    return {**data, _DIGEST: _digest_of_entry(name, data)}


def _digest_of_entry(name: str, data: Mapping[str, Any]) -> str:
    """Return the digest of an entry: of its heading, and of the digests that its cells have."""
    head = {key: value for key, value in data.items() if key not in (_DIGEST, _CELLS)}
    cells = [fields.get(_DIGEST) if isinstance(fields, dict) else None for fields in data[_CELLS]]
    return _digest([name, head, cells])


def _digest(data: Any) -> str:
    return sha256(json.dumps(data, sort_keys=True).encode())[:_DIGITS]


def merge_evidence(files: Sequence[Path]) -> dict[str, Evidence]:
    """Return the evidence of several files, such as those of shards, as one.

    Raises InputError where two speak of other sources, robots, seeds or numbers of cells, and where
    one was edited.
    """
    merged: dict[str, Evidence] = {}
    for path in files:
        if not path.exists():
            raise InputError("does not exist", Location(str(path)))
        for name, evidence in read_evidence(path).items():
            if evidence.edited is not None:
                raise InputError(
                    f"the evidence of {name} was edited: {evidence.edited.words}; rerun `tracerisk "
                    f"evidence {name}` with the options of that campaign",
                    Location(str(path)),
                )
            ours = merged.get(name)
            if ours is None:
                merged[name] = evidence
                continue
            if replace(evidence, cells=(), has_digest=True) != replace(
                ours, cells=(), has_digest=True
            ):
                raise InputError(
                    f"the evidence of {name} is from another campaign than the earlier evidence: "
                    "sources, robot, seed, success criterion or number of cells differ",
                    Location(str(path)),
                )
            cells = {cell.key: cell for cell in (*ours.cells, *evidence.cells)}
            ordered = tuple(cells[key] for key in sorted(cells))
            has_digest = ours.has_digest and evidence.has_digest
            merged[name] = replace(ours, cells=ordered, has_digest=has_digest)
    return merged


def cell_line(cell: Cell) -> str:
    """Return a cell as one line of JSON, with its digest: what is as by default is left out."""
    return json.dumps(_cell_data(cell))


def parse_cell(text: str, where: Location) -> Cell:
    """Read a line of `cell_line`; raise InputError where it is none, or was edited."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not a cell of an evidence file: {error}", where) from error
    cell = _cell(data, where)
    if not _is_as_written(data):
        raise InputError("a cell that does not match its digest", where)
    return cell


def _cell_data(cell: Cell) -> dict[str, Any]:
    data = asdict(cell)
    stretch = {key: value for key, value in data["stretch"].items() if value != _AT_REST[key]}
    data["stretch"] = stretch or None
    table = {key: data[key] for key in data if data[key] != _DEFAULTS.get(key, _NONE)}
    return {**table, _DIGEST: _digest(table)}


def _is_as_written(data: Mapping[str, Any]) -> bool:
    """Return whether a cell fits its digest."""
    return data.get(_DIGEST) == _digest({k: v for k, v in data.items() if k != _DIGEST})


_DIGEST, _CELLS = "digest", "cells"
_NONE = object()
_AT_REST = asdict(_NO_USE)
# A stretch is written as what it counts, and left out where there is none.
_DEFAULTS: dict[str, Any] = {
    **{entry.name: entry.default for entry in fields(Cell) if entry.default is not MISSING},
    "stretch": None,
}


_PLACE = re.compile(r".+:[0-9]{1,9}")
_TEXTS = (
    *("component", "unit", "mode", "function", "shows_in", "next_function", "local", "told_by"),
    *("contact", "missed_at"),
)
_CHOICES: dict[str, tuple[Any, ...]] = {
    "effect": EFFECTS,
    "use": get_args(Use),
    "fate": (*FATES, None),
    "noticed_by": (*NOTICES, None),
    "missed_check": (*MISSED_CHECKS, None),
}
"""The values that a field may have; `None` for a field that may be missing."""


class _Reader:
    def __init__(self, name: str) -> None:
        self._where = Location(name)
        self._has_digest = True

    def file(self, data: Any) -> dict[str, Evidence]:
        if not isinstance(data, dict) or not isinstance(data.get("controllers"), dict):
            raise self._error("expected an object with 'version' and 'controllers'")
        if data.get("version") not in (_VERSION, _WITHOUT_FATES, _WITHOUT_DIGEST):
            raise self._error(
                f"has version {data.get('version')!r}; this tracerisk reads version {_VERSION}"
            )
        self._has_digest = data["version"] != _WITHOUT_DIGEST
        return {name: self._entry(name, item) for name, item in data["controllers"].items()}

    def _error(self, message: str) -> InputError:
        return InputError(message, self._where)

    def _entry(self, name: str, data: Any) -> Evidence:
        if not isinstance(data, dict):
            raise self._error(f"{name}: expected an object")
        missing = [key for key in _ENTRY_KEYS if key not in data]
        if missing:
            raise self._error(f"{name}: {missing[0]} is missing")
        cells, success = data["cells"], data["success"]
        if not isinstance(cells, list) or len(cells) > _MOST_CELLS:
            raise self._error(f"{name}: cells: expected a list of at most {_MOST_CELLS}")
        if not isinstance(success, list):
            raise self._error(f"{name}: success: expected a list")
        for key in ("declared", "seed"):
            if not isinstance(data[key], int) or isinstance(data[key], bool) or data[key] < 0:
                raise self._error(f"{name}: {key}: expected a whole number, 0 or more")
        read = tuple(_cell(cell, self._where) for cell in cells)
        if len({cell.key for cell in read}) != len(read):
            raise self._error(
                f"{name}: duplicate cells; `tracerisk evidence --fresh` recreates the file"
            )
        evidence = Evidence(
            fingerprint=str(data["fingerprint"]),
            robot=str(data["robot"]),
            seed=data["seed"],
            declared=data["declared"],
            success=tuple(map(str, success)),
            cells=read,
            before=self._before(name, data.get("before", [])),
            has_digest=self._has_digest,
        )
        return self._as_written(name, evidence, data) if self._has_digest else evidence

    def _as_written(self, name: str, found: Evidence, data: Mapping[str, Any]) -> Evidence:
        """Return what of an entry fits its digests."""
        if data.get(_DIGEST) != _digest_of_entry(name, data):
            what = "its heading was changed, or failures were added, removed or reordered"
            return replace(found, cells=(), before={}, edited=Edited(what, data))
        pairs = list(zip(found.cells, data[_CELLS], strict=True))
        edited = [cell for cell, pair in pairs if not _is_as_written(pair)]
        if not edited:
            return found
        one = edited[0]
        what = f"the failure of {one.unit} ({one.mode}) at {one.time_s:g} s was changed"
        if len(edited) > 1:
            what += f", and {len(edited) - 1} more"
        kept = tuple(cell for cell, pair in pairs if _is_as_written(pair))
        return replace(found, cells=kept, edited=Edited(what, data))

    def _before(self, name: str, data: Any) -> dict[Stratum, float]:
        before = {}
        rows = data if isinstance(data, list) else [data]
        for row in rows:
            match row:
                case [str(unit), str(mode), "idle" | "in use" as use, int() | float() as share] if (
                    0.0 <= share <= 1.0 and not isinstance(share, bool)
                ):
                    before[unit, mode, _IDLE[use]] = float(share)
                case _:
                    raise self._error(
                        f"{name}: before: expected rows of a unit, a mode, 'idle' or 'in use', and "
                        f"a share from 0 to 1, not {row!r:.60}"
                    )
        return before


def _cell(data: Any, where: Location) -> Cell:
    if not isinstance(data, dict):
        raise InputError("a cell: expected an object", where)
    known = [entry.name for entry in fields(Cell)]
    unknown = sorted(set(data) - {*known, _DIGEST})
    if unknown:
        raise InputError(f"a cell: unknown key '{unknown[0]}'; {one_of(known, unknown[0])}", where)
    given = {**_DEFAULTS, **{key: value for key, value in data.items() if key != _DIGEST}}
    missing = [key for key in known if key not in given]
    if missing:
        raise InputError(f"a cell: {missing[0]} is missing", where)
    for key, allowed in _CHOICES.items():
        if given[key] not in allowed:
            names = [name for name in allowed if name is not None]
            raise InputError(f"a cell: {key} {given[key]!r}; {one_of(names)}", where)
    for key in ("drawn", "fails"):
        if not isinstance(given[key], bool):
            raise InputError(f"a cell: {key}: expected true or false", where)
    for key in ("lost", "effects"):
        texts = given[key]
        if not isinstance(texts, list | tuple) or not all(isinstance(text, str) for text in texts):
            raise InputError(f"a cell: {key}: expected a list of strings, not {texts!r:.60}", where)
    if not set(given["effects"]) <= set(EFFECTS):
        raise InputError(f"a cell: effects {given['effects']!r:.60}; {one_of(EFFECTS)}", where)
    for key in _TEXTS:
        if not isinstance(given[key], str):
            raise InputError(f"a cell: {key}: expected a string, not {given[key]!r:.60}", where)
    if given["missed_at"] and not _PLACE.fullmatch(given["missed_at"]):
        words = f"expected file:line, not {given['missed_at']!r:.60}"
        raise InputError(f"a cell: missed_at: {words}", where)
    for key in ("noticed_s", "told_after_s", "effect_after_s", "followed_s"):
        if given[key] is not None:
            given[key] = _seconds(given[key], key, where)
    return Cell(
        **{
            **given,
            "time_s": _seconds(given["time_s"], "time_s", where),
            "active_s": _seconds(given["active_s"], "active_s", where),
            "states_s": _three(given["states_s"], where),
            "stretch": _exposure(given["stretch"], where),
            "idle_s": _seconds(given["idle_s"], "idle_s", where),
            "lost": tuple(given["lost"]),
            "effects": tuple(given["effects"]),
        }
    )


def _exposure(data: Any, where: Location) -> Exposure:
    if data is None:
        return _NO_USE
    if not isinstance(data, dict):
        raise InputError("stretch: expected an object", where)
    unknown = sorted(set(data) - set(_AT_REST))
    if unknown:
        raise InputError(
            f"stretch: unknown key '{unknown[0]}'; {one_of(sorted(_AT_REST), unknown[0])}", where
        )
    given: dict[str, Any] = {}
    for key, value in data.items():
        if key == "wear":
            if not isinstance(value, list) or len(value) not in (0, len(WEAR_EXPONENTS)):
                raise InputError(f"wear: expected {len(WEAR_EXPONENTS)} numbers", where)
            given[key] = tuple(_seconds(item, key, where) for item in value)
        elif isinstance(_AT_REST[key], bool):
            given[key] = bool(value)
        elif isinstance(_AT_REST[key], int):
            given[key] = round(_seconds(value, key, where))
        else:
            given[key] = _seconds(value, key, where)
    return Exposure(**given)


def _seconds(value: Any, name: str, where: Location) -> float:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not 0.0 <= value <= 1e9:
        raise InputError(f"{name}: expected seconds from 0 to 1e9, not {value!r}", where)
    return float(value)


def _three(value: Any, where: Location) -> tuple[float, float, float]:
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 3:
        raise InputError("states_s: expected three times in seconds", where)
    moving, holding, grasping = (_seconds(item, "states_s", where) for item in value)
    return moving, holding, grasping
