"""Turn `FailureData`, `@Risk`, `Redundancy` and `TwinBinding` into what the hardware has."""

from __future__ import annotations

from typing import Any, cast, get_args

from tracerisk.common.hardware.load import unmeasured_exponent
from tracerisk.common.hardware.model import (
    NOT_OPTIONAL,
    Basis,
    Demand,
    FailureFigure,
    FailureMode,
    LoadLaw,
    Statistic,
    TwinBinding,
    default_detection,
)
from tracerisk.common.hardware.redundancy import ALL_NEEDED, Redundancy, Repair
from tracerisk.common.hardware.sysml.annotations import Metadata
from tracerisk.common.hardware.sysml.fields import Fields
from tracerisk.common.hardware.sysml.language.name_resolution import Symbol
from tracerisk.common.hardware.sysml.language.standard_names import (
    LEVELS,
    RISK,
    RISK_FEATURES,
    Standard,
)
from tracerisk.common.hardware.sysml.values import Amount
from tracerisk.common.hardware.units import (
    COLDEST_C,
    CYCLE_KINDS,
    DANGEROUS_KINDS,
    HOTTEST_C,
    SHEET_KINDS,
    DataSheet,
    SheetKind,
    Temperature,
    rate_from_fit,
)
from tracerisk.common.traced.elements import WEAR_EXPONENTS
from tracerisk.errors import HardwareError

_VALUES = ("probability", "rate", "weibull", *SHEET_KINDS)
_SPANS = {60.0: Basis.MINUTE, 3600.0: Basis.HOUR}
_SPARES: dict[str, float | None] = {"hot": 1.0, "warm": None, "cold": 0.0}


def read_figure(fields: Fields) -> FailureFigure:
    """Return the figure of one `FailureData`.

    Raises HardwareError where it gives none or several values, or what does not fit its kind.
    """
    given = [key for key in _VALUES if key in fields]
    if len(given) != 1:
        what = " and ".join(f"'{key}'" for key in given) if given else "no figure"
        raise HardwareError(
            f"FailureData gives {what}; give one of: {', '.join(_VALUES)} (several FailureData "
            "on a part add up)",
            fields.place(given[1]) if given else fields.location,
        )
    kind = given[0]
    applies = {
        "per": ("probability",),
        "demand": ("probability", *CYCLE_KINDS),
        "cycles": CYCLE_KINDS,
        "dangerous": DANGEROUS_KINDS,
        "temperature": ("rate", *(name for name in SHEET_KINDS if name not in CYCLE_KINDS)),
    }
    for key, kinds in applies.items():
        if key in fields and kind not in kinds:
            fields.fail(key, f"applies to {' or '.join(kinds)}; remove it or '{kind}'")
    if kind != "rate" and fields.boolean("standby", default=False):
        fields.fail("standby", "applies to a rate; remove it")
    if kind == "probability":
        return _probability(fields)
    for name in SHEET_KINDS:
        if kind == name:
            return _cycles(fields, name) if name in CYCLE_KINDS else _mean_time(fields, name)
    return _rate(fields) if kind == "rate" else _weibull(fields)


def _probability(fields: Fields) -> FailureFigure:
    value = fields.number("probability", maximum=1.0)
    per = Basis(fields.word("per", "Basis")) if "per" in fields else Basis.VISIT
    demand = _demand(fields)
    if demand is not None and per is not Basis.DEMAND:
        fields.fail("demand", f"applies to demands, but the figure is per {per.value}")
    return FailureFigure("probability", value, per, demand=demand, **_uncertainty(fields))


def _demand(fields: Fields) -> Demand | None:
    if "demand" not in fields:
        return None
    word = fields.word("demand", "Use")
    for demand in get_args(Demand):
        if word == demand:
            return cast("Demand", demand)
    return fields.fail(
        "demand", f"'{word}' is not a demand; allowed: Use::start, Use::grasp, Use::release"
    )


