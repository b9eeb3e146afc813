"""Give the visits of a trace what touched and what was held, and find the collisions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.traced.elements import Exposure
from tracerisk.common.traced.findings import UNEXPECTED_CONTACT, Finding
from tracerisk.errors import Location
from tracerisk.instrument.ownership import Attribution
from tracerisk.pipeline.trace.last_run import contact_text, unexpected_contacts
from tracerisk.pipeline.trace.sensors import RunActivity
from tracerisk.trace import Visit
from tracerisk.twin.recording.contact_log import read_contacts
from tracerisk.twin.recording.contact_pairs import moved_by
from tracerisk.twin.recording.contacts import (
    RunContacts,
    contact_activity,
    run_contacts,
    visit_contacts,
    visit_payloads,
)
from tracerisk.twin.recording.exposure import ElementExposures

if TYPE_CHECKING:
    from tracerisk.twin.robots.robot import Robot


def with_contacts(
    seen: RunActivity,
    folder: Path,
    robot: Robot,
    active: Mapping[str, Exposure],
    visits: tuple[Visit, ...],
) -> tuple[Mapping[str, Exposure], tuple[Visit, ...], RunContacts | None]:
    """Return the exposures of the run and its visits with contacts, payloads and touching time.

    What was held, and when, comes third.
    Raises LogError when the log of contacts in `folder` is damaged.
    """
    elements, attribution = seen.elements, seen.attribution
    activity, samples = seen.activity, seen.samples
    n_steps, step_ns = samples.n_steps, samples.header.step_ns
    log = read_contacts(folder, n_steps)
    untouched = {element.name: Exposure() for element in elements if element.kind == "contact"}
    if not len(log.rows) and not log.welds:
        return {**active, **untouched}, visits, None
    owners: dict[str | None, NDArray[np.int64]] = {
        name: attribution.assign(name, n_steps, step_ns)
        for name in (
            *(joint.name for joint in robot.arm_joints),
            *(gripper.name for gripper in robot.grippers),
        )
    }
    owners[None] = attribution.current(n_steps, step_ns)
    commanded = {
        gripper.name: _commanded(gripper.name, attribution, n_steps, step_ns)
        for gripper in robot.grippers
    }
    run = run_contacts(robot, log, activity, commanded, samples.step_s)
    contacts = visit_contacts(run, owners)
    payloads = visit_payloads(run, activity, owners)
    touching = contact_activity(run, elements)
    everywhere = np.ones(n_steps, dtype=np.bool_)
    table: dict[str, Exposure] = {}
    by_visit: dict[int, dict[str, Exposure]] = {}
    for name, element_activity in touching.items():
        owner = owners[moved_by(robot, element_activity.element.part or "")]
        exposures = ElementExposures(element_activity, samples.step_s)
        table[name] = exposures.over(everywhere)
        for index, own in enumerate(exposures.of_owners(owner, len(visits))):
            if own.grasping_s or own.releases:
                by_visit.setdefault(index, {})[name] = own
    given = [
        replace(
            visit,
            exposures={**visit.exposures, **by_visit.get(index, {})},
            contacts=contacts.get(index, ()),
            payloads=payloads.get(index, ()),
        )
        for index, visit in enumerate(visits)
    ]
    return {**active, **untouched, **table}, tuple(given), run


def collisions(
    robot: Robot, attribution: Attribution, visits: Sequence[Visit]
) -> tuple[Finding, ...]:
    """Return a finding for each pair of bodies whose touch was not to be expected, by function.

    They are in the order in which they began.
    """
    lines = {function.ref: function.line for function in attribution.functions}
    links = frozenset(robot.link_names)
    findings = [
        Finding(
            UNEXPECTED_CONTACT,
            f"unexpected contact: {contact_text(unexpected_contact, contacts, links)}",
            min(contact.start_s for contact in contacts),
            Location(unexpected_contact.function.file, lines[unexpected_contact.function]),
        )
        for unexpected_contact, contacts in unexpected_contacts(visits).items()
    ]
    return tuple(sorted(findings, key=lambda finding: (finding.time_s or 0.0, finding.message)))


def _commanded(
    gripper: str, attribution: Attribution, n_steps: int, step_ns: int
) -> NDArray[np.bool_]:
    """Return in which steps a command that addresses the gripper was live."""
    flags = np.zeros(n_steps, dtype=np.bool_)
    for command in attribution.commands:
        elements = command.command.elements
        if gripper in elements:
            until_ns = command.until_ns[elements.index(gripper)]
            flags[-(-command.command.issue_ns // step_ns) : -(-until_ns // step_ns)] = True
    return flags
