"""What is printed of a derivation, recomputed from the trace's JSON with arithmetic of its own."""

import json
import math
import re
from dataclasses import replace

import pytest

from tracerisk.adder.blocks.block import Field
from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.adder.figures.derivation_json import derivation_data
from tracerisk.adder.figures.derive import derive_function, function_named
from tracerisk.common import trace_json
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.traced.elements import WEAR_EXPONENTS, Element, Exposure
from tracerisk.errors import InputError
from tracerisk.report.explain.function import render_derivation
from tracerisk.trace import Cycle, RunEnd, Trace, TracedFunction, Visit

CARRY = FunctionRef("cell.py", QualifiedName("carry"))
REST = FunctionRef("cell.py", QualifiedName("rest"))
HARDWARE = """\
components:
  motor:
    failure_rate: {value: 5.7e-3, per: hour, source: "data book, table 7"}
    standby_rate: {value: 1.0e-4, per: hour}
    load_law: {reference_load: 0.3, wearing_share: 0.6, exponent: 10/3, source: "life law"}
    modes:
      lost_torque: {fraction: 0.6, when: [moving, holding]}
      jam: {fraction: 0.3, when: [moving]}
    twin: {joints: "*"}
  bearing:
    weibull: {shape: 2.5, scale: 3, per: hour}
    age: {value: 1, per: hour}
    load_law: {reference_load: 0.2, wearing_share: 1.0, reference_speed: 0.4}
    twin: {joints: "*"}
  hand:
    probability: [{value: 1.0e-4, per: demand}, {value: 2.0e-5, per: demand, of: release}]
    twin: {gripper: true}
  brake:
    probability: {value: 0.02, per: minute}
    required: 2
    twin: {joints: "*"}
  power:
    failure_rate: {value: 9.0e+6, unit: FIT}
    quantity: 3
    required: 2
    detected: each_visit
    active: always
  supply:
    failure_rate: {value: 2.0e-3, per: hour}
    quantity: 2
    redundancy: true
    active: always
  fan:
    probability: 1.0e-6
    twin: {joints: [j1]}
"""


def moved(seconds: float, holding: float, speed: float, load: float, **fields) -> Exposure:
    travel = seconds * speed
    return Exposure(
        moving_s=seconds,
        holding_s=holding,
        active_s=seconds + holding,
        longest_moving_s=seconds,
        longest_active_s=seconds + holding,
        travel_s=travel,
        wear=tuple(travel * load**k for k in WEAR_EXPONENTS) if seconds else (),
        **fields,
    )


def visit(function, start, seconds, *joints, hand=(0, 0)):
    exposures = {f"j{n}": exposure for n, exposure in enumerate(joints, start=1)}
    grasped = Exposure(
        grasping_s=seconds,
        active_s=seconds,
        longest_active_s=seconds,
        grasps=hand[0],
        releases=hand[1],
    )
    return Visit(function, start, seconds, "succeeded", {**exposures, "hand": grasped})


TRACE = Trace(
    controller="cell.py",
    robot="",
    scene="bench",
    end=RunEnd("ended", "returned", 21.5),
    elements=(
        *(Element(f"j{n}", "joint") for n in (1, 2, 3)),
        Element("hand", "gripper"),
    ),
    functions=(TracedFunction(REST, 1, 1), TracedFunction(CARRY, 9, 2)),
    visits=(
        visit(REST, 0.0, 4.0, moved(1.0, 0.5, 0.3, 0.1), moved(2.0, 1.0, 0.2, 0.2), Exposure()),
        visit(
            CARRY,
            4.0,
            6.5,
            moved(3.0, 1.5, 0.5, 0.4),
            moved(2.5, 3.0, 0.25, 0.6),
            moved(0.0, 6.0, 0.0, 0.0),
            hand=(2, 1),
        ),
        visit(REST, 10.5, 2.0, moved(0.5, 0.0, 0.6, 0.2), Exposure(), Exposure()),
        visit(
            CARRY,
            12.5,
            9.0,
            moved(5.0, 2.0, 0.4, 0.5),
            moved(4.5, 0.0, 0.35, 0.3),
            moved(1.0, 7.0, 0.1, 0.7),
            hand=(1, 2),
        ),
    ),
)