def _mean_time(fields: Fields, kind: SheetKind) -> FailureFigure:
    time = fields.long_time(kind)
    hours = float(time.number) * (time.unit.seconds / 3600.0)
    sheet = DataSheet(hours, kind, dangerous=_dangerous(fields), temperature=_temperature(fields))
    return FailureFigure(
        "failure_rate",
        _stated(fields, kind, sheet),
        Basis.HOUR,
        sheet=sheet,
        **_uncertainty(fields, "mean"),
    )


def _cycles(fields: Fields, kind: SheetKind) -> FailureFigure:
    """Return a B10 or B10d: per demand, or per hour where the cycles in an hour are given."""
    value = fields.number(kind, minimum=1.0)
    demand = _demand(fields)
    per_hour = None
    if "cycles" in fields:
        if demand is not None:
            fields.fail("demand", "the cycles are given, so no demand is counted; remove it")
        cycles = fields.rate("cycles")
        per_hour = float(cycles.number) * (3600.0 / cycles.unit.seconds)
        if cycles.unit.is_fit or per_hour == 0.0:
            fields.fail("cycles", "expected a number of cycles above 0, such as 120 [h^-1]")
    sheet = DataSheet(value, kind, per_hour, _dangerous(fields))
    return FailureFigure(
        "probability" if per_hour is None else "failure_rate",
        _stated(fields, kind, sheet),
        Basis.DEMAND if per_hour is None else Basis.HOUR,
        demand=demand,
        sheet=sheet,
        **_uncertainty(fields, "mean"),
    )


def _stated(fields: Fields, key: str, sheet: DataSheet) -> float:
    """Return the rate or the probability that a data sheet states."""
    if sheet.fault:
        fields.fail(key, f"{sheet.fault} with what stands beside it; mend one of them")
    return sheet.figure


def _dangerous(fields: Fields) -> float | None:
    return fields.positive("dangerous", maximum=1.0) if "dangerous" in fields else None


def _temperature(fields: Fields) -> Temperature | None:
    if "temperature" not in fields:
        return None
    at = fields.nested("temperature", "Temperature")
    at.forbid_unknown(("rated", "working", "activationEnergy"))
    rated, working = (
        at.number(key, minimum=COLDEST_C, maximum=HOTTEST_C) for key in ("rated", "working")
    )
    return Temperature(rated, working, at.number("activationEnergy", maximum=2.0))


def _rate(fields: Fields) -> FailureFigure:
    rate = fields.rate("rate")
    value, per = rate_per(rate)
    standby = fields.boolean("standby", default=False)
    fit = float(rate.number) if rate.unit.is_fit else None
    sheet = None
    if (temperature := _temperature(fields)) is not None:
        sheet = DataSheet(value, temperature=temperature)
        value = _stated(fields, "rate", sheet)
    return FailureFigure(
        "failure_rate", value, per, standby=standby, sheet=sheet, fit=fit, **_uncertainty(fields)
    )


def rate_per(amount: Amount) -> tuple[float, Basis]:
    """Return a rate with the span that the hardware description counts it by."""
    number, unit = float(amount.number), amount.unit
    if unit.is_fit:
        return rate_from_fit(number), Basis.HOUR
    if unit.seconds in _SPANS:
        return number, _SPANS[unit.seconds]
    return number * (3600.0 / unit.seconds), Basis.HOUR


def _weibull(fields: Fields) -> FailureFigure:
    law = fields.nested("weibull", "Weibull")
    law.forbid_unknown(("shape", "characteristicLife"))
    life = law.long_time("characteristicLife")
    shape = law.positive("shape")
    number, seconds = float(life.number), life.unit.seconds
    per = _SPANS.get(seconds, Basis.HOUR)
    value = number if seconds in _SPANS else number * seconds / 3600.0
    return FailureFigure("weibull", value, per, shape=shape, **_uncertainty(fields))


def _uncertainty(fields: Fields, usual: Statistic = "median") -> dict[str, Any]:
    factor = fields.number("errorFactor", minimum=1.0) if "errorFactor" in fields else None
    meaning = fields.word("valueIs", "Statistic") if "valueIs" in fields else usual
    if "valueIs" in fields and factor is None:
        fields.fail("valueIs", "has no effect without 'errorFactor'; give it, or remove both")
    return {"error_factor": factor, "value_is": meaning, "source": fields.text("source")}


