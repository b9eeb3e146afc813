"""Names as the OpenPRA engine takes them, and a table of those that were others before.

The engine refuses a name with a dot. It gives each operation of a fault tree T a gate `T_g1`,
`T_g2`, ..., and each tree a gate of its own name: an event may have none of these.
It names a sequence by its end state, so that no two may end alike.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from tracerisk.prm.formats.element import Element

_PLAIN = re.compile(r"\w[\w-]*")
_OTHER = re.compile(r"[^\w-]+")
_GATE = re.compile(r"(.+)_g\d+")

Slot = tuple[dict[str, Any], str]
"""An object of the JSON and the key under which it holds a name."""


def name_for_engine(model: dict[str, Any]) -> dict[str, dict[str, str]]:
    """Give a model's data names that the engine takes.

    Returns the names before by those now, of elements (`names`) and of ends (`endStates`), where
    they differ.
    """
    trees = [tree["name"] for tree in model.get("faultTrees", ())]
    written = _written(dict.fromkeys(owner[key] for owner, key in _slots(model)), trees)
    for owner, key in _slots(model):
        owner[key] = written[owner[key]]
    ends = _name_ends(model)
    names = {new: name for name, new in written.items() if new != name}
    return {key: table for key, table in (("names", names), ("endStates", ends)) if table}


def restore_names(model: Element, tables: Element) -> None:
    """Give a model's data the names that the tables beside it hold.

    Raises ModelError, with the path, where a table is malformed.
    """
    fields = tables.fields((), optional={"names", "endStates", "houseEvents", "ccfGroups"})
    names, ends = (
        {key: item.string() for key, item in fields[table].entries().items()}
        if table in fields
        else {}
        for table in ("names", "endStates")
    )
    data = model.value if isinstance(model.value, dict) else {}
    for owner, key in _slots(data):
        owner[key] = names.get(owner[key], owner[key])
    for sequence in _sequences(data):
        end = sequence.get("endState")
        if isinstance(end, str):
            sequence["endState"] = ends.get(end, end)


def _written(names: Mapping[str, None], trees: list[str]) -> dict[str, str]:
    """Return the name for the engine of each; plain ones stay as they are."""
    stems = {*trees, *map(_plain, trees)}

    def is_gate(name: str) -> bool:
        matched = _GATE.fullmatch(name)
        return matched is not None and matched[1] in stems

    written = {name: name for name in names if _PLAIN.fullmatch(name) and not is_gate(name)}
    taken = set(written)
    for name in sorted(names, key=lambda name: name not in trees):
        if name in written:
            continue
        base = new = _plain(name)
        count = 1
        while (
            new in taken
            or is_gate(new)
            or (name in trees and any(other.startswith(f"{new}_g") for other in taken))
        ):
            count += 1
            new = f"{base}-{count}"
        written[name] = new
        taken.add(new)
        if name in trees:
            stems.add(new)
    return written


def _name_ends(model: dict[str, Any]) -> dict[str, str]:
    """Give each sequence an end state of its own; return the end states before by those now."""
    sequences = list(_sequences(model))
    counts = Counter(sequence["endState"] for sequence in sequences)
    taken = {end for end, count in counts.items() if count == 1 and _PLAIN.fullmatch(end)}
    before: dict[str, str] = {}
    for sequence in sequences:
        end = sequence["endState"]
        if end in taken and counts[end] == 1:
            continue
        base = new = _plain(end if counts[end] == 1 else f"{end}-{sequence['name']}")
        count = 1
        while new in taken:
            count += 1
            new = f"{base}-{count}"
        taken.add(new)
        before[new] = end
        sequence["endState"] = new
    return before


def _plain(name: str) -> str:
    return _OTHER.sub("_", name).strip("_-") or "_"


def _slots(model: dict[str, Any]) -> Iterator[Slot]:
    """Yield where a model's data hold names of elements; what is malformed is passed over."""
    yield from _named(model)
    for tree in _objects(model.get("faultTrees")):
        yield from _named(tree)
        for kind in ("basicEvents", "houseEvents"):
            for event in _objects(tree.get(kind)):
                yield from _named(event)
        waiting = [tree.get("top")]
        while waiting:
            part = waiting.pop()
            if isinstance(part, dict):
                yield from _named(part, "event")
                waiting.append(part.get("arg"))
                waiting += reversed(_objects(part.get("args")))
    for tree in _objects(model.get("eventTrees")):
        for owner in (tree, tree.get("initiatingEvent"), *_objects(tree.get("functionalEvents"))):
            yield from _named(owner)
    for sequence in _sequences(model):
        yield from _named(sequence)
        for state in _objects(sequence.get("functionalStates")):
            yield from _named(state)
            yield from _named(state.get("refGate"))


def _sequences(model: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for tree in _objects(model.get("eventTrees")):
        yield from _objects(tree.get("sequences"))


def _objects(items: object) -> list[dict[str, Any]]:
    return [item for item in items if isinstance(item, dict)] if isinstance(items, list) else []


def _named(owner: object, key: str = "name") -> Iterator[Slot]:
    if isinstance(owner, dict) and isinstance(owner.get(key), str):
        yield owner, key
