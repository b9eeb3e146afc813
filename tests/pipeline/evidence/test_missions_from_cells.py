"""A campaign, blocks from it, and their chain, against missions drawn from the campaign's cells."""

import json
import math
import random
import re
from itertools import accumulate, pairwise

import pytest
import scipy  # whose statistics, which take a second, are imported when they are used

from tracerisk import api
from tracerisk.common.campaign import CampaignOptions
from tracerisk.common.evidence.cells import FATES

CONTROLLER = """\
import sys
import moveit_commander, rospy

def home(arm):
    arm.set_named_target("ready")
    return arm.go(wait=True)

def turn(arm, side):
    joints = arm.get_current_joint_values()
    joints[0] = side
    return arm.go(joints, wait=True)

def show(arm, side):
    for _ in range(2):
        if turn(arm, side):
            return True
        home(arm)
    return False

def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("show")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(1.0)
    if not show(arm, 0.5):
        return 1  # stops
    shown = show(arm, -0.5)
    home(arm)  # goes on, and does not look whether it arrives
    return 0 if shown else 1

if __name__ == "__main__":
    sys.exit(main())
"""
RATE, FRACTIONS = 60.0, {"dead": 0.5, "jam for 2 s": 0.5}
"""Failures in an hour of use, far more than are real, and what part is of which mode."""
HARDWARE = f"""\
robot: panda
components:
  motor:
    failure_rate: {{value: {RATE}, per: hour}}
    twin: {{joints: [panda_joint1]}}
    modes:
      dead: {{fraction: 0.5, fault: dead}}
      sticks: {{fraction: 0.5, fault: jam, lasts_s: 2}}
"""
SETTINGS = """\
[tool.tracerisk]
hardware = "arm.yaml"
scenario = "mission.yaml"
evidence = true
evidence_cells = 24
"""
SCENARIO = "success:\n  - {joints: {panda_joint1: 0.0}, within: 0.02}\n"
MISSIONS = 100_000


@pytest.fixture(scope="module")
def campaign(tmp_path_factory, example_in):
    """A folder with a controller, its evidence and the blocks that took it."""
    folder = example_in(tmp_path_factory.mktemp("cells"))
    folder.write("show.py", CONTROLLER)
    folder.write("arm.yaml", HARDWARE)
    folder.write("mission.yaml", SCENARIO)
    folder.write("pyproject.toml", SETTINGS)
    path = folder.folder / "show.py"
    found = api.gather_evidence(path, options=CampaignOptions(jobs=1))
    assessed = api.write_blocks(api.assess(path))
    return folder, found, assessed.trace


def test_blocks_hold_each_kind_of_what_followed(campaign):
    folder, found, _ = campaign
    fates = {cell.fate for cell in found.cells if cell.drawn}
    assert fates == {"carried_out", "recovered", "stopped_safely", "stopped_late", "unaware"}
    text = folder.read("show.py").decode()
    for words in ("back to home", "stopped safely", "stopped late", "unaware"):
        assert words in text


def test_missions_drawn_from_the_cells_end_as_often_as_the_chain_says(campaign):
    folder, found, trace = campaign
    mission = folder.run("solve", "show.py", "--json").json["assessment"]["mission"]
    ends = ends_of_missions(found.cells, trace.visits, random.Random(0))
    counted = {
        "geometric_cycles": MISSIONS - ends["done"],
        "undetected_geometric": ends["unaware"] + ends["stopped_late"],
        "stopped_late_geometric": ends["stopped_late"],
        "stopped_safely_geometric": ends["stopped_safely"],
    }
    for name, count in counted.items():
        error = 3.0 * math.sqrt(mission[name] * (1.0 - mission[name]) / MISSIONS)
        assert 0.0 < count / MISSIONS == pytest.approx(mission[name], abs=error), name


