"""A chain as text in the PRISM language."""

from __future__ import annotations

import json

from tracerisk.prm.other_models.formats.explicit_chain import INITIAL, ExplicitChain


def write_prism(chain: ExplicitChain) -> str:
    """Return a module with one variable `s`, and the chain's labels.

    Each number is written so that it reads back to the same bits; an absorbing state leads to
    itself with 1. A comment gives the name of each state whose label differs from it.
    """
    lines = [chain.kind.value, "", "module chain"]
    start = "" if len(chain.starts) > 1 else f" init {chain.initial}"
    lines.append(f"  s : [0..{len(chain.rows) - 1}]{start};")
    lines.append("")
    for state, row in enumerate(chain.rows):
        moves = sorted((t, p) for t, p in row.items() if p > 0.0) or [(state, 1.0)]
        text = " + ".join(f"{p!r} : (s'={target})" for target, p in moves)
        lines.append(f"  [] s={state} -> {text};")
    lines += ["endmodule", ""]
    if len(chain.starts) > 1:
        lines += [f"init {' | '.join(f's={state}' for state in chain.starts)} endinit", ""]
    own: dict[int, str] = {}
    for label, states in chain.labels.items():
        if len(states) == 1 and label != INITIAL:
            own.setdefault(min(states), label)
    for state, name in enumerate(chain.names):
        if own.get(state) != name and name != f"s{state}":
            lines.append(f"// state {state}: {json.dumps(name)}")
    for label, states in chain.labels.items():
        if label != INITIAL:
            result = " | ".join(f"s={state}" for state in sorted(states)) or "false"
            lines.append(f'label "{label}" = {result};')
    return "\n".join(lines) + "\n"
