"""The readers that take what others wrote, each as a function of bytes, with whole examples."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import tracerisk
from tracerisk import config, trace_json
from tracerisk.adder.lock.lock import Lock, loads
from tracerisk.adder.sources.published import read_c_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.evidence import Cell as EvidenceCell
from tracerisk.evidence import Evidence, dump_evidence, loads_evidence
from tracerisk.hardware.sysml.reader import read_sysml
from tracerisk.hardware.yaml.reader import read_hardware
from tracerisk.instrument.recording import read_recording
from tracerisk.pipeline.workspace.console_scripts import console_scripts
from tracerisk.prm import build_model
from tracerisk.prm.formats import galileo, linked_json, model_json
from tracerisk.prm.formats.explicit import read_explicit
from tracerisk.prm.formats.open_psa.reader import loads_open_psa
from tracerisk.prm.formats.openpra import dumps_openpra, loads_openpra
from tracerisk.prm.formats.prism.reader import read_prism
from tracerisk.prm.linked import linked
from tracerisk.ros.graph.parameter_files import read_parameters
from tracerisk.ros.scenario.scenario import read_scenario
from tracerisk.trace import (
    Element,
    Exposure,
    FunctionRef,
    QualifiedName,
    RunEnd,
    Trace,
    TracedFunction,
    Visit,
)
from tracerisk.twin.robots.reader import read_robot
from tracerisk.twin.urdf.srdf import read_srdf
from tracerisk.vendors.description_reader import read_driver

BLOCK = b"""\
def turn(arm):
    # | RiskAnnotation
    # | @Function {
    # |   name = turn
    # |   callSequence := 2  ! computed 1; why
    # |   next = done 1
    # | }
    # | @Component {
    # |   name = motor
    # |   probability = 9.5e-08
    # |   quantity = 7
    # |   redundancy = required 2, spare warm 0.1, common_cause 0.1
    # | }
    pass
