"""Broken descriptions, each with what is said of it."""

from typing import NamedTuple


class Broken(NamedTuple):
    """A description, the whole message, and whether its structure alone is wrong.

    A schema sees the structure: keys, types, bounds, and which keys go together.
    """

    text: str
    message: str
    structural: bool


def _one(*lines: str) -> str:
    """Return a description of one component, whose keys are the lines."""
    return "components:\n  a:\n" + "".join(f"    {line}\n" for line in lines)


BROKEN = (
    Broken(
        _one("mtbf: 200000"),
        "h.yaml:3:5: components.a.mtbf: the number 200000 has no unit; write {value: 200000, unit: hour}",
        True,
    ),
    Broken(
        _one("b10d: 5000000"),
        "h.yaml:3:5: components.a.b10d: the number 5000000 has no unit; write {value: 5000000}, in cycles",
        True,
    ),
    Broken(
        _one("mtbf_h: long"),
        "h.yaml:3:5: unknown key 'mtbf_h' in components.a; write 'mtbf: {value: NUMBER, unit: hour}' among the keys of the component",
        True,
    ),
    Broken(
        _one("failure_rate: {MTTFd: 75000}"),
        "h.yaml:3:20: unknown key 'MTTFd' in components.a.failure_rate; write 'mttfd: {value: 75000, unit: hour}' among the keys of the component",
        True,
    ),
    Broken(
        _one("temperature: {rated: 40, working: 55, activation_energy: 0.7}"),
        "h.yaml:3:5: unknown key 'temperature' in components.a; it belongs in a mean time or a rate, as in mtbf: {value: 42000, unit: hour, temperature: {rated: 40, working: 55, activation_energy: 0.7}}",
        True,
    ),
    Broken(
        _one("reference_load: 0.3"),
        "h.yaml:3:5: unknown key 'reference_load' in components.a; it belongs in 'load_law'",
        True,
    ),
    Broken(
        _one("mtbf_h: {value: 200000, per: hour}"),
        "h.yaml:3:5: unknown key 'mtbf_h' in components.a; write 'mtbf: {value: 200000, unit: hour}' among the keys of the component",
        True,
    ),
    Broken(
        _one("B10d: 2000000"),
        "h.yaml:3:5: unknown key 'B10d' in components.a; write 'b10d: {value: 2000000}' among the keys of the component",
        True,
    ),
    Broken(
        _one("mttf: {value: 0, unit: hour}"),
        "h.yaml:3:12: components.a.mttf.value: is 0; give a number above 0",
        True,
    ),
    Broken(
        _one("mttf: {value: 7}"),
        "h.yaml:3:11: 'unit' is missing in components.a.mttf; give it one",
        True,
    ),
    Broken(
        _one("mttf: {value: 7, unit: year, dangerous: 0.5}"),
        "h.yaml:3:34: unknown key 'dangerous' in components.a.mttf; allowed: error_factor, source, temperature, unit, value, value_is",
        True,
    ),
    Broken(
        _one("twin: {gripper: true}", "b10: {value: 2e7, of: grasp, cycles: {value: 3, per: day}}"),
        "h.yaml:4:23: components.a.b10.of: the cycles are given, so no demand is counted; remove one of them",
        True,
    ),
    Broken(
        _one("twin: {gripper: true}", "b10d: {value: 1, dangerous: 0.05}"),
        "h.yaml:4:12: components.a.b10d.value: gives a probability per cycle above 1 with what stands beside it; mend one of them",
        False,
    ),
    Broken(
        _one(
            "mtbf: {value: 7, unit: hour, temperature: {rated: 40, working: 900, activation_energy: 0.7}}"
        ),
        "h.yaml:3:59: components.a.mtbf.temperature.working: 900 is outside [-100, 400]",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, unit: hour}"),
        "h.yaml:3:33: components.a.failure_rate.unit: 'hour' is not allowed; allowed: FIT, or write per: hour instead",
        True,
    ),
    Broken(
        _one("failure_rate: 5e-6"),
        "h.yaml:3:5: components.a.failure_rate: the number 5e-06 has no unit; write {value: 5e-06, per: hour} or {value: 5e-06, unit: FIT}",
        True,
    ),
    Broken(
        _one("weibull: 3"),
        "h.yaml:3:5: components.a.weibull: the number 3 has no unit; write {shape: SHAPE, scale: 3, per: hour}",
        True,
    ),
    Broken(
        _one("failure_rate: []"),
        "h.yaml:3:5: components.a.failure_rate: is an empty list; give a figure, or remove it",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6}"),
        "h.yaml:3:19: 'per' is missing in components.a.failure_rate; give it one",
        True,
    ),
    Broken(
        _one("failure_rate: [{value: 1e-6, per: hour}, {value: 1e-6, per: day}]"),
        "h.yaml:3:60: components.a.failure_rate[1].per: 'day' is not allowed; allowed: hour, minute",
        True,
    ),
    Broken(
        _one("failure_rate: [3]"),
        "h.yaml:3:20: components.a.failure_rate: entry 1: expected a mapping, found the number 3",
        True,
    ),
    Broken(
        _one("probability: {value: 1e-7, per: hour, of: grasp}"),
        "h.yaml:3:43: components.a.probability.of: the figure is per hour, not per demand; remove 'of'",
        True,
    ),
    Broken(
        _one("probability: {value: 1e-7, per: demand, of: wave}"),
        "h.yaml:3:45: components.a.probability.of: 'wave' is not allowed; allowed: grasp, release, start",
        True,
    ),
    Broken(
        _one("probability: {value: 1e-7, per: demand, of: grasp}", "twin: {joints: [j1]}"),
        "h.yaml:3:5: a.probability: is per grasp, but only a gripper grasps and releases; bind it to the gripper (twin: {gripper: true}), or use 'of: start'",
        False,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour, error_factor: 0.5}"),
        "h.yaml:3:44: components.a.failure_rate.error_factor: 0.5 is outside [1, inf]",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour, value_is: mean}"),
        "h.yaml:3:44: components.a.failure_rate.value_is: has no effect without 'error_factor'; give it, or remove both",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour, error_factor: 3, value_is: mode}"),
        "h.yaml:3:61: components.a.failure_rate.value_is: 'mode' is not allowed; allowed: mean, median",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour, unit: FIT}"),
        "h.yaml:3:33: components.a.failure_rate.per: FIT means failures per 1e9 hours; remove 'per'",
        True,
    ),
    Broken(
        _one("failure_rate: {value: .inf, per: hour}"),
        "h.yaml:3:20: components.a.failure_rate.value: expected a finite number, found inf",
        False,
    ),
    Broken(
        _one("failure_rate: {value: " + "9" * 400 + ", per: hour}"),
        "h.yaml:3:20: components.a.failure_rate.value: expected a finite number, found one of 400 digits",
        False,
    ),
    Broken(
        _one("failure_rate: {value: '1e-6', per: hour}"),
        "h.yaml:3:20: components.a.failure_rate.value: expected a number, found the string '1e-6'",
        True,
    ),
    Broken(
        _one("weibull: {shape: 0, scale: 30000, per: hour}"),
        "h.yaml:3:15: components.a.weibull.shape: is 0; give a number above 0",
        True,
    ),
    Broken(
        _one("weibull: {shape: 2, scale: -1, per: hour}"),
        "h.yaml:3:25: components.a.weibull.scale: -1 is outside [0, inf]",
        True,
    ),
    Broken(
        _one("weibull: {shape: 2, scale: 3, per: demand}"),
        "h.yaml:3:35: components.a.weibull.per: 'demand' is not allowed; allowed: hour, minute",
        True,
    ),
    Broken(
        _one("weibull: {scale: 3, per: hour}"),
        "h.yaml:3:14: 'shape' is missing in components.a.weibull; give it one",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "age: {value: 12000, per: hour}"),
        "h.yaml:4:5: a.age: applies to wear-out only; give 'weibull: {shape: 2, scale: 30000, per: hour}', or leave it out",
        True,
    ),
    Broken(
        _one("weibull: {shape: 2, scale: 3, per: hour}", "age: 12000"),
        "h.yaml:4:5: components.a.age: the number 12000 has no unit; write {value: 12000, per: hour}",
        True,
    ),
    Broken(
        _one("weibull: {shape: 2, scale: 3, per: hour}", "age: {value: 1, per: day}"),
        "h.yaml:4:21: components.a.age.per: 'day' is not allowed; allowed: hour, minute, second",
        True,
    ),
    Broken(
        _one("standby_rate: {value: 1e-6, per: hour}", "active: always"),
        "h.yaml:3:5: a.standby_rate: a component that is always active has no standby time; remove it",
        True,
    ),
    Broken(
        _one("probability: {value: 1e-7, per: demand}", "active: always"),
        "h.yaml:3:5: a.probability: a component that is always active has no demands; give its figure per time",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}", "active: always", "common_cause: {beta: 0.1}"
        ),
        "h.yaml:5:5: components.a.common_cause: applies to redundant units; when all units are needed, one failure is enough (redundancy: true, required: k or spare: hot)",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "common_cause: {beta: 1.5}",
        ),
        "h.yaml:7:20: components.a.common_cause.beta: 1.5 is outside [0, 1]",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "common_cause: 0.1",
        ),
        "h.yaml:7:5: components.a.common_cause: expected a mapping, found the number 0.1",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 3",
            "redundancy: false",
            "required: 2",
        ),
        "h.yaml:7:5: components.a.required: applies to redundant units, but 'redundancy' is false; remove one",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}", "active: always", "quantity: 2", "required: 3"
        ),
        "h.yaml:6:5: a.required: 3 must work, but the quantity is 2; allowed: less than that, or more units",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}", "active: always", "quantity: 2", "required: 2"
        ),
        "h.yaml:6:5: a.required: 2 of 2 must work, so no unit is redundant; remove it, or give more units",
        False,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "quantity: 2", "required: 0"),
        "h.yaml:5:5: components.a.required: 0 is below 1",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "spare: tepid",
        ),
        "h.yaml:6:5: components.a.spare: 'tepid' is not allowed; allowed: cold, hot, warm",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}", "active: always", "quantity: 2", "spare: warm"
        ),
        "h.yaml:6:5: components.a.spare: a warm spare needs 'dormancy', its failure rate as a share of a working unit's",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "spare: cold",
            "dormancy: 0.1",
        ),
        "h.yaml:7:5: components.a.dormancy: is 0 for a cold spare; remove it",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "spare: warm",
            "dormancy: 1",
        ),
        "h.yaml:7:5: components.a.dormancy: is 1, the dormancy of a hot spare; write 'spare: hot'",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "switch: 0.01",
        ),
        "h.yaml:7:5: components.a.switch: is the probability that a spare fails to take over; give 'spare' too",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "dormancy: 0.01",
        ),
        "h.yaml:7:5: components.a.dormancy: applies to a warm spare; give 'spare: warm' too",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "active: always", "dormancy: 0.01"),
        "h.yaml:5:5: components.a.dormancy: applies to spares; give 'spare: hot', 'warm' or 'cold', or remove it",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "active: always", "spare: cold"),
        "h.yaml:5:5: a.spare: there is only 1 unit; give a quantity of 2 or more, or remove it",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "redundancy: true",
            "common_cause: {beta: 0.1}",
        ),
        "h.yaml:6:5: a.common_cause: there is only 1 unit; give a quantity of 2 or more, or remove it",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "detected: {test_interval: 8, per: day}",
        ),
        "h.yaml:7:34: components.a.detected.per: 'day' is not allowed; allowed: hour, minute, second",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "repair: {mean_time: 0, per: hour}",
        ),
        "h.yaml:7:14: components.a.repair.mean_time: is 0; give a number above 0",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "repair: {rate: -1, per: hour}",
        ),
        "h.yaml:7:14: components.a.repair.rate: -1 is outside [0, inf]",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "repair: 8",
        ),
        "h.yaml:7:5: components.a.repair: the number 8 has no unit; write {mean_time: 8, per: hour}",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "repair: {mean_time: 8, rate: 1, per: hour}",
        ),
        "h.yaml:7:5: components.a.repair: needs either 'mean_time' or 'rate'; write {mean_time: 8, per: hour}",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "repair: {mean_time: 8}",
        ),
        "h.yaml:7:13: 'per' is missing in components.a.repair; give it one",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: false",
            "repair: {mean_time: 8, per: hour}",
        ),
        "h.yaml:7:5: a.repair: applies to redundant units; where all are needed the first failure ends the mission, whatever its repair; remove it",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "quantity: 2",
            "redundancy: true",
            "detected: {test_interval: 8, per: hour}",
            "repair: {mean_time: 8, per: hour}",
        ),
        "h.yaml:8:5: a.repair: 'detected' says already when failed units are replaced; remove one of the two",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {gripper: true}",
            "quantity: 2",
            "redundancy: true",
            "repair: {mean_time: 8, per: hour, in_mission: true}",
        ),
        "h.yaml:7:5: a.repair: within missions needs failures that are spread evenly over them: 'active: always' and figures per time; remove 'in_mission', and repair counts between missions only",
        False,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "active: always", 'lot: "A 7"'),
        "h.yaml:5:5: a.lot: has no effect, because no figure of the component has an error factor; give one, or remove it",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour, error_factor: 3}", "active: always", 'lot: ""'
        ),
        "h.yaml:5:5: a.lot: is empty; name the lot, or remove it",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}", "active: always", "exposure_error_factor: 0.5"
        ),
        "h.yaml:5:5: components.a.exposure_error_factor: 0.5 is outside [1, inf]",
        True,
    ),
    Broken(
        _one("probability: 1e-6", "active: always", "exposure_error_factor: 2"),
        "h.yaml:5:5: a.exposure_error_factor: is that of the use that figures count, and figures per visit count none; give figures per time or demand, or remove it",
        False,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "quantity: many", "twin: {joints: [j1]}"),
        "h.yaml:4:5: components.a.quantity: 'many' is not allowed; write a whole number, or \"*\" for the number that the robot has",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", 'quantity: "*"'),
        "h.yaml:4:5: a.quantity: is the number that the robot has, but no 'twin' says where to count; give a number",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "modes: {jam: {fraction: 0.7, when: [moving]}, slip: {fraction: 0.4, when: [holding]}}",
        ),
        "h.yaml:5:5: a.modes: the fractions sum to 1.1; they may sum to at most 1",
        False,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "twin: {joints: [j1]}", "modes: {}"),
        "h.yaml:5:5: components.a.modes: is empty; give a mode such as jam: {fraction: 0.4, when: [moving]}",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "modes: {jam: {fraction: 0, when: [moving]}}",
        ),
        "h.yaml:5:19: components.a.modes.jam.fraction: is 0; give a fraction above 0 and at most 1",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "modes: {jam: {fraction: 0.4}}",
        ),
        "h.yaml:5:5: a.modes: the fractions sum to 0.4; fractions of modes without 'when' must sum to 1",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "modes: {jam: {fraction: 0.4}, dead: {fraction: 0.6, when: [moving]}}",
        ),
        "h.yaml:5:13: a.modes.jam: has no 'when', but other modes have one; give it to all modes, or to none",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "modes: {jam: {fraction: 0.4, when: []}}",
        ),
        "h.yaml:5:34: components.a.modes.jam.when: is an empty list; allowed: grasp, grasping, holding, moving, release, start",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "modes: {jam: {fraction: 0.4, when: [moving, movin]}}",
        ),
        "h.yaml:5:49: components.a.modes.jam.when: 'movin' is not allowed; did you mean 'moving'? allowed: grasp, grasping, holding, moving, release, start",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "modes: {jam: {fraction: 0.4, when: [moving, moving]}}",
        ),
        "h.yaml:5:49: components.a.modes.jam.when: names 'moving' twice",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "modes:",
            "  jam: {fraction: 0.4, when: [start]}",
        ),
        "h.yaml:6:28: a.modes.jam.when: 'start' has no effect, because the component has no figure per demand of 'start'; remove it, or give such a figure",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "modes:",
            "  drop: {fraction: 0.4, when: [grasping]}",
        ),
        "h.yaml:6:29: a.modes.drop.when: the twin does not report 'grasping' for the binding of this component; allowed: holding, moving, start",
        False,
    ),
    Broken(
        _one(
            "probability: {value: 1e-7, per: demand, of: grasp}",
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {gripper: true}",
            "modes:",
            "  opens: {fraction: 0.4, when: [moving, release]}",
        ),
        "h.yaml:7:30: a.modes.opens.when: 'release' has no effect, because the component has no figure per demand of 'release'; remove it, or give such a figure",
        False,
    ),
    Broken(
        _one(
            "probability: {value: 1e-7, per: demand}",
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {gripper: true}",
            "modes:",
            "  opens: {fraction: 0.4, when: [moving]}",
        ),
        "h.yaml:6:5: a.modes: no failure mode uses the figure per demand, so it has no effect; name in a mode's 'when' one of: start, grasp, release",
        False,
    ),
    Broken(
        _one(
            "probability: 1e-7",
            "twin: {joints: [j1]}",
            "modes: {jam: {fraction: 0.4, when: [moving]}}",
        ),
        "h.yaml:5:34: a.modes.jam.when: 'moving' has no effect, because the component has no figure per time in use; remove it, or give such a figure",
        False,
    ),
    Broken(
        _one(
            "active: always",
            "failure_rate: {value: 1e-6, per: hour}",
            "modes: {jam: {fraction: 0.4, when: [moving]}}",
        ),
        "h.yaml:5:5: a.modes: the twin does not measure use and load of a component that is always active; bind it (twin: ...) instead of 'active: always', or remove this",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "active: always",
            "load_law: {reference_load: 0.3, wearing_share: 0.6}",
        ),
        "h.yaml:5:5: a.load_law: the twin does not measure use and load of a component that is always active; bind it (twin: ...) instead of 'active: always', or remove this",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {sensors: camera}",
            "load_law: {reference_load: 0.3, wearing_share: 0.6}",
        ),
        "h.yaml:5:5: a.load_law: needs a moving component; bind it to joints, actuators or the gripper, or remove it",
        False,
    ),
    Broken(
        _one(
            "probability: {value: 1e-7, per: demand}",
            "twin: {joints: [j1]}",
            "load_law: {reference_load: 0.3, wearing_share: 0.6}",
        ),
        "h.yaml:5:5: a.load_law: has no effect, because the component has no figure per time in use (probability, failure_rate or weibull per hour); give one, or leave it out",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "load_law: {reference_load: 0.3, wearing_share: 0.6}",
            "modes: {slip: {fraction: 0.4, when: [holding]}}",
        ),
        "h.yaml:5:5: a.load_law: has no effect, because no failure mode counts while moving; name 'moving' in a mode's 'when', or leave it out",
        False,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "load_law: {reference_load: 0, wearing_share: 0.6}",
        ),
        "h.yaml:5:16: components.a.load_law.reference_load: is 0; give a fraction above 0 and at most 1",
        True,
    ),
    Broken(
        _one(
            'twin: {joints: "*"}',
            "failure_rate: {value: 1e-6, per: hour}",
            "load_law: {reference_load: 1e-40, wearing_share: 0.6, exponent: 9}",
        ),
        "h.yaml:5:16: a.load_law.reference_load: 1e-40 is not a fraction of the rated value; allowed: 0.001 to 1",
        True,
    ),
    Broken(
        _one(
            'twin: {joints: "*"}',
            "failure_rate: {value: 1e-6, per: hour}",
            "load_law: {reference_load: 0.3, wearing_share: 0.6, reference_speed: 1e-4}",
        ),
        "h.yaml:5:57: a.load_law.reference_speed: 0.0001 is not a fraction of the rated value; allowed: 0.001 to 1",
        True,
    ),
    Broken(
        _one("twin: {sensors: camera}", "probability: {value: 1e-6, per: demand}"),
        "h.yaml:4:5: a.probability: is per demand, but cameras and wrench sensors have no demands; give it per time",
        False,
    ),
    Broken(
        _one("twin: {contacts: [finger]}", "probability: {value: 1e-6, per: demand, of: start}"),
        "h.yaml:4:5: a.probability: is per start, but a contact starts no motion; use 'of: grasp'",
        False,
    ),
    Broken(
        _one(
            "twin: {contacts: [finger]}",
            "failure_rate: {value: 1e-6, per: hour}",
            "modes: {jam: {fraction: 1, when: [moving]}}",
        ),
        "h.yaml:5:32: a.modes.jam.when: the twin does not report 'moving' for the binding of this component; allowed: grasp, grasping, release",
        False,
    ),
    Broken(
        _one(
            "twin: {sensors: camera}",
            "failure_rate: {value: 1e-6, per: hour}",
            "modes: {blind: {fraction: 1, when: [holding]}}",
        ),
        "h.yaml:5:34: a.modes.blind.when: the twin does not report 'holding' for the binding of this component; leave 'modes' out",
        False,
    ),
    Broken(
        _one("active: always", "quantity: 10001", "failure_rate: {value: 1e-6, per: hour}"),
        "h.yaml:4:5: a.quantity: 10001 are too many units to model; allowed: up to 10000; describe an assembly of many as one component, by its own figure",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "load_law: {reference_load: 0.3, wearing_share: 60}",
        ),
        "h.yaml:5:37: components.a.load_law.wearing_share: 60 is outside [0, 1]",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "load_law: {reference_load: 0.3, wearing_share: 0.6, exponent: 3.5}",
        ),
        "h.yaml:5:57: components.a.load_law.exponent: 3.5 is not an exponent whose wear a run measures; allowed: 1, 2, 3, 10/3, 4, 6, 9",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "load_law: {reference_load: 0.3, wearing_share: 0.6, exponent: 7/2}",
        ),
        "h.yaml:5:57: components.a.load_law.exponent: 7/2 is not an exponent whose wear a run measures; allowed: 1, 2, 3, 10/3, 4, 6, 9",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "twin: {joints: [j1]}",
            "load_law: {reference_lod: 0.3}",
        ),
        "h.yaml:5:16: unknown key 'reference_lod' in components.a.load_law; did you mean 'reference_load'? allowed: exponent, reference_load, reference_speed, source, wearing_share",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "twin: {grippers: true}"),
        "h.yaml:4:12: unknown key 'grippers' in components.a.twin; did you mean 'gripper'? allowed: actuators, contacts, gripper, joints, optional, sensors",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "twin: {optional: true}"),
        "h.yaml:4:5: components.a.twin: is empty; allowed: actuators, contacts, gripper, joints, sensors, or write 'active: always' instead",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "twin: {joints: [j1], optional: true}"),
        "h.yaml:4:26: components.a.twin.optional: only a component of the gripper, of sensors or of all joints can be optional",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "twin: {sensors: lidar}"),
        "h.yaml:4:12: components.a.twin.sensors: 'lidar' is not a kind of sensor; allowed: camera, encoder, torque, wrench, or a list of sensors by name",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "twin: {sensors: []}"),
        "h.yaml:4:12: components.a.twin.sensors: is an empty list; name a sensor or write a kind, such as encoder",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "twin: {actuators: [j1, j1]}"),
        "h.yaml:4:28: components.a.twin.actuators: names 'j1' twice",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "twin: {contacts: hand}"),
        "h.yaml:4:12: components.a.twin.contacts: expected a list, found the string 'hand'",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "twin: {joints: [1]}"),
        "h.yaml:4:21: components.a.twin.joints: entry 1: expected a list of strings, found the number 1 in it",
        True,
    ),
    Broken(
        _one("failure_rate: {value: 1e-6, per: hour}", "twin: gripper"),
        "h.yaml:4:5: components.a.twin: expected a mapping, found the string 'gripper'",
        True,
    ),
    Broken(
        _one(
            "failure_rate: {value: 1e-6, per: hour}",
            "quantity: 3",
            "twin: {joints: [j1], sensors: [s1]}",
        ),
        "h.yaml:4:5: a.quantity: is 3, but its 'twin' names 2 places; give 'quantity: 2', one unit a place",
        False,
    ),
)