@pytest.fixture(scope="module")
def hardware(tmp_path_factory):
    path = tmp_path_factory.mktemp("hardware") / "cell.yaml"
    path.write_text(HARDWARE)
    return read_hardware(path, shown="cell.yaml")


@pytest.fixture(scope="module")
def derivation(hardware):
    blocks = compute_blocks(TRACE, hardware, active="moving+holding").blocks
    return derive_function(TRACE, hardware, CARRY, active="moving+holding", block=blocks[CARRY])


@pytest.fixture(scope="module")
def text(derivation):
    return render_derivation(derivation)


def part(text: str, component: str) -> str:
    """What is printed of one component."""
    parts = {each.split(":", 1)[0]: each for each in text.split("\n\n")[1:]}
    return parts[component]


def tables(text: str) -> list[dict[str, list[str]]]:
    """The tables in a text: for each row its cells, the headings under an empty name."""
    found: list[dict[str, list[str]]] = []
    for line in text.splitlines():
        heading = re.fullmatch(r" {8,}(\S.*)", line)
        if heading:
            found.append({"": re.split(r"\s{2,}", heading[1].strip())})
            continue
        row = re.fullmatch(
            r"    ((?:visit )?\S+(?: \(x\d+\))?|always active \(x\d\))(\s{2,}.*)", line
        )
        if row and found:
            found[-1][row[1]] = re.split(r"\s{2,}", row[2].strip())
    return found


def column(table: dict[str, list[str]], heading: str) -> dict[str, float]:
    at = table[""].index(heading)
    return {name: float(cells[at]) for name, cells in table.items() if name not in ("", "sum")}


def printed(text: str, pattern: str) -> float:
    found = re.search(pattern, text)
    assert found is not None, f"{pattern} in\n{text}"
    return float(found[1])


def close(expected):
    """To the eight digits that are printed."""
    return pytest.approx(expected, rel=6e-8)


@pytest.fixture(scope="module")
def data():
    """The trace as its file has it."""
    return json.loads(trace_json.dumps(TRACE))


def visits_in(data, function="carry"):
    return [each for each in data["visits"] if each["function"]["name"] == function]


def total(visits, joint, field):
    return sum(each["exposures"][joint][field] for each in visits)


JOINTS = ("j1", "j2", "j3")


def test_every_line_fits_a_terminal_of_80_columns(text):
    assert max(map(len, text.splitlines())) <= 80
    assert text.splitlines()[0] == "carry (cell.py): 2 visits, 15.5 s"


