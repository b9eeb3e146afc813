"""What the tool writes of a component's failures: modes with their shares, rounded."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TypeAlias, TypeVar

from tracerisk.adder.blocks.block import Field
from tracerisk.adder.blocks.failures import FailureModes, read_failures

ShareTexts: TypeAlias = "dict[str, dict[tuple[str, str], float]]"
"""Shares by mode, and by kind and function in which the failure shows."""

_Key = TypeVar("_Key")


def failures_of(shares: ShareTexts) -> Field[FailureModes]:
    """Return the field that the tool writes for shares of a component's failures.

    Four significant digits each; the greatest share of each sum takes what is left of it.
    """
    whole = {mode: sum(row.values()) for mode, row in shares.items()}
    of_modes = _rounded(whole, sum(whole.values()))
    said = []
    for mode, row in shares.items():
        if mode not in of_modes:
            continue
        parts = [
            f"{kind}{f' in {later}' if later else ''} {_decimal(share)}"
            for (kind, later), share in _rounded(
                {key: share / whole[mode] for key, share in row.items()}, 1.0
            ).items()
        ]
        said.append(f"{mode} {_decimal(of_modes[mode])}: {', '.join(parts)}")
    text = " | ".join(said)
    return Field(read_failures(text), text)


def _rounded(shares: Mapping[_Key, float], total: float) -> dict[_Key, Fraction]:
    """Return shares rounded, the greatest as what the others leave of the total; none is 0."""
    greatest = max(shares, key=lambda key: shares[key])
    whole = Fraction(1) if total > 1.0 - 1e-9 else _digits(total)
    rounded = {key: _digits(share) for key, share in shares.items() if key != greatest}
    rounded[greatest] = whole - sum(rounded.values(), Fraction(0))
    return {key: rounded[key] for key in shares if rounded[key] > 0}


def _digits(share: float) -> Fraction:
    return Fraction(f"{share:.4g}")


def _decimal(share: Fraction) -> str:
    """Return a share as a decimal; its denominator divides a power of ten."""
    places = 0
    while (share * 10**places).denominator != 1:
        places += 1
    text = f"{int(share * 10**places):0{places + 1}d}"
    return f"{text[:-places]}.{text[-places:]}" if places else text
