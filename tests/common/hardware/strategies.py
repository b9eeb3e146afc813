"""Hardware descriptions of every kind that a reader accepts, for Hypothesis."""

from dataclasses import replace

from hypothesis import strategies as st

from tracerisk.common.hardware.model import (
    FAULTS,
    Basis,
    Component,
    FailureFigure,
    FailureMode,
    Hardware,
    LoadLaw,
    TwinBinding,
    default_detection,
)
from tracerisk.common.hardware.redundancy import ALL_NEEDED, Redundancy, Repair
from tracerisk.common.hardware.units import (
    CYCLE_KINDS,
    DANGEROUS_KINDS,
    SHEET_KINDS,
    DataSheet,
    Temperature,
)
from tracerisk.common.traced.elements import WEAR_EXPONENTS

SOURCES = st.none() | st.text(max_size=12) | st.just("assumed: as the others")
NAMES = st.from_regex(
    r"[a-z_][A-Za-z0-9_\-]{0,5}(\.[A-Za-z][A-Za-z0-9_]{0,4}){0,2}", fullmatch=True
)
PLACES = st.lists(
    st.sampled_from(["j1", "j2", "wrist/roll", "true", "1", "a b", "Ärm: #1", "- x"]),
    min_size=1,
    max_size=3,
    unique=True,
).map(tuple)
PROBABILITIES = st.floats(0.0, 1.0)
RATES = st.floats(0.0, 1e300)
POSITIVE = st.floats(1e-300, 1e300)
REFERENCES = st.floats(1e-3, 1.0)
SPANS = st.sampled_from([Basis.MINUTE, Basis.HOUR])
TIMES = st.floats(1e-3, 1e12) | st.integers(1, 10**6).map(lambda hours: hours * 3600.0)


@st.composite
def uncertainty(draw) -> dict:
    factor = draw(st.none() | st.floats(1.0, 100.0))
    meaning = "median" if factor is None else draw(st.sampled_from(["median", "mean"]))
    return {"error_factor": factor, "value_is": meaning, "source": draw(SOURCES)}


# A sum with 0.0 has no -0.0, which is written otherwise.
CELSIUS = st.floats(-100.0, 400.0).map(lambda temperature: temperature + 0.0)
TEMPERATURES = st.builds(Temperature, CELSIUS, CELSIUS, st.floats(0.0, 2.0))


@st.composite
def of_data_sheets(draw, *, demands: list[str]) -> FailureFigure:
    kind = draw(st.sampled_from([None, *SHEET_KINDS]))
    unsure = draw(uncertainty())
    if kind is not None and unsure["error_factor"] is None:
        unsure["value_is"] = "mean"
    shares = st.none() | st.floats(0.1, 1.0)
    share = draw(shares) if kind in DANGEROUS_KINDS else None
    if kind not in CYCLE_KINDS:
        at = draw(TEMPERATURES if kind is None else st.none() | TEMPERATURES)
        sheet = DataSheet(draw(st.floats(1e-3, 1e12)), kind, None, share, at)
        span = draw(SPANS) if kind is None else Basis.HOUR
        return FailureFigure("failure_rate", sheet.figure, span, sheet=sheet, **unsure)
    cycles = draw(st.none() | st.floats(1e-6, 1e6)) if demands else draw(st.floats(1e-6, 1e6))
    sheet = DataSheet(draw(st.floats(1.0, 1e12)), kind, cycles, share)
    if cycles is not None:
        return FailureFigure("failure_rate", sheet.figure, Basis.HOUR, sheet=sheet, **unsure)
    demand = draw(st.sampled_from([None, *demands]))
    return FailureFigure(
        "probability", sheet.figure, Basis.DEMAND, demand=demand, sheet=sheet, **unsure
    )


@st.composite
def figures(draw, *, demands: list[str], always: bool) -> FailureFigure:
    kinds = ["probability", "failure_rate", "weibull", "sheet"]
    kind = draw(st.sampled_from(kinds if always else [*kinds, "standby"]))
    if kind == "sheet":
        return draw(of_data_sheets(demands=demands))
    unsure = draw(uncertainty())
    if kind == "probability":
        bases = [basis for basis in Basis if demands or basis is not Basis.DEMAND]
        per = draw(st.sampled_from(bases))
        demand = draw(st.sampled_from([None, *demands])) if per is Basis.DEMAND else None
        return FailureFigure(kind, draw(PROBABILITIES), per, demand=demand, **unsure)
    if kind == "weibull":
        return FailureFigure(kind, draw(POSITIVE), draw(SPANS), shape=draw(POSITIVE), **unsure)
    return FailureFigure(
        "failure_rate", draw(RATES), draw(SPANS), standby=kind == "standby", **unsure
    )


@st.composite
def bindings(draw) -> TwinBinding:
    joints = draw(st.just(()) | st.just("*") | PLACES)
    gripper = draw(st.booleans())
    sensors = draw(st.just(()) | st.sampled_from(["encoder", "torque", "camera"]) | PLACES)
    actuators = draw(st.just(()) | PLACES)
    contacts = draw(st.just(()) | PLACES)
    if not (joints or gripper or sensors or actuators or contacts):
        joints = "*"
    optional = bool(gripper or sensors or joints == "*") and draw(st.booleans())
    return TwinBinding(joints, gripper, optional, actuators, sensors, contacts)


