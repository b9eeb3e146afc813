"""One trace, one arm in SysML v2 and in YAML: the same blocks and the same figures, to the byte."""

import json
from pathlib import Path

import pytest

from tracerisk.common import trace_json
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

STEPS = ("init", "pick_position", "pick", "place_position", "place")
CONTROLLER = "\n\n".join(f"def {name}():\n    pass" for name in STEPS) + "\n"
JOINTS = tuple(f"panda_joint{number}" for number in range(1, 8))
DESCRIPTIONS = {
    "hardware.sysml": Path(__file__).with_name("panda.sysml"),
    "hardware.yaml": Path(read_hardware.__code__.co_filename).parents[1] / "robots" / "panda.yaml",
}


def moving(seconds: float) -> Exposure:
    return Exposure(
        moving_s=seconds,
        holding_s=2.0,
        active_s=seconds + 2.0,
        longest_moving_s=seconds,
        longest_active_s=seconds + 2.0,
        starts=1,
    )


def a_run() -> Trace:
    """Five functions of ten seconds, in which each joint moves for another time."""
    visits = []
    for index, name in enumerate(STEPS):
        exposures = {
            joint: moving(1.0 + number + index / 3)
            for number, joint in enumerate(JOINTS[: 7 - index])
        }
        if name in ("pick", "place"):
            exposures["panda_hand"] = Exposure(
                grasping_s=1.5, active_s=1.5, longest_active_s=1.5, grasps=1
            )
        ref = FunctionRef("controller.py", QualifiedName(name))
        visits.append(Visit(ref, 10.0 * index, 10.0, "succeeded", exposures))
    active: dict[str, Exposure] = {}
    for visit in visits:
        for name, given in visit.exposures.items():
            before = active.get(name, Exposure())
            active[name] = Exposure(
                before.moving_s + given.moving_s,
                before.holding_s + given.holding_s,
                before.grasping_s + given.grasping_s,
                active_s=before.active_s + given.active_s,
            )
    return Trace(
        controller="controller.py",
        robot="panda",
        scene="empty",
        end=RunEnd("ended", "the controller returned", 50.0),
        elements=(*(Element(name, "joint") for name in JOINTS), Element("panda_hand", "gripper")),
        functions=tuple(
            TracedFunction(visit.function, 3 * index + 1, index + 1)
            for index, visit in enumerate(visits)
        ),
        visits=tuple(visits),
        active=active,
    )


@pytest.fixture(scope="module")
def outputs(tmp_path_factory, example_in) -> dict[str, tuple[bytes, ...]]:
    found = {}
    for name, description in DESCRIPTIONS.items():
        example = example_in(tmp_path_factory.mktemp("same"))
        example.write("controller.py", CONTROLLER)
        example.write("trace.json", trace_json.dumps(a_run()))
        example.write(name, description.read_text(encoding="utf-8"))
        annotated = example.run(
            "annotate", "controller.py", "--trace", "trace.json", "--hardware", name
        )
        assert annotated.code == 0, annotated.err
        built = example.run("build", "controller.py", "-o", "model.json")
        assert built.code == 0, built.err
        solved = example.run("solve", "model.json", "--json")
        assert solved.code == 0, solved.err
        found[name] = (
            example.read("controller.py"),
            example.read("model.json"),
            json.dumps(solved.json, sort_keys=True).encode(),
        )
    return found


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("kind", ["blocks", "model", "result"])
def test_both_descriptions_give_the_same_bytes(outputs, kind):
    index = ("blocks", "model", "result").index(kind)
    sysml, yaml = outputs["hardware.sysml"][index], outputs["hardware.yaml"][index]
    assert sysml == yaml


def test_the_run_leans_on_every_component(outputs):
    blocks = outputs["hardware.sysml"][0].decode()
    for name in ("power_system", "control_system", "gripper", "electric_motor"):
        assert f"name = {name}" in blocks
