"""The page of a dossier with all that must hold for its figure: of the run, the data, the tool."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from tracerisk.common.hardware.shipped import bare_arm, hardware_of, is_shipped
from tracerisk.common.hardware.sources import without_source
from tracerisk.instrument.source.surroundings import asks_clock, asks_environment, places
from tracerisk.pipeline.dossier.anomalies import met_anomalies
from tracerisk.pipeline.dossier.guide import accepted_reasons, warning_of
from tracerisk.report.instances import component_shares
from tracerisk.report.tables import share_text

if TYPE_CHECKING:
    from tracerisk.adder.blocks.override import Override
    from tracerisk.common.hardware.model import Component, Hardware
    from tracerisk.report.html.report_input import ReportInput

GENERAL = (
    (
        "One run shows the mission: the same branches, times and loads as in the field",
        "functions that never ran are in no figure; exposures are off",
    ),
    (
        "A component that is in use is needed, and one that is idle is not",
        "too high by some per cent for motors, and far too high for sensors whose "
        "readings nobody uses; too low for a gripper that fails while it is idle "
        "(counted)",
    ),
    (
        "Rates are constant in time, or follow a Weibull law with a stated age",
        "wear-out and early failures are missed",
    ),
    (
        "Failures are independent except for the declared `common_cause`",
        "redundant parts look too reliable",
    ),
    (
        "All redundant units work at mission start, and a first failure stays latent "
        "until the mission ends",
        "too low if nobody tests between missions",
    ),
    (
        "The twin moves as the real arm does",
        "exposures and loads are off",
    ),
    (
        "ROS behaves as the stand-ins do",
        "another order of steps than on the robot",
    ),
    (
        "Masses and torques are those of the robot's description, and payloads those of the scene",
        "the load law is off; it has no effect unless the description states one",
    ),
    (
        "The hardware description lists every part whose failure ends the mission",
        "too low: a part that is not listed never fails",
    ),
    (
        "What a user set by `:=` is right",
        "the figure uses it without question",
    ),
)
"""The assumptions of all figures in docs/safety.md with what follows if one is wrong, sorted as
there, without links."""


def assumptions(
    report: ReportInput,
    settings: Mapping[str, object],
    sources: Mapping[str, bytes] = MappingProxyType({}),
) -> str:
    """Return the page as Markdown.

    `settings` are those of the run that are not the default, `sources` the files of the dossier
    with the controller's code.
    """
    data = (*_environment(sources), *_carried(report), *_parts(report), *_of_data(report))
    lines = (*report.assumptions, *report.assessment.assumptions, *data)
    found = (*report.findings, *report.assessment.findings)
    general = (f"{assumption}. If wrong: {effect}" for assumption, effect in GENERAL)
    sections = (
        ("Failure data without a source", _without_source(report)),
        ("Findings", _listed(found) or "Nothing stood out."),
        ("Values set by hand", _pins(report) or "None: every value is computed."),
        ("Accepted reasons", _listed(accepted_reasons(report)) or "None."),
        (
            "Settings that are not the default",
            _listed(f"`{name}`: {value}" for name, value in settings.items()) or "None.",
        ),
        (
            "Assumptions of all figures",
            '"Assumptions and limits" in the safety manual (`tracerisk docs safety`) says what to '
            f"do about each.\n\n{_listed(general)}",
        ),
        (
            "Known anomalies",
            '"Known anomalies" in the safety manual says what is wrong and what to do.\n\n'
            f"{_listed(met_anomalies(sources))}",
        ),
    )
    warning = "".join(f"{paragraph}\n" for paragraph in warning_of(report))
    return (
        f"# Assumptions of {report.model.name}\n\n{warning}"
        "The figures hold if these do, those of all figures at the end of this page, what was set "
        f"by hand and what was accepted.\n\n{_listed(lines) or 'None beyond the model itself.'}\n\n"
        + "\n\n".join(f"## {title}\n\n{text}" for title, text in sections)
        + "\n"
    )


def _listed(lines: Iterable[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)


def _environment(sources: Mapping[str, bytes]) -> Iterator[str]:
    """Yield that a controller may do something else where a variable is set, or at another time."""
    if lines := places(sources, asks_environment):
        yield (
            f"the controller reads environment variables ({', '.join(lines)}): one that the "
            "setting `env` does not name is no input of the run, and the sandbox hides it; where "
            "it is set, the controller may do something else"
        )
    if lines := places(sources, asks_clock):
        yield (
            f"the controller reads the clock ({', '.join(lines)}), which begins at "
            "2026-01-01T00:00:00 UTC in each run and goes on with the simulated time"
        )


def _carried(report: ReportInput) -> Iterator[str]:
    """Yield what the run carried, by the masses that the scene or the scenario gives."""
    trace = report.trace
    held = (
        {}
        if trace is None
        else {
            payload.object: payload.mass_kg for visit in trace.visits for payload in visit.payloads
        }
    )
    if held:
        listed = ", ".join(f"{name} {mass_kg:.4g} kg" for name, mass_kg in sorted(held.items()))
        yield f"what was carried has the mass that the scene gives it: {listed}"


def _parts(report: ReportInput) -> Iterator[str]:
    """Yield which parts of the robot can fail, and where the shipped description has more."""
    hardware, trace = report.hardware, report.trace
    if hardware is None or trace is None:
        return
    own = _by_place(hardware)
    listed = "; ".join(f"{place}: {', '.join(names)}" for place, names in own.items())
    yield (
        "what the hardware description does not list never fails, be it a gear, a brake, a cable "
        f"or a controller; it lists {listed}"
    )
    if not is_shipped(trace.robot):
        return
    shipped = hardware_of(trace.robot)
    for place, names in _by_place(shipped).items():
        here = own.get(place, [])
        if len(here) < len(names):
            yield (
                f"{place}: the description that is shipped for {bare_arm(trace.robot)} has "
                f"{', '.join(names)}, and this one has {', '.join(here) or 'nothing'}"
            )


def _by_place(hardware: Hardware) -> dict[str, list[str]]:
    """Return the names of components by the place where they are in use."""
    places: dict[str, list[str]] = {}
    for component in hardware.components:
        places.setdefault(_place(component), []).append(component.name)
    return places


def _place(component: Component) -> str:
    twin = component.twin
    if component.always_active or twin is None:
        return "always in use"
    if twin.sensors:
        named = (twin.sensors,) if isinstance(twin.sensors, str) else twin.sensors
        kinds = sorted({name.rpartition("/")[2] for name in named})
        return f"{' and '.join(kinds)} sensors"
    if twin.contacts:
        return "contacts"
    return "gripper" if twin.gripper and not twin.joints else "joints"


def _of_data(report: ReportInput) -> Iterator[str]:
    """Yield what the hardware description assumes of each component that counts."""
    counted = component_shares(report.assessment)
    for component in () if report.hardware is None else report.hardware.components:
        if component.name in counted:
            yield from (f"{component.name}: {words}" for words in _of_component(component))


def _of_component(component: Component) -> Iterator[str]:
    for figure in component.figures:
        sheet = figure.sheet
        if sheet is not None and sheet.dangerous is not None:
            yield (
                f"{100.0 * sheet.dangerous:.4g} % of its failures are dangerous, so that all are "
                f"{1.0 / sheet.dangerous:.4g} times those of the data sheet"
            )
        at = None if sheet is None else sheet.temperature
        if at is not None:
            yield (
                f"it works at {at.working:g} degC, where its rate is {at.factor:.4g} times that at "
                f"{at.rated:g} degC, by Arrhenius' law with {at.activation_energy:g} eV"
            )
    beta = component.redundancy.common_cause
    if component.redundancy and not beta:
        yield (
            "no common cause is stated, so that its units fail independently of each other: a pair "
            "looks better than any real one"
        )
    if beta:
        yield f"{100.0 * beta:.4g} % of the failures of a unit have a cause that fails all units"
    law = component.load_law
    if law is not None:
        yield (
            f"{100.0 * law.wearing_share:.4g} % of its failures come from wear, and grow with load "
            f"to the power of {law.exponent:.4g}, above {100.0 * law.reference_load:.4g} % of the "
            "rated torque (`reference_load`): below it they count for less"
        )
        if law.reference_speed is not None:
            yield (
                f"its wear is that of a motion at {100.0 * law.reference_speed:.4g} % of the rated "
                "speed (`reference_speed`): a slower one counts for less"
            )
    yield from _kept_low(component)


def _kept_low(component: Component) -> Iterator[str]:
    """Yield what else a description states that makes the figure of a component smaller."""
    redundancy = component.redundancy
    if redundancy.has_spares:
        yield (
            f"a spare fails {redundancy.dormancy:.4g} times as often before it is needed as a "
            f"unit at work, and does not take over with probability {redundancy.switch:.4g}"
        )
    if redundancy and redundancy.detected == "each_visit":
        yield "a first failure of a redundant group is found and mended before each visit"
    if any(mode.when for mode in component.modes):
        listed = ", ".join(
            f"{mode.name} ({100.0 * mode.fraction:.4g} %) {' and '.join(mode.when)}"
            for mode in component.modes
            if mode.when
        )
        yield f"some of its failures count in certain uses alone: {listed}"


def _pins(report: ReportInput) -> str:
    return _listed(
        f"{pin.location}: {pin.field} := {pin.value}, "
        f"computed {pin.computed or _nothing(pin, report)}; {pin.reason or 'no reason is given'}"
        for pin in report.pins
    )


def _nothing(pin: Override, report: ReportInput) -> str:
    """Return why nothing is computed beside a value set by hand, and what follows."""
    if report.hardware is None:
        return "nothing"
    known = (component.name for component in report.hardware.components)
    if any(f".{name}." in f"{pin.field}." for name in known):
        return "nothing, as the run does not use it there (the pin alone keeps it)"
    return "nothing, as the hardware description does not have it (the pin alone keeps it)"


def _without_source(report: ReportInput) -> str:
    """Return which failure data are assumed, or have no source at all, as a list."""
    if report.figures is None or report.hardware is None:
        return "Not known: the run is not in this dossier."
    stated = [
        (figure.component, figure.fussell_vesely, figure.source)
        for figure in report.figures.assumed
    ]
    shares = component_shares(report.assessment)
    stated += [
        (name, shares[name], "no source is given")
        for name in without_source(report.hardware)
        if name in shares
    ]
    lines = (
        f"- {name} ({share_text(share)} of the figure): {text}" for name, share, text in stated
    )
    return "\n".join(lines) or "None."
