"""A fault tree as a drawing, in the symbols of IEC 61025."""

from __future__ import annotations

from tracerisk.prm.drawing.layout import Size, layered
from tracerisk.prm.drawing.svg import FAINT, WORD_HEIGHT, Canvas, word_width
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

_MOST_NODES = 150
_MOST_LINES = 300
_LABEL = WORD_HEIGHT + 6.0
_SYMBOL = 30.0
_HEIGHT = _LABEL + 6.0 + _SYMBOL
_MARKS = {
    GateKind.AND: "&",
    GateKind.NAND: "&",
    GateKind.OR: "≥1",
    GateKind.NOR: "≥1",
    GateKind.XOR: "=1",
    GateKind.IFF: "=",
    GateKind.IMPLY: "⇒",
    GateKind.NOT: "1",
    GateKind.INHIBIT: "&",
    GateKind.TRANSFER: "1",
}
NEGATED = frozenset((GateKind.NOT, GateKind.NAND, GateKind.NOR))
"""The gates that bear the circle of negation."""


def fault_tree_svg(tree: FaultTree) -> str:
    """Return the drawing of a tree; of a large one, the uppermost gates and events.

    What is shared is drawn once, with a line from each gate above it.
    """
    gates = {gate.name: gate for gate in tree.gates}
    houses = {house.name: house.state for house in tree.houses}
    shown = _uppermost(tree, gates)
    sizes = {name: Size(max(word_width(name) + 12.0, _SYMBOL + 8.0), _HEIGHT) for name in shown}
    edges = [
        (name, child)
        for name in shown
        if name in gates
        for child in gates[name].inputs
        if child in shown
    ]
    layout = layered(sizes, edges)
    canvas = Canvas()
    for way in layout.ways.values():
        (x, y), (to_x, to_y) = way[0], way[-1]
        canvas.line([(x, y + _HEIGHT / 2), *way[1:-1], (to_x, to_y - _HEIGHT / 2)])
    for name, (x, y) in layout.centres.items():
        canvas.box(x, y - _HEIGHT / 2 + _LABEL / 2, sizes[name].width, _LABEL)
        canvas.word(x, y - _HEIGHT / 2 + _LABEL / 2, name)
        canvas.line([(x, y - _HEIGHT / 2 + _LABEL), (x, y + _HEIGHT / 2 - _SYMBOL)])
        middle = y + _HEIGHT / 2 - _SYMBOL / 2
        if name in gates:
            _draw_gate(canvas, x, middle, gates[name])
            hidden = sum(child not in shown for child in dict.fromkeys(gates[name].inputs))
            if hidden:
                canvas.word(x + _SYMBOL / 2 + 4, middle, f"+{hidden}", anchor="start", fill=FAINT)
        elif name in houses:
            half, roof = _SYMBOL / 2, 9.0
            canvas.path(
                f"M{x - half:.1f} {middle + half:.1f} V{middle - half + roof:.1f} "
                f"L{x:.1f} {middle - half:.1f} L{x + half:.1f} {middle - half + roof:.1f} "
                f"V{middle + half:.1f} Z"
            )
            canvas.word(x, middle + 4, "1" if houses[name] else "0")
        else:
            canvas.circle(x, middle, _SYMBOL / 2)
    height = layout.height
    left_out = len(gates) + len(tree.events) + len(houses) - len(shown)
    if left_out:
        height += WORD_HEIGHT
        canvas.word(
            0, height - WORD_HEIGHT / 2, f"{left_out} more below", anchor="start", fill=FAINT
        )
    return canvas.svg(layout.width, height, f"Fault tree {tree.top}")


def _uppermost(tree: FaultTree, gates: dict[str, Gate]) -> dict[str, None]:
    """Return the gates and events nearest to the top."""
    shown = {tree.top: None}
    waiting = [tree.top]
    lines = 0
    for name in waiting:
        for child in gates[name].inputs if name in gates else ():
            if len(shown) == _MOST_NODES or lines == _MOST_LINES:
                return shown
            lines += 1
            if child not in shown:
                shown[child] = None
                waiting.append(child)
    return shown


def _draw_gate(canvas: Canvas, x: float, y: float, gate: Gate) -> None:
    half = _SYMBOL / 2
    left, right, upper, lower = x - half, x + half, y - half, y + half
    match gate.kind:
        case GateKind.TRANSFER:
            canvas.path(f"M{x:.1f} {upper:.1f} L{right:.1f} {lower:.1f} H{left:.1f} Z")
            return
        case GateKind.INHIBIT:
            inset = 8.0
            canvas.path(
                f"M{left + inset:.1f} {upper:.1f} H{right - inset:.1f} L{right:.1f} {y:.1f} "
                f"L{right - inset:.1f} {lower:.1f} H{left + inset:.1f} L{left:.1f} {y:.1f} Z"
            )
            return
        case GateKind.AND | GateKind.NAND:
            canvas.path(
                f"M{left:.1f} {lower:.1f} V{y:.1f} A{half:.1f} {half:.1f} 0 0 1 "
                f"{right:.1f} {y:.1f} V{lower:.1f} Z"
            )
        case GateKind.OR | GateKind.NOR | GateKind.XOR | GateKind.ATLEAST | GateKind.CARDINALITY:
            canvas.path(
                f"M{left:.1f} {lower:.1f} Q{left:.1f} {y - 4:.1f} {x:.1f} {upper:.1f} "
                f"Q{right:.1f} {y - 4:.1f} {right:.1f} {lower:.1f} "
                f"Q{x:.1f} {lower - 9:.1f} {left:.1f} {lower:.1f} Z"
            )
        case _:
            canvas.box(x, y, _SYMBOL, _SYMBOL)
    if gate.kind in NEGATED:
        canvas.circle(x, upper, 3.0)
    canvas.word(x, y + 1, gate_mark(gate))


def gate_mark(gate: Gate) -> str:
    """Return the mark in a gate's symbol, as in IEC 61025."""
    if gate.kind is GateKind.ATLEAST:
        return f"≥{gate.k}"
    if gate.kind is GateKind.CARDINALITY:
        return f"{gate.k}-{gate.most}"
    return _MARKS[gate.kind]
