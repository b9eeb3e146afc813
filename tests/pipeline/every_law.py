"""A mission's figure by every law there is, and evidence that is made up, for any run.

How a controller's code is cut into functions may change neither.
"""

import json
import math
from dataclasses import replace
from pathlib import Path

from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.adder.quantify.evidence_shares import EvidenceShares
from tracerisk.common import trace_json
from tracerisk.common.evidence.cells import Cell, Evidence
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.traced.elements import Exposure

CELLS = 40
MODES = {"gripper": ("no_force", "stuck"), "joint": ("dead", "jam")}
EVERY_LAW = """\
components:
  motor:
    failure_rate: {value: 5.7e-04, per: hour}
    standby_rate: {value: 1.0e-03, per: hour}
    weibull: {shape: 2.0, scale: 3000, per: hour}
    age: {value: 1200, per: hour}
    load_law: {reference_load: 0.3, wearing_share: 0.6, exponent: 10/3}
    modes:
      lost_torque: {fraction: 0.6, when: [moving, holding], fault: dead}
      jam: {fraction: 0.3, when: [moving], fault: jam}
    twin: {joints: "*"}
  hand:
    probability: {value: 1.0e-5, per: demand}
    standby_rate: {value: 1.0e-2, per: hour}
    modes:
      fails_to_close: {fraction: 0.5, when: [grasp], fault: no_force}
      fails_to_open: {fraction: 0.5, when: [release], fault: stuck}
    twin: {gripper: true, optional: true}
"""


def figure_by_every_law(trace, folder: Path, evidence: EvidenceShares | None = None) -> float:
    """Return a mission's figure with rates, load, ageing, modes, standby and demands."""
    path = folder / "every_law.yaml"
    path.write_text(EVERY_LAW)
    known = trace_json.loads(json.dumps(trace), "trace")
    blocks = compute_blocks(
        known, read_hardware(path), active="moving+holding", evidence=evidence
    ).blocks
    hazards = (
        -entry.quantity.value * math.log1p(-entry.probability.value)
        for visit in known.visits
        for entry in blocks[visit.function].components
    )
    return -math.expm1(-math.fsum(hazards))


def made_up(trace) -> EvidenceShares:
    """Evidence of cells spread over all uses of all units, of which most end the mission.

    The stretches have the use of a unit unevenly, as those of a real run.
    """
    cells = []
    end_s = trace["end"]["simulated_s"]
    kinds = {each["name"]: each["kind"] for each in trace["elements"]}
    for name, use in trace["active"].items():
        if kinds[name] not in MODES:
            continue
        modes = MODES[kinds[name]]
        states = [use["moving_s"], use["holding_s"], use["grasping_s"]]
        whole = Exposure(**{**use, "wear": tuple(use["wear"])})
        for mode in modes:
            for index in range(CELLS):
                share = (index + 0.5) / CELLS
                fails = (7 * index + len(name)) % 10 < 6
                active_s = share * use["active_s"]
                at = tuple(share * each for each in states)
                uneven = 2.0 * (1.0 + index) / (CELLS * (CELLS + 1))
                stretch = replace(
                    whole,
                    moving_s=whole.moving_s / CELLS,
                    holding_s=whole.holding_s / CELLS,
                    active_s=whole.active_s / CELLS,
                    travel_s=whole.travel_s * uneven,
                    wear=tuple(each * uneven for each in whole.wear),
                    grasps=whole.grasps * (index == 3),
                    releases=whole.releases * (index == 5),
                )
                start = ("part", name, mode, share * end_s)
                cells.append(Cell(*start, "active", "f", True, active_s, at, stretch, fails=fails))
                idle_s = end_s - use["active_s"]
                key = ("part", name, mode, active_s + share * idle_s + 1e-4)
                cells.append(
                    Cell(
                        *(*key, "idle", "f", True, active_s, at),
                        idle_s=idle_s / CELLS,
                        fails=not fails,
                    )
                )
    return EvidenceShares(Evidence("f", "panda", 0, len(cells), ("done",), cells=tuple(cells)))