def test_the_motors_are_recomputed_from_the_trace(text, data):
    shown = part(text, "motor")
    load, torque, jam, idle, together, by_visit = tables(shown)
    here, everywhere = visits_in(data), data["visits"]
    k = WEAR_EXPONENTS.index(10 / 3)

    def wear(visits, joint):
        return sum(
            each["exposures"][joint]["wear"][k]
            for each in visits
            if each["exposures"][joint]["wear"]
        )

    speed = {j: total(everywhere, j, "travel_s") / total(everywhere, j, "moving_s") for j in JOINTS}
    worn = {j: wear(here, j) / (speed[j] * 0.3 ** (10 / 3)) for j in JOINTS}
    assert column(load, "wear [s]") == close({j: wear(here, j) for j in JOINTS})
    assert column(load, "v0") == close(speed)
    assert column(load, "W [s]") == close(worn)
    assert column(load, "L") == close(
        {j: (wear(here, j) / total(here, j, "travel_s")) ** 0.3 for j in JOINTS}
    )
    moving = {j: total(here, j, "moving_s") for j in JOINTS}
    holding = {j: total(here, j, "holding_s") for j in JOINTS}
    rate = 5.7e-3 / 3600
    assert printed(shown, r"failure rate 0.0057 per hour, by 3600 s: (\S+) per s") == close(rate)
    either = {j: 0.4 * (moving[j] + holding[j]) + 0.6 * worn[j] for j in JOINTS}
    alone = {j: 0.4 * moving[j] + 0.6 * worn[j] for j in JOINTS}
    assert column(torque, "T [s]") == close({j: moving[j] + holding[j] for j in JOINTS})
    assert column(torque, "counts [s]") == close(either)
    assert column(torque, "hazard of each") == close({j: rate * 0.6 * either[j] for j in JOINTS})
    assert column(jam, "counts [s]") == close(alone)
    assert column(jam, "hazard of each") == close({j: rate * 0.3 * alone[j] for j in JOINTS})
    lasted = sum(each["duration_s"] for each in here)
    rest = {j: lasted - total(here, j, "active_s") for j in JOINTS}
    assert column(idle, "hazard of each") == close({j: 1e-4 / 3600 * rest[j] for j in JOINTS})
    sums = {j: rate * (0.6 * either[j] + 0.3 * alone[j]) + 1e-4 / 3600 * rest[j] for j in JOINTS}
    assert column(together, "hazard of each") == close(sums)
    assert sum(column(by_visit, "hazard of all units").values()) == close(sum(sums.values()))
    assert list(column(by_visit, "lasts [s]").values()) == [6.5, 9.0]
    p = -math.expm1(-sum(sums.values()) / 6)
    assert printed(shown, r"1 - exp\(-\S+ / \(2 x 3\)\) = (\S+)") == close(p)
    assert shown.endswith(f"\n  block: probability = {p:.4g}")
    assert "source: data book, table 7" in shown
    assert "source: life law" in shown


def test_ageing_is_recomputed_from_the_trace(text, data):
    shown = part(text, "bearing")
    _, table, by_visit = tables(shown)
    cubic = WEAR_EXPONENTS.index(3.0)

    def worn(visits, joint):
        exposures = (each["exposures"][joint] for each in visits)
        return sum(e["wear"][cubic] for e in exposures if e["wear"]) / (0.4 * 0.2**3)

    whole = {j: worn(data["visits"], j) for j in JOINTS}
    rate = {
        j: (((3600 + whole[j]) / 10800) ** 2.5 - (3600 / 10800) ** 2.5) / whole[j] for j in JOINTS
    }
    hazard = {j: rate[j] * worn(visits_in(data), j) for j in JOINTS}
    assert column(table, "U [s]") == close(whole)
    assert column(table, "rate [1/s]") == close(rate)
    assert column(table, "hazard of each") == close(hazard)
    assert float(by_visit["sum"][-1]) == close(sum(hazard.values()))
    assert "age a = 1 hours" in shown


def test_demands_are_recomputed_from_the_trace(text, data):
    shown = part(text, "hand")
    grasps, releases, together, _ = tables(shown)
    close_on, let_go = (total(visits_in(data), "hand", name) for name in ("grasps", "releases"))
    first, second = -math.log1p(-1e-4) * close_on, -math.log1p(-2e-5) * let_go
    assert column(grasps, "times") == {"hand": close_on}
    assert column(grasps, "hazard") == close({"hand": first})
    assert column(releases, "hazard") == close({"hand": second})
    assert column(together, "hazard") == close({"hand": first + second})
    p = -math.expm1(-(first + second) / 2)
    assert printed(shown, r"1 - exp\(-\S+ / 2\) = (\S+)") == close(p)


