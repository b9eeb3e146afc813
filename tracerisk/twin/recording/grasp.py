"""Find when a gripper holds something between its pads.

A force on both pads is not enough: a closed hand that is pressed on a table has it too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.recording.contact_log import ContactLog
from tracerisk.twin.recording.contact_pairs import pair_touches
from tracerisk.twin.robots.robot import Gripper

Flags = NDArray[np.bool_]


def between_pads(log: ContactLog, gripper: Gripper, n_steps: int) -> Flags:
    """Return the steps in which one thing that can be moved touches all pads, (n_steps,).

    What a controller declares is fixed until it is attached: it is a thing that can be moved if
    it is fast to a link at some time of the run. A link of the robot is none.
    """
    carried = {log.bodies[weld.body].name for weld in log.welds}
    movable = [
        body.kind == "free" or (body.kind == "fixed" and body.name in carried)
        for body in log.bodies
    ]
    pads = {
        place: body.name
        for place, body in enumerate(log.bodies)
        if body.kind == "link" and body.name in gripper.pads
    }
    rows = log.rows
    wanted = np.isin(rows["one"], list(pads)) | np.isin(rows["two"], list(pads))
    touching: dict[str, dict[str, Flags]] = {}
    for pair in pair_touches(ContactLog(log.bodies, (), rows[wanted]), n_steps):
        for pad, thing in ((pair.one, pair.two), (pair.two, pair.one)):
            if pad in pads and movable[thing] and pair.force is not None:
                by_pad = touching.setdefault(log.bodies[thing].name, {})
                flags = by_pad.setdefault(pads[pad], np.zeros(n_steps, dtype=np.bool_))
                flags[pair.steps[pair.steps < n_steps]] = True
    found = np.zeros(n_steps, dtype=np.bool_)
    for by_pad in touching.values():
        if len(by_pad) == len(gripper.pads):
            found |= np.logical_and.reduce(list(by_pad.values()))
    return found
