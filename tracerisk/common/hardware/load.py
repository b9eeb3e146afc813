"""How load makes the time of a unit count for more, or less, than the clock shows.

Own derivation, docs/theory.md#load, of the life laws of bearings (ISO 281) and strain-wave
gears: life counts in revolutions, and falls with a power of the load.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tracerisk.common.hardware.model import LoadLaw
from tracerisk.common.hardware.use import UnknownUseError
from tracerisk.common.traced.elements import WEAR_EXPONENTS, Exposure


@dataclass(frozen=True, slots=True)
class UnitLoad:
    """The load law of one unit, with the speed to which its wear is related."""

    law: LoadLaw
    """The load law of the component."""
    reference_speed: float
    """The law's reference speed, else the unit's mean speed over the mission while it moves, as a
    fraction of the rated speed [1]; 0 for a unit that never moves."""

    def wearing_s(self, exposure: Exposure) -> float:
        """Return the time at reference load and speed in which a unit would wear as much [s]."""
        wear = wear_s(self.law, exposure)
        if wear == 0.0 or self.reference_speed == 0.0:
            return 0.0
        load = math.pow(self.law.reference_load, self.law.exponent)
        return wear / (self.reference_speed * load)

    def counted_s(self, seconds: float, wearing_s: float) -> float:
        """Return the time that counts of one in which the unit wears for `wearing_s` [s].

        (1-phi) T + phi W: the share of the failures that wear causes goes with the wear.
        """
        share = self.law.wearing_share
        return (1.0 - share) * seconds + share * wearing_s


def wear_s(law: LoadLaw, exposure: Exposure) -> float:
    """Return the integral of |v| L^k over the moving time of an exposure [s].

    Raises UnknownUseError where something moved and the trace holds no wear, or none for k.
    """
    if not exposure.wear:
        if exposure.moving_s > 0.0:
            raise UnknownUseError("the wear of what moves", "`tracerisk run FILE` gives it")
        return 0.0
    try:
        return exposure.wear[WEAR_EXPONENTS.index(law.exponent)]
    except ValueError:
        known = ", ".join(f"{exponent:.4g}" for exponent in WEAR_EXPONENTS)
        raise UnknownUseError(
            f"the wear at exponent {law.exponent:.4g}", f"allowed: {known}"
        ) from None


def exponent_text(exponent: float) -> str:
    """Return an exponent as it is written: whole, or as the fraction 10/3."""
    return "10/3" if exponent == 10.0 / 3.0 else f"{exponent:g}"


def unmeasured_exponent(given: str) -> str:
    """Return what is said of an exponent for which a run measures no wear."""
    allowed = ", ".join(map(exponent_text, WEAR_EXPONENTS))
    return f"{given} is not an exponent whose wear a run measures; allowed: {allowed}"


def mean_speed(travel_s: float, moving_s: float) -> float:
    """Return the mean speed while moving, as a fraction of the rated speed."""
    return travel_s / moving_s if moving_s > 0.0 else 0.0