def test_a_hidden_group_is_recomputed_from_the_trace(text, data):
    shown = part(text, "brake")
    rate = -math.log1p(-0.02) / 60

    def failed(joint):
        return -math.expm1(-rate * total(data["visits"], joint, "active_s"))

    p = [failed(j) for j in JOINTS]
    # Of three, two fail at least.
    group = p[0] * p[1] * (1 - p[2]) + p[0] * p[2] * (1 - p[1]) + p[1] * p[2] * (1 - p[0])
    group += math.prod(p)
    found = re.search(r"units fail with\n\s+(\S+), (\S+), (\S+), the group with (\S+)\n", shown)
    assert found is not None
    assert [float(each) for each in found.groups()] == close([*p, group])
    like = printed(shown, r"fails alike if each fails with (\S+)")
    assert 3 * like**2 * (1 - like) + like**3 == pytest.approx(group, rel=1e-6)
    share = printed(shown, r"the share of this function is (\S+),")
    value = printed(shown, r"p = 1 - \(1 - \S+\)\^\(\S+ / 2\) = (\S+)")
    assert value == pytest.approx(1 - (1 - like) ** (share / 2), rel=1e-6)


def test_a_repaired_group_is_recomputed_from_what_is_printed(tmp_path):
    path = tmp_path / "cell.yaml"
    path.write_text(
        "components:\n  pump:\n    failure_rate: {value: 1e-3, per: hour}\n    required: 1\n"
        "    repair: {mean_time: 2, per: minute}\n    twin: {joints: [j1, j2]}\n"
    )
    cell = read_hardware(path, shown="cell.yaml")
    shown = render_derivation(derive_function(TRACE, cell, CARRY, active="moving+holding"))
    shown = " ".join(part(shown, "pump").split())
    value = r"([\d.e-]+)"
    repairs = printed(shown, rf"lasts {value} mean times of a repair, the units")
    assert repairs == close(21.5 / 120)
    p, other = (float(got) for got in re.findall(rf"units fail with {value}, {value}", shown)[0])
    back = -math.expm1(-repairs)
    # From all sound (m0), the first failed (m1) or the second (m2), until both have.
    # m1 = 1 + (1 - other) (back m0 + (1 - back) m1), so m1 = one (1 + (1 - other) back m0).
    one = 1 / (1 - (1 - other) * (1 - back))
    two = 1 / (1 - (1 - p) * (1 - back))
    fixed = 1 + p * (1 - other) * one + other * (1 - p) * two
    again = p * (1 - other) ** 2 * back * one + other * (1 - p) ** 2 * back * two
    m0 = fixed / (p + other - p * other - again)
    assert printed(shown, rf"the group then fails in {value} of the missions") == close(1 / m0)
    hazard = printed(shown, rf"H = -ln\(1 - {value}\)")
    like = printed(shown, rf"if each fails with {value}")
    assert like**2 == close(hazard)


@pytest.mark.parametrize("tested", ["mission_start", "{test_interval: 8, per: hour}"])
@pytest.mark.parametrize("beta", ["", "    common_cause: {beta: 0.1}\n"])
def test_a_hidden_group_is_recomputed_from_what_is_printed(tmp_path, tested, beta):
    path = tmp_path / "cell.yaml"
    path.write_text(
        "components:\n  pump:\n    failure_rate: {value: 1e-3, per: hour}\n    required: 1\n"
        f"    detected: {tested}\n{beta}    twin: {{joints: [j1, j2]}}\n"
    )
    cell = read_hardware(path, shown="cell.yaml")
    shown = " ".join(
        part(
            render_derivation(derive_function(TRACE, cell, CARRY, active="moving+holding")), "pump"
        ).split()
    )
    value = r"([\d.e-]+)"
    first, second = (
        float(p) for p in re.findall(rf"the units fail with {value}, {value}", shown)[0]
    )
    like = printed(shown, rf"if each fails with {value}")
    missions = 1.0
    if "interval" in tested:
        missions = printed(shown, rf"a test after {value} missions")
        assert missions == close(8 * 3600 / 21.5)
    if "interval" not in tested and not beta:
        # What is printed is enough: the group, and the like units of the same mission.
        assert "H =" not in shown
        assert like**2 == close(first * second)
        return
    share = 0.1 if beta else 0.0
    own = [-math.expm1(-(missions * h)) for h in (
        -(1 - share) * math.log1p(-p) / missions for p in (first, second)
    )]  # fmt: skip
    apart = printed(shown, rf"the group then fails with {value}")
    assert apart == pytest.approx(math.prod(own), rel=1e-4)
    common = printed(shown, rf"the common cause has the hazard {value} in") if beta else 0.0
    mean = -(math.log1p(-first) + math.log1p(-second)) / 2 / missions
    assert common == pytest.approx(share * mean, rel=1e-4)
    hazard = printed(shown, rf"H = .*? = {value}")
    assert hazard == close(-math.log1p(-apart) / missions + common)
    x = -math.log1p(-like)
    equal = -math.log1p(-(math.expm1(-(1 - share) * x) ** 2)) + share * x
    assert equal == pytest.approx(hazard, rel=1e-4 if beta else 2e-7)