def test_figures_and_places_are_in_every_form_that_programs_read(campaign):
    folder, found, _ = campaign
    drawn = [cell for cell in found.cells if cell.drawn]
    undetected = sum(1 for cell in drawn if cell.is_undetected)
    mission = folder.run("solve", "show.py", "--json").json["assessment"]["mission"]
    fraction = mission["undetected_probability"] / mission["failure_probability"]
    assert mission["undetected_fraction"] == pytest.approx(fraction, rel=1e-12)

    said = folder.run("evidence", "show.py", "--show", "--json").json
    assert said["fates"] == {fate: [cell.fate for cell in drawn].count(fate) for fate in FATES}
    tail = scipy.stats.beta(undetected + 1, len(drawn) - undetected)
    assert said["undetected"]["fraction"] == undetected / len(drawn)
    assert said["undetected"]["high"] == pytest.approx(tail.ppf(0.95), rel=1e-6)

    written = ("--metrics", "m.txt", "--sarif", "s.json", "--code-quality", "q.json")
    folder.run("check", "show.py", *written)
    metrics = dict(re.findall(r"^(\S+) (\S+)$", folder.read("m.txt").decode(), re.MULTILINE))
    label = '{controller="show.py"'
    for name in ("undetected_fraction", "stopped_late_probability", "stopped_safely_probability"):
        value = float(metrics[f"tracerisk_mission_{name}{label}}}"])
        assert value == pytest.approx(mission[name], rel=1e-5)
    for fate, count in said["fates"].items():
        assert metrics[f'tracerisk_evidence_failures{label},fate="{fate}"}}'] == str(count)
    for end, key in (("", "fraction"), ("_low", "low"), ("_high", "high")):
        value = float(metrics[f"tracerisk_evidence_undetected_fraction{end}{label}}}"])
        assert value == pytest.approx(said["undetected"][key], rel=1e-5)

    # The blocks that took the evidence have moved the lines: the places go with them.
    lines = folder.read("show.py").decode().splitlines()
    helped = [(place["line"], place["words"]) for place in said["would_help"]]
    assert helped
    assert {lines[line - 1].strip() for line, _ in helped} <= {
        "return arm.go(wait=True)",
        "home(arm)  # goes on, and does not look whether it arrives",
    }
    (run,) = json.loads(folder.read("s.json"))["runs"]
    alerts = [result for result in run["results"] if result["ruleId"] == "undetected-failure"]
    shown, functions = [], set()
    for alert in alerts:
        (place,) = alert["locations"]
        line = place["physicalLocation"]["region"]["startLine"]
        shown.append((line, alert["message"]["text"]))
        function = place["logicalLocations"][0]["fullyQualifiedName"]
        functions.add((lines[line - 1].strip(), function))
    assert sorted(shown) == sorted(helped)
    assert functions <= {
        ("return arm.go(wait=True)", "home"),
        ("home(arm)  # goes on, and does not look whether it arrives", "main"),
    }
    assert len({alert["partialFingerprints"]["tracerisk/v1"] for alert in alerts}) == len(alerts)
    entries = json.loads(folder.read("q.json"))
    mine = [entry for entry in entries if entry["check_name"] == "undetected-failure"]
    assert sorted(
        (one["location"]["lines"]["begin"], one["description"]) for one in mine
    ) == sorted(helped)


def ends_of_missions(cells, visits, draw):
    """Draw missions and count how they end.

    A failure comes at an instant of the visit that is drawn from its time in use, and what follows
    is what followed the cell nearest to that instant.
    """
    lengths = [visit.exposures["panda_joint1"].active_s for visit in visits]
    begins = [0.0, *accumulate(lengths)]
    of_function = {}
    for number, (visit, after) in enumerate(pairwise([*visits, None])):
        following = "done" if after is None else after.function.name
        of_function.setdefault(visit.function.name, []).append((number, following))
    tried = {
        mode: [cell for cell in cells if cell.drawn and cell.mode == mode] for mode in FRACTIONS
    }
    assert all(len(of_mode) >= 10 for of_mode in tried.values())

    def failure(name):
        """Return the cell of what fails in a visit; `None` for nothing."""
        visited = [number for number, _ in of_function[name]]
        in_use_s = [lengths[number] for number in visited]
        if draw.random() >= -math.expm1(-RATE / 3600.0 * sum(in_use_s) / len(visited)):
            return None
        (number,) = draw.choices(visited, in_use_s)
        at_s = begins[number] + draw.uniform(0.0, lengths[number])
        (mode,) = draw.choices(list(FRACTIONS), list(FRACTIONS.values()))
        return min(tried[mode], key=lambda cell: abs(cell.active_s - at_s))

    ends = dict.fromkeys(("done", "unaware", "stopped_late", "stopped_safely"), 0)
    for _ in range(MISSIONS):
        now = visits[0].function.name
        while now not in ends:
            cell = failure(now)
            if cell is None or cell.fate == "carried_out":
                now = draw.choice(of_function[now])[1]
            else:
                now = cell.next_function if cell.fate == "recovered" else cell.fate
        ends[now] += 1
    return ends