def read_risk(fields: Fields) -> FailureFigure | None:
    """Return the figure of a `@Risk`, per visit; `None` where it gives a level, or none at all."""
    if "totalRisk" not in fields or _names_level(fields, "totalRisk"):
        return None
    total = fields.nested("totalRisk", "RiskLevel", RISK)
    total.forbid_unknown(RISK_FEATURES["RiskLevel"])
    if "probability" not in total:
        return None
    if _names_level(total, "probability"):
        return None
    return FailureFigure("probability", total.number("probability", maximum=1.0), Basis.VISIT)


def _names_level(fields: Fields, key: str) -> bool:
    """Whether a feature is one of the levels low, medium and high, and no number."""
    if not fields.has_expression(key):
        return False
    value = fields.meaning(key)
    return isinstance(value, Standard) and value.path[0] == RISK and value.path[-1] in LEVELS


def read_load_law(fields: Fields) -> LoadLaw:
    """Return the load law in a `FailureData`."""
    law = fields.nested("loadLaw", "LoadLaw")
    law.forbid_unknown(("referenceLoad", "wearingShare", "exponent", "referenceSpeed", "source"))
    exponent = law.number("exponent") if "exponent" in law else 3.0
    if exponent not in WEAR_EXPONENTS:
        law.fail("exponent", unmeasured_exponent(f"{exponent:g}"))
    speed = law.positive("referenceSpeed", maximum=1.0) if "referenceSpeed" in law else None
    return LoadLaw(
        reference_load=law.positive("referenceLoad", maximum=1.0),
        wearing_share=law.number("wearingShare", maximum=1.0),
        exponent=exponent,
        reference_speed=speed,
        source=law.text("source"),
    )


def read_modes(found: list[Metadata], way: tuple[Symbol, ...]) -> tuple[FailureMode, ...]:
    """Return the failure modes that metadata of a part name."""
    modes: dict[str, FailureMode] = {}
    for metadata in found:
        name = metadata.symbol.name
        if name is None:
            raise HardwareError(
                "a failure mode without a name; write 'metadata jam : FailureMode { ... }'",
                metadata.location,
            )
        if name in modes:
            raise HardwareError(f"duplicate failure mode '{name}'; keep one", metadata.location)
        fields = Fields.of(metadata, way)
        uses: Any = fields.words("uses", "Use") if "uses" in fields else ()
        fraction = fields.positive("fraction", maximum=1.0)
        fault: Any = fields.word("fault", "Fault") if "fault" in fields else None
        lasts_s = fields.time_s("lasts") if "lasts" in fields else None
        modes[name] = FailureMode(name, fraction, uses, fields.text("source"), fault, lasts_s)
    return tuple(modes.values())


def read_redundancy(
    fields: Fields, figures: tuple[FailureFigure, ...]
) -> tuple[Redundancy, float | None]:
    """Return the redundancy of a part, and the time between the tests of the group [s]."""
    beyond = [key for key in ("required", "spare") if key in fields]
    if not fields.boolean("redundant", default=bool(beyond)):
        for key in ("required", "spare", "dormancy", "switch", "commonCause", "detected"):
            if key in fields:
                fields.fail(key, "applies to redundant units; write 'redundant = true' too")
        for key in ("testInterval", *_REPAIR):
            if key in fields:
                fields.fail(key, "units that are all needed have no hidden failures; remove it")
        return ALL_NEEDED, None
    interval = fields.time_s("testInterval") if "testInterval" in fields else None
    if interval is not None and "detected" in fields:
        fields.fail("detected", "conflicts with 'testInterval'; remove one of the two")
    detected: Any = (
        fields.word("detected", "Detection")
        if "detected" in fields
        else default_detection(figures, interval is not None or read_repair(fields) is not None)
    )
    cause = fields.number("commonCause", maximum=1.0) if "commonCause" in fields else 0.0
    return (
        Redundancy(
            True,
            required=fields.integer("required") if "required" in fields else 1,
            common_cause=cause,
            dormancy=_dormancy(fields),
            switch=_switch(fields),
            detected=detected,
        ),
        interval,
    )