@st.composite
def redundancies(draw, quantity: int | None, own: tuple[FailureFigure, ...]):
    """Return a redundancy that fits the quantity, and the time between tests."""
    if quantity == 1 or not draw(st.booleans()):
        return ALL_NEEDED, None
    most = 3 if quantity is None else quantity - 1
    tested = draw(st.none() | TIMES)
    default = default_detection(own, tested is not None)
    detected = default if tested else draw(st.sampled_from(["mission_start", "each_visit"]))
    group = Redundancy(
        True,
        required=draw(st.integers(1, most)),
        common_cause=draw(st.just(0.0) | PROBABILITIES),
        dormancy=draw(st.sampled_from([0.0, 1.0]) | PROBABILITIES),
        switch=draw(st.just(0.0) | PROBABILITIES),
        detected=detected,
    )
    return group, tested


def seen_uses(twin: TwinBinding | None) -> list[str]:
    """Return what the twin tells of what is bound: of a camera only that it is read."""
    if twin is None:
        return []
    in_joints = twin.sensors not in ((), "camera")
    moves = twin.gripper or twin.joints or twin.actuators or in_joints
    touches = twin.gripper or twin.contacts
    return [
        *(["moving", "holding", "start"] if moves else []),
        *(["grasping", "grasp", "release"] if touches else []),
    ]


@st.composite
def modes(draw, own: tuple[FailureFigure, ...], twin: TwinBinding) -> tuple[FailureMode, ...]:
    """Return modes of which each word counts for a figure, and each figure is counted."""
    moded = [each for each in own if each.per is not Basis.VISIT and not each.standby]
    seen = seen_uses(twin)
    words: list[str] = []
    if any(each.per is not Basis.DEMAND for each in moded):
        words += [word for word in ("moving", "holding", "grasping") if word in seen]
    demands = {each.demand for each in moded if each.per is Basis.DEMAND}
    for word in ("start", "grasp", "release"):
        if (None in demands or word in demands) and word in seen:
            words.append(word)
    if not words or not draw(st.booleans()):
        return ()
    names = draw(st.lists(NAMES, max_size=2, unique=True).filter(lambda got: "whole" not in got))
    faults = [
        *(FAULTS["gripper"] if twin.gripper else ()),
        *(FAULTS["joint"] if twin.joints else ()),
    ]
    found = []
    for name in names:
        fault = draw(st.sampled_from([None, *faults]))
        found.append(
            FailureMode(
                name,
                draw(st.floats(1e-6, 0.2)),
                tuple(draw(st.lists(st.sampled_from(words), min_size=1, unique=True))),
                draw(SOURCES),
                fault,
                None if fault is None else draw(st.none() | st.floats(0.001, 3600.0)),
            )
        )
    return (*found, FailureMode("whole", draw(st.floats(0.1, 0.5)), tuple(words), draw(SOURCES)))


@st.composite
def components(draw, name: str) -> Component:
    always = draw(st.booleans())
    twin = None if always else draw(bindings())
    demands = [word for word in ("start", "grasp", "release") if word in seen_uses(twin)]
    own = tuple(draw(st.lists(figures(demands=demands, always=always), min_size=1, max_size=4)))
    named = None if twin is None or twin.optional else twin.named_units
    quantities = st.integers(1, 9) if named is None or named == 1 else st.just(named)
    quantity = draw(quantities if always else quantities | st.none())
    group, tested = draw(redundancies(quantity, own))
    is_uncertain = any(each.error_factor is not None for each in own)
    repair = None
    if group.is_redundant and tested is None and draw(st.booleans()):
        group = replace(group, detected="mission_start")
        is_even = always and all(each.per.seconds for each in own)
        repair = Repair(draw(TIMES), is_even and draw(st.booleans()))
    failure_modes = () if twin is None else draw(modes(own, twin))
    can_wear = (
        twin is not None
        and twin.moves
        and any(each.per.seconds and not each.standby for each in own)
        and (not failure_modes or any("moving" in mode.when for mode in failure_modes))
    )
    law = None
    if can_wear and draw(st.booleans()):
        law = LoadLaw(
            draw(REFERENCES),
            draw(PROBABILITIES),
            draw(st.sampled_from(WEAR_EXPONENTS)),
            draw(st.none() | REFERENCES),
            draw(SOURCES),
        )
    ages = any(each.kind == "weibull" for each in own)
    return Component(
        name,
        own,
        quantity,
        group,
        always,
        twin,
        law,
        failure_modes,
        draw(TIMES) if ages and draw(st.booleans()) else 0.0,
        draw(SOURCES),
        test_interval_s=tested,
        exposure_error_factor=None
        if any(each.per is Basis.VISIT for each in own)
        else draw(st.none() | st.floats(1.0, 100.0)),
        lot=draw(st.none() | st.sampled_from(["A 7", "2024: Ä"])) if is_uncertain else None,
        repair=repair,
    )


@st.composite
def hardware_descriptions(draw) -> Hardware:
    """Draw a description that a reader accepts; each of its fields may take any such value."""
    names = draw(st.lists(NAMES, min_size=1, max_size=3, unique=True))
    return Hardware(
        "drawn",
        tuple(draw(components(name)) for name in names),
        robot=draw(st.none() | st.text(max_size=5)),
        source=draw(SOURCES),
    )