def test_a_renewed_group_is_recomputed_from_the_trace(text, data):
    shown = part(text, "power")
    _, by_visit = tables(shown)
    p = [-math.expm1(-9e-3 / 3600 * each["duration_s"]) for each in visits_in(data)]
    groups = [3 * each**2 * (1 - each) + each**3 for each in p]
    assert list(column(by_visit, "group fails").values()) == close(groups)
    value = printed(shown, r"p of one unit in a visit = (\S+)")
    alike = 3 * value**2 * (1 - value) + value**3
    alive = math.prod(1 - each for each in groups)
    assert (1 - alike) ** 2 == pytest.approx(alive, rel=1e-12)
    assert alike == pytest.approx(sum(groups) / 2, rel=1e-6)


def test_units_that_share_an_element_are_reported_once(text):
    shown = part(text, "supply")
    (table, _) = tables(shown)
    each = 2e-3 / 3600 * 15.5
    assert column(table, "hazard of each") == close({"always active (x2)": each})
    assert float(table["sum"][-1]) == close(2 * each)
    assert shown.startswith("supply: 2 units, one suffices\n")


def test_a_figure_per_visit_counts_visits(text):
    (table, _) = tables(part(text, "fan"))
    assert column(table, "visits") == {"j1": 2.0}
    assert column(table, "hazard") == close({"j1": -2 * math.log1p(-1e-6)})


def test_the_data_hold_every_visit_of_every_unit(derivation, data):
    found = derivation_data(derivation)
    assert (found["schema"], found["version"]) == ("tracerisk-derivation", 1)
    json.dumps(found, allow_nan=False)
    assert [each["number"] for each in found["visits"]] == [2, 4]
    motor = found["components"][0]
    for term in motor["terms"]:
        for unit in term["units"]:
            assert unit["hazards"] == pytest.approx(
                [unit["rate"] * term["share"] * each for each in unit["counted"]]
            )
    for number, unit in enumerate(motor["units"]):
        by_term = [term["units"][number]["hazards"] for term in motor["terms"]]
        assert unit["hazards"] == pytest.approx([sum(each) for each in zip(*by_term, strict=True)])
        assert unit["probabilities"] == pytest.approx(
            [1 - math.exp(-each) for each in unit["hazards"]]
        )
    assert motor["terms"][0]["figure"]["per"] == "hour"
    active = [term["units"][0]["amounts"] for term in motor["terms"] if term["mode"] == "jam"]
    assert active == [[each["exposures"]["j1"]["moving_s"] for each in visits_in(data)]]


def with_entry(hardware, **changes):
    block = compute_blocks(TRACE, hardware, active="moving+holding").blocks[CARRY]
    fan = block.components[-1]
    return replace(block, components=(*block.components[:-1], replace(fan, **changes)))


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"probability": Field(2e-6, "2e-06", True, "1e-06", "FMEA-112")},
            "block: probability := 2e-06, set by a user (FMEA-112); computed 1e-06",
        ),
        (
            {"probability": Field(1.001e-6, "1.001e-06")},
            "block: probability = 1.001e-06, kept; computed 1e-06",
        ),
        (
            {"omitted": True, "reason": "not fitted"},
            "block: omitted by a user (not fitted); computed 1e-06",
        ),
        ({"name": "blower"}, "not in the block"),
        ({}, "block: probability = 1e-06"),
    ],
)
def test_what_stands_in_the_block_is_reported_with_what_is_computed(changes, line, hardware):
    block = with_entry(hardware, **changes)
    derived = derive_function(TRACE, hardware, CARRY, active="moving+holding", block=block)
    assert part(render_derivation(derived), "fan").rstrip("\n").endswith(f"\n  {line}")