"""
PRISM = b"""\
dtmc
const int n = 3;
module chain
  s : [0..3] init 0;
  [] s < n -> 0.1 : (s' = s + 1) + 0.9 : (s' = max(0, pow(s, 2) - 1));
  [] s = n -> (s' = n);
endmodule
label "done" = s = n;
"""
EVENTS = b"""\
{"event":"function","ns":0,"file":"c.py","name":"turn","line":1}
{"event":"note","ns":5,"kind":"input","data":{"answer":"a"}}
"""
PARAMETERS = b"""\
/**:
  ros__parameters: {speed: 0.5, joints: [a, b], deep: {x: on}}
arm: &arm
  home: [0, -1.5, 0x1f, 1e3]
other: *arm
"""
SCENARIO = b"""\
parameters: {/pick/parts: 2}
services:
  - {name: /camera/enable, type: std_srvs/Trigger, after: 0.5, reply: {success: true}}
publish:
  - topic: /camera/part
    type: geometry_msgs/PoseStamped
    messages: [{header: {stamp: now}, pose: {position: [0.4, 0.10, 0.1]}}]
frames:
  - {frame: camera, parent: world, xyz: [0.5, 0, 1.2], rpy: [0, 3.1416, 0]}
objects:
  - {name: crate, box: [0.2, 0.2, 0.1], xyz: [-0.5, 0, 0.05]}
answers: ["", ""]
"""
DRIVER = b"""\
driver: acme
packages: [acme_msgs]
units: {angle: deg}
codes: {succeeded: 0, invalid_goal: 12, aborted: 20, failed: 99}
services:
  acme/move_axes:
    type: MoveAxes
    move: {joints: axis_deg, speed: {field: override_percent, unit: percent}}
    response: {error_code: $code, error_text: $message}
definitions:
  acme_msgs/srv/MoveAxes: |
    float32[6] axis_deg
    float32 override_percent
    ---
    int32 error_code
    string error_text
"""
SRDF = b"""\
<robot name="arm"><group name="arm"><chain base_link="a" tip_link="b"/></group>
<group_state name="home" group="arm"><joint name="j1" value="0.5"/></group_state>
<end_effector name="hand" parent_link="b" group="hand"/><disable_collisions link1="a" link2="b"/>
</robot>
"""
C_BLOCK = b"""\
/***
 * RiskAnnotation
 * @Function {
 *   name = turn
 *   callSequence = 1
 * }
 * @Component {
 *   name = motor
 *   probability = 9.5e-08
 *   quantity = 7
 *   redundancy = false
 * }
 ***/
void turn() {}
"""
SETTINGS = b"""\
[tool.tracerisk]
robot = "panda"
states = ["place"]
min_coverage = 0.9
[[tool.tracerisk.accept]]
code = "unmet-need"
function = "place"
object = "/x"
words = "known"
"""
OPEN_PSA = (
    b'<opsa-mef><define-fault-tree name="f"><define-gate name="g"><or>'
    b'<basic-event name="a"/><basic-event name="b"/></or></define-gate>'
    b'<define-basic-event name="a"><float value="0.1"/></define-basic-event>'
    b'<define-basic-event name="b"><float value="0.2"/></define-basic-event>'
    b"</define-fault-tree></opsa-mef>"
)
MODEL = build_model([each.block for each in read_blocks(BLOCK, "c.py")], name="m")
TURN = FunctionRef("c.py", QualifiedName("turn"))
TRACE = Trace(
    controller="c.py",
    robot="panda",
    scene="empty",
    end=RunEnd("ended", "the controller returned", 12.5),
    elements=(Element("j1", "joint"), Element("hand", "gripper", actuators=("tendon",))),
    functions=(TracedFunction(TURN, 7, 1),),
    visits=(Visit(TURN, 0.1, 12.4, "succeeded", {"j1": Exposure(1.0, 2.0, active_s=3.0)}),),
)
GALILEO = b'toplevel "A";\n"A" and "B" "C";\n"B" lambda=0.1;\n"C" lambda=1e-3 dorm=0.5;\n'
EVIDENCE = Evidence(
    fingerprint="f",
    robot="panda",
    seed=0,
    declared=1,
    success=("over within 9 s",),
    cells=(
        EvidenceCell(
            *("motor", "joint_1", "jam", 0.5, "moving", "turn", True, 0.5, (0.5, 0.0, 0.0)),
            stretch=Exposure(moving_s=0.5, active_s=0.5, starts=1),
            told_after_s=0.25,
            lost=("turn aborted",),
        ),
    ),
)
SYSML = Path(__file__).parents[1] / "hardware" / "sysml"
ROBOTS = Path(tracerisk.__file__).parent / "twin" / "robots" / "shipped"


@dataclass(frozen=True)
class Reader:
    """One reader: what reads bytes (in a folder that it may write), and whole examples."""

    read: Callable[[bytes, Path], object]
    examples: tuple[bytes, ...]


def _text(data: bytes) -> str:
    return data.decode("utf-8", "replace")


def _file(name: str, read: Callable[[Path], object]) -> Callable[[bytes, Path], object]:
    def of(data: bytes, folder: Path) -> object:
        path = folder / name
        path.write_bytes(data)
        return read(path)

    return of


class InternalError(Exception):
    """The command found a fault of its own; the message is the end of what it printed."""


def _solved(name: str, *options: str) -> Callable[[bytes, Path], object]:
    """Return what writes a file of this name and solves it with the command."""

    def of(data: bytes, folder: Path) -> object:
        from tracerisk.cli import main

        path = folder / name
        path.write_bytes(data)
        (folder / "chain.pm").write_bytes(data if name == "chain.pm" else PRISM)
        out, err = io.TextIOWrapper(io.BytesIO()), io.StringIO()
        given = [each.replace("FOLDER", str(folder)) for each in options]
        asked = str(folder / "chain.pm") if name == "asked.props" else str(path)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(["solve", asked, "-q", "--json", *given])
        if code not in (0, 1, 2):
            raise InternalError(err.getvalue()[-2000:])
        return code

    return of


PROPERTIES = b'P=? [ F "deadlock" ]\nP>=0.5 [ G<=10 s=1 ]\nS=? [ s=2 ]\nR=? [ F s=1 ]\n'

READERS: dict[str, Reader] = {
    "evidence": Reader(
        lambda data, _: dump_evidence(loads_evidence(_text(data), "tracerisk.evidence")),
        (dump_evidence({"cell.py": EVIDENCE}).encode(),),
    ),
    "solve_prism": Reader(_solved("chain.pm", "--mission-time", "1"), (PRISM,)),
    "solve_galileo": Reader(_solved("tree.dft", "--mission-time", "1"), (GALILEO,)),
    "solve_open_psa": Reader(_solved("model.xml", "--mission-time", "1"), (OPEN_PSA,)),
    "solve_model": Reader(_solved("model.json"), (model_json.dumps(MODEL).encode(),)),
    "solve_linked": Reader(_solved("model.json"), (linked_json.dumps(linked(MODEL)).encode(),)),
    "solve_blocks": Reader(_solved("cell.py"), (BLOCK,)),
    "solve_properties": Reader(
        _solved("asked.props", "--properties", "FOLDER/asked.props"), (PROPERTIES,)
    ),
    "blocks": Reader(lambda data, _: read_blocks(data, "c.py"), (BLOCK,)),
    "lock": Reader(lambda data, _: loads(data, "tracerisk.lock").dumps(), (Lock().dumps(),)),
    "trace": Reader(
        lambda data, _: trace_json.loads(_text(data), "t.json"),
        (trace_json.dumps(TRACE).encode(),),
    ),
    "recording": Reader(_file("events.jsonl", read_recording), (EVENTS,)),
    "prism": Reader(lambda data, _: read_prism(_text(data), most_states=200), (PRISM,)),
    "transitions": Reader(
        lambda data, _: read_explicit(
            _text(data), "#DECLARATION\ninit\n#END\n0 init\n", transitions_file="c.tra"
        ),
        (b"dtmc\n0 1 0.5\n0 0 0.5\n1 1 1\n",),
    ),
    "galileo": Reader(
        lambda data, _: galileo.loads(_text(data), "t.dft"),
        (GALILEO,),
    ),
    "open_psa": Reader(
        lambda data, _: loads_open_psa(data, "m.xml"),
        (OPEN_PSA,),
    ),
    "openpra": Reader(
        lambda data, _: loads_openpra(data, "m.json"),
        (dumps_openpra(loads_open_psa(OPEN_PSA, "m.xml")).encode(),),
    ),
    "model": Reader(
        lambda data, _: model_json.loads(_text(data), "m.json"),
        (model_json.dumps(MODEL).encode(),),
    ),
    "hardware": Reader(
        _file("arm.yaml", read_hardware),
        (
            b"components:\n  motor: {quantity: 7, probability: {value: 1e-7, per: minute}, "
            b"twin: {joints: '*'}}\n",
        ),
    ),
    "console_scripts": Reader(
        _file("setup.py", lambda path: list(console_scripts(path.parent))),
        (b"entry_points={'console_scripts': ['talker = pkg.talker:main']}\n",),
    ),
    "sysml": Reader(
        _file("arm.sysml", read_sysml),
        tuple(path.read_bytes() for path in sorted(SYSML.glob("*.sysml"))),
    ),
    "c_blocks": Reader(lambda data, _: read_c_blocks(data, "c.cpp"), (C_BLOCK,)),
    "linked": Reader(
        lambda data, _: linked_json.loads(_text(data), "m.json"),
        (linked_json.dumps(linked(MODEL)).encode(),),
    ),
    "parameters": Reader(_file("p.yaml", read_parameters), (PARAMETERS,)),
    "scenario": Reader(_file("s.yaml", read_scenario), (SCENARIO,)),
    "driver": Reader(_file("d.yaml", read_driver), (DRIVER,)),
    "robot": Reader(
        _file("r.yaml", read_robot),
        ((ROBOTS / "so100.yaml").read_bytes(),),
    ),
    "srdf": Reader(lambda data, _: read_srdf(data, "arm.srdf"), (SRDF,)),
    "settings": Reader(
        _file("pyproject.toml", lambda path: config.read_settings(path.parent)), (SETTINGS,)
    ),
}
