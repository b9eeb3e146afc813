"""The units of failure rates and times, and what data sheets state: mean times and B10."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, get_args

SECONDS_PER = {"second": 1.0, "minute": 60.0, "hour": 3600.0}
"""The spans in which a time may be given [s]."""

HOURS_PER_YEAR = 8760.0
"""The hours of a year of ISO 13849-1 and of data sheets, 365 days."""
SheetKind = Literal["mtbf", "mttf", "mttfd", "b10", "b10d"]
"""What a data sheet states in place of a rate or a probability."""
SHEET_KINDS: tuple[SheetKind, ...] = get_args(SheetKind)
CYCLE_KINDS: tuple[SheetKind, ...] = ("b10", "b10d")
"""Those of them that are in cycles; the others are mean times."""
DANGEROUS_KINDS: tuple[SheetKind, ...] = ("mttfd", "b10d")
"""Those of them that count dangerous failures alone."""

_HOURS_PER_FIT = 10**9
_BOLTZMANN_EV = 8.617333262e-5  # [eV/K], CODATA 2018
_ZERO_CELSIUS_K = 273.15
COLDEST_C, HOTTEST_C = -100.0, 400.0
"""The temperatures that are allowed [degC]."""
USUAL_FACTORS = (0.01, 100.0)
"""Between what a temperature usually changes a rate: 0.7 eV from 40 to 105 degC make it 86."""
USUALLY_BELOW_C = 200.0
"""Above it a temperature is doubted: own choice, below the freezing point of water in kelvin."""
_B10_SHARE = 0.1  # of units that have failed after B10 cycles


@dataclass(frozen=True, slots=True)
class Temperature:
    """How a rate that holds at one temperature changes at another, by Arrhenius' law."""

    rated: float
    """The temperature at which the figure holds [degC]."""
    working: float
    """The temperature at which the unit works [degC]."""
    activation_energy: float
    """The activation energy of what makes it fail [eV]."""

    @property
    def factor(self) -> float:
        """By what the rate is multiplied: exp(Ea / k (1 / T_rated - 1 / T_working)).

        Source: IEC 61709:2017, equation of the temperature dependence with one energy.
        """
        rated, working = (value + _ZERO_CELSIUS_K for value in (self.rated, self.working))
        return math.exp(self.activation_energy / _BOLTZMANN_EV * (1.0 / rated - 1.0 / working))

    @property
    def unlikely(self) -> str:
        """What makes it doubtful, in words; empty where temperatures and factor are usual ones."""
        least, most = USUAL_FACTORS
        hottest = max(self.rated, self.working)
        if least <= self.factor <= most:
            if hottest <= USUALLY_BELOW_C:
                return ""
            usual = f"{USUALLY_BELOW_C:g}"
            return f"a temperature of {hottest:g} degC is above {usual}: is it in kelvin?"
        return (
            f"the temperature multiplies the rate by {self.factor:.6g}, which is not between "
            f"{least:g} and {most:g}: are {self.rated:g} and {self.working:g} in degC, of the same "
            f"place (ambient or junction), and is {self.activation_energy:g} in eV?"
        )


@dataclass(frozen=True, slots=True)
class DataSheet:
    """A figure as a data sheet states it, of which a rate or a probability per demand is made."""

    value: float
    """The mean time [h], or the cycles; without a kind the rate per the basis of the figure."""
    kind: SheetKind | None = None
    """What the value is; `None` for a rate that has a temperature."""
    cycles_per_hour: float | None = None
    """How often the unit is operated, for B10 and B10d [1/h]; `None`: the twin counts it."""
    dangerous: float | None = None
    """The share of failures that are dangerous, for MTTFd and B10d; `None`: they alone count."""
    temperature: Temperature | None = None
    """At which temperature the value holds, and at which the unit works; `None`: the same."""

    @property
    def figure(self) -> float:
        """The rate per hour, or the probability per demand of a B10 without cycles per hour.

        1 / MTBF is the rate of a constant one; B10 is the number of cycles at which 10 % have
        failed, and 0.1 / B10 the rate per cycle. Source: ISO 13849-1:2015, C.4.2, equation C.1,
        and for `dangerous` its C.5.
        """
        if self.kind is None:
            value = self.value
        elif self.kind in CYCLE_KINDS:
            value = _B10_SHARE / self.value * (self.cycles_per_hour or 1.0)
        else:
            value = 1.0 / self.value
        factor = 1.0 if self.temperature is None else self.temperature.factor
        return value / (self.dangerous or 1.0) * factor

    @property
    def fault(self) -> str:
        """What is wrong with the figure; empty where it is a rate or a probability."""
        if self.kind in CYCLE_KINDS and self.cycles_per_hour is None:
            return "" if self.figure <= 1.0 else "gives a probability per cycle above 1"
        return "" if math.isfinite(self.figure) else "gives an infinite rate"

    def text(self, rate: str = "") -> str:
        """Return what the data sheet states, in words: `MTBF 886000 h`.

        `rate` is how a rate is stated where it is not per the basis of the figure.
        """
        words = []
        if self.kind in CYCLE_KINDS:
            words.append(f"{_NAMES[self.kind]} {self.value:.10g} cycles")
        elif self.kind is not None:
            years = self.value / HOURS_PER_YEAR
            same = f" = {years:.6g} years" if years >= 1.0 and years.is_integer() else ""
            words.append(f"{_NAMES[self.kind]} {self.value:.10g} h{same}")
        if self.cycles_per_hour is not None:
            words.append(f"{self.cycles_per_hour:.10g} cycles per hour")
        if self.dangerous is not None:
            words.append(f"{self.dangerous * 100:.6g} % of the failures dangerous")
        if self.temperature is not None:
            at, stated = self.temperature, rate or f"{self.value:.10g}"
            words.append(
                f"{f'{stated} ' if self.kind is None else ''}at {at.rated:g} degC, works "
                f"at {at.working:g} degC, {at.activation_energy:g} eV: times {at.factor:.6g}"
            )
        return ", ".join(words)


_NAMES: dict[SheetKind | None, str] = {
    "mtbf": "MTBF", "mttf": "MTTF", "mttfd": "MTTFd", "b10": "B10", "b10d": "B10d"
}  # fmt: skip


def rate_from_fit(fit: float) -> float:
    """Return a rate in FIT, failures per 1e9 hours, as failures per hour.

    The number that the same decimal digits per hour would give: 0.57 FIT is 5.7e-10 per hour to
    the last bit, which a division by 1e9 would miss.
    """
    return float(Fraction(repr(float(fit))) / _HOURS_PER_FIT)


def sheet_hint(name: str, value: object = None) -> str:
    """Return how what a data sheet states is written; empty for a key of anything else.

    `name` is the key where it is unknown, `value` what a user put there.
    """
    word = re.sub(r"[^a-z0-9]", "", name.lower())
    kinds = [kind for kind in SHEET_KINDS if word.startswith(kind)]
    if not kinds:
        return ""
    kind = max(kinds, key=len)
    if isinstance(value, Mapping):
        value = value.get("value")
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    given = float(value) if is_number else 0.0  # type: ignore[arg-type]
    number = f"{given:.10g}" if math.isfinite(given) and given > 0.0 else "NUMBER"
    unit = "" if kind in CYCLE_KINDS else ", unit: hour"
    return f"write '{kind}: {{value: {number}{unit}}}' among the keys of the component"