_REPAIR = ("repairTime", "repairRate", "repairInMission")


def read_repair(fields: Fields) -> Repair | None:
    """Return how long the repair of a unit of a redundant part takes; `None` where not given."""
    given = [key for key in _REPAIR if key in fields]
    if not given:
        return None
    if "repairTime" in given and "repairRate" in given:
        fields.fail("repairRate", "conflicts with 'repairTime'; remove one of the two")
    if given == ["repairInMission"]:
        fields.fail("repairInMission", "needs the time of a repair; write 'repairTime = 8 [h]' too")
    in_mission = fields.boolean("repairInMission", default=False)
    if "repairTime" in given:
        return Repair(fields.time_s("repairTime"), in_mission)
    rate = fields.rate("repairRate")
    if rate.unit.is_fit:
        fields.fail("repairRate", "FIT is a unit of failures; write 'repairTime = 8 [h]'")
    if not rate.number:
        fields.fail("repairRate", "is 0; give a rate above 0, or leave it out")
    return Repair(rate.unit.seconds / float(rate.number), in_mission)


def _dormancy(fields: Fields) -> float:
    if "spare" not in fields:
        if "dormancy" in fields:
            fields.fail("dormancy", "applies to a warm spare; write 'spare = Spare::warm' too")
        return 1.0
    kind = fields.word("spare", "Spare")
    fixed = _SPARES[kind]
    if fixed is not None:
        if "dormancy" in fields:
            fields.fail("dormancy", f"is {fixed:g} for a {kind} spare; remove it")
        return fixed
    if "dormancy" not in fields:
        fields.fail(
            "spare",
            "a warm spare needs 'dormancy', its failure rate as a share of a working unit's",
        )
    dormancy = fields.number("dormancy", maximum=1.0)
    if dormancy in (0.0, 1.0):
        word = "cold" if dormancy == 0.0 else "hot"
        fields.fail("dormancy", f"is the dormancy of a {word} spare; write 'spare = Spare::{word}'")
    return dormancy


def _switch(fields: Fields) -> float:
    if "switch" not in fields:
        return 0.0
    if "spare" not in fields:
        fields.fail(
            "switch", "is the probability that a spare fails to take over; give 'spare' too"
        )
    return fields.number("switch", maximum=1.0)


def read_twin(fields: Fields) -> tuple[TwinBinding | None, bool]:
    """Return where the twin sees a part, and whether it is always active instead."""
    others = [key for key in TWIN_KEYS if key in fields]
    if fields.boolean("always", default=False):
        if others:
            fields.fail(
                others[0],
                "a component is either always active or bound to the twin; remove one of the two",
            )
        return None, True
    joints = fields.texts("joints")
    if "sensors" in fields and "sensorKind" in fields:
        fields.fail("sensorKind", "sensors are given by name or by kind; leave out one of the two")
    sensors: Any = (
        fields.word("sensorKind", "SensorKind")
        if "sensorKind" in fields
        else fields.texts("sensors")
    )
    binding = TwinBinding(
        joints="*" if joints == ("*",) else joints,
        gripper=fields.boolean("gripper", default=False),
        optional=fields.boolean("optional", default=False),
        actuators=fields.texts("actuators"),
        sensors=sensors,
        contacts=fields.texts("contacts"),
    )
    if binding.named_units == 0:
        if not others:
            return None, False
        raise HardwareError(
            "TwinBinding is empty; give joints, actuators, gripper, "
            "sensors, sensorKind or contacts, or 'always = true'",
            fields.location,
        )
    if binding.optional and not binding.can_be_optional:
        fields.fail("optional", NOT_OPTIONAL)
    return binding, False


TWIN_KEYS = ("joints", "actuators", "gripper", "sensors", "sensorKind", "contacts", "optional")