def test_what_a_person_added_is_reported(hardware):
    block = with_entry(hardware, name="fuse", added=True)
    derived = derive_function(TRACE, hardware, CARRY, active="moving+holding", block=block)
    assert render_derivation(derived).endswith("\n\nfuse: by hand, nothing is computed\n")


def test_the_setting_is_reported_where_only_moving_counts(hardware):
    text = render_derivation(derive_function(TRACE, hardware, CARRY, active="moving"))
    assert "active = moving: only moving counts where no failure mode says otherwise\n" in text
    _, brake = part(text, "motor"), part(text, "brake")
    assert "counts the time T moving\n" in brake
    assert column(tables(brake)[0], "T [s]") == {"j1": 8.0, "j2": 7.0, "j3": 1.0}


def test_an_idle_unit_and_an_error_factor_are_explained(hardware):
    components = tuple(
        replace(
            component,
            modes=(),
            figures=tuple(
                replace(figure, error_factor=3.0, value_is="mean") for figure in component.figures
            ),
        )
        for component in hardware.components
        if component.name in ("motor", "brake", "fan")
    )
    cell = replace(hardware, components=components)
    text = render_derivation(derive_function(TRACE, cell, REST, active="moving+holding"))
    brake = part(text, "brake")
    assert column(tables(brake)[0], "T [s]")["j3"] == 0.0
    idle = "0 s: idle in these visits, without motion and with at most 2 % of the torque's limit"
    assert idle in " ".join(brake.split())
    assert "idle in these visits" not in part(text, "fan")
    assert "    error factor 3 (p95 / p50); the value is the mean\n" in brake


def test_the_fraction_of_a_mode_is_named_where_there_are_modes(hardware):
    head = "hazard h = rate x {}what counts; hazards add up; p = 1 - exp(-h)\n"
    text = render_derivation(derive_function(TRACE, hardware, CARRY, active="moving+holding"))
    assert head.format("fraction x ") in text
    assert "failure mode lost_torque: fraction 0.6, counts the time T moving or holding\n" in text
    assert "share 0.6" not in text
    cell = replace(hardware, components=hardware.components[-1:])
    text = render_derivation(derive_function(TRACE, cell, CARRY, active="moving+holding"))
    assert head.format("") in text


def test_the_time_before_the_first_command_is_explained(hardware):
    first, *others = TRACE.visits
    late = replace(TRACE, visits=(replace(first, start_s=0.9), *others))
    line = "    start: the first command; visit 1 also lasts for the time before its own\n"
    for trace, function, is_said in (
        (late, REST, True),
        (late, CARRY, False),
        (TRACE, REST, False),
    ):
        derived = derive_function(trace, hardware, function, active="moving+holding")
        assert (line in render_derivation(derived)) == is_said


def test_visits_that_a_mission_has_more_often_weigh_more(hardware):
    # The second visit of each function is the cycle, which a mission has five times.
    trace = replace(TRACE, cycle=Cycle(2, 2, 5))
    text = render_derivation(derive_function(trace, hardware, CARRY, active="moving+holding"))
    assert text.startswith("carry (cell.py): 2 visits seen, 6 in a mission, 15.5 s\n")
    assert "\ncomes: how often a mission has a visit;" in text
    shown = part(text, "hand")
    by_visit = tables(shown)[-1]
    assert column(by_visit, "comes") == {"visit 2": 1.0, "visit 4": 5.0}
    first, second = column(by_visit, "hazard").values()
    assert float(by_visit["sum"][-1]) == close(first + 5 * second)
    p = -math.expm1(-(first + 5 * second) / 6)
    assert printed(shown, r"1 - exp\(-\S+ / 6\) = (\S+)") == close(p)


def test_long_names_are_reported_beside_the_table(hardware):
    names = {f"j{n}": f"left_arm_of_the_cell_joint_{n}" for n in (1, 2, 3)}
    trace = replace(
        TRACE,
        elements=tuple(replace(e, name=names.get(e.name, e.name)) for e in TRACE.elements),
        visits=tuple(
            replace(v, exposures={names.get(k, k): e for k, e in v.exposures.items()})
            for v in TRACE.visits
        ),
    )
    only_motors = replace(hardware, components=hardware.components[:1])
    text = render_derivation(derive_function(trace, only_motors, CARRY, active="moving+holding"))
    assert max(map(len, text.splitlines())) <= 80
    assert "unit 2 left_arm_of_the_cell_joint_2" in " ".join(text.split())
    assert "\n    unit 2  " in text


def test_an_unknown_function_is_an_error_with_the_names():
    with pytest.raises(InputError) as caught:
        function_named(TRACE, "cary")
    assert str(caught.value) == (
        "no function 'cary' in the trace; did you mean 'carry'? allowed: carry, rest"
    )


LOADED = """\
components:
  motor:
    failure_rate: {value: 5.7e-6, per: hour}
    load_law: {reference_load: 0.3, wearing_share: 0.6}
    twin: {joints: "*"}
"""


def test_a_run_and_its_trace_explain_alike(example, quick):
    example.write("cell.yaml", LOADED)
    example.write("controller.py", quick())
    asked = ("--hardware", "cell.yaml", "--explain", "act")
    ran = example.run("run", "controller.py", "--trace", "trace.json", *asked)
    assert ran.code == 0, ran.err
    shown = ran.out[ran.out.index("act (controller.py): 1 visit, ") :]
    annotated = example.run("annotate", "controller.py", "--trace", "trace.json", *asked)
    assert shown.startswith(annotated.out)
    assert "\nact fails in a visit before which no unit has failed:" in shown
    assert "no unit has failed:" not in annotated.out, "no model is built"
    before = example.read("controller.py")
    wrong = example.run("annotate", "controller.py", "--trace", "trace.json", "--explain", "acct")
    assert wrong.code == 2
    assert "tracerisk: no function 'acct' in the trace; did you mean 'act'?" in wrong.err
    assert example.read("controller.py") == before, "the shipped figures are not written"
    (block,) = re.findall(rb"probability = (\S+)", example.read("controller.py"))
    reported = example.run(
        "annotate", "controller.py", "--trace", "trace.json", "--json", *asked
    ).json
    assert reported["derivation"]["function"] == "act"
    again = example.run("annotate", "controller.py", "--trace", "trace.json", "--json").json
    assert "derivation" not in again
    # By hand from the trace: rate x (0.4 T + 0.6 W), W = wear / (v0 0.3^3), the mean over joints.
    data = json.loads(example.read("trace.json"))
    (act,) = data["visits"]
    names = [each["name"] for each in data["elements"] if each["kind"] == "joint"]
    assert len(names) == 7
    joints = [act["exposures"][name] for name in names if name in act["exposures"]]
    hazard = 0.0
    for each in joints:
        speed = each["travel_s"] / each["moving_s"] if each["moving_s"] else 1.0
        wear = each["wear"][2] if each["wear"] else 0.0
        counted = 0.4 * each["active_s"] + 0.6 * wear / (speed * 0.3**3)
        hazard += 5.7e-6 / 3600 * counted
    value = -math.expm1(-hazard / 7)
    assert printed(shown, r"1 - exp\(-\S+ / \(1 x 7\)\) = (\S+)") == close(value)
    assert float(block) == pytest.approx(value, rel=1e-3)
