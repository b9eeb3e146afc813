"""The readers that take what others wrote, each as a function of bytes, with whole examples.

A reader of a model solves it too, as `solve` does. Further examples are the files of `examples/`,
a folder a reader.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from workspace_readers import EXPANDED, WORKSPACE

import tracerisk
from tracerisk.adder.lock.lock import Lock
from tracerisk.adder.lock.reading import loads
from tracerisk.adder.sources.published import read_c_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.cli.shared.model_format import ModelFormat
from tracerisk.cli.solving.chains import ChainFile
from tracerisk.cli.solving.dynamic import DynamicFile
from tracerisk.cli.solving.logic import LogicFile
from tracerisk.common import trace_json
from tracerisk.common.evidence.cells import Cell as EvidenceCell
from tracerisk.common.evidence.cells import Evidence
from tracerisk.common.evidence.file import dump_evidence, loads_evidence
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.sysml.sysml_reader import read_sysml
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.instrument.recording import read_recording
from tracerisk.pipeline.workspace.console_scripts import console_scripts
from tracerisk.prm import build_model, solve
from tracerisk.prm.formats import model_json
from tracerisk.prm.other_models.formats import galileo, linked_json
from tracerisk.prm.other_models.formats.open_psa.open_psa_reader import loads_open_psa
from tracerisk.prm.other_models.formats.openpra import dumps_openpra, loads_openpra
from tracerisk.prm.other_models.formats.prism.prism_reader import read_prism_model
from tracerisk.prm.other_models.linked import linked
from tracerisk.prm.other_models.properties import ask, parse_properties
from tracerisk.ros.graph.parameter_files import read_parameters
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.vendors.description_reader import read_driver
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit
from tracerisk.twin.robots.robot_reader import read_robot
from tracerisk.twin.urdf.srdf import read_srdf


def _text(data: bytes) -> str:
    return data.decode("utf-8", "replace")


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
CTMC = b"""\
ctmc
module pump
  s : [0..2] init 0;
  [] s = 0 -> 0.1 : (s' = 1) + 0.02 : (s' = 2);
  [] s = 1 -> 5 : (s' = 0);
endmodule
label "down" = s > 0;
rewards "cost"
  s = 1 : 2.5;
endrewards
"""
PROPERTIES = b"""\
const double T = 10;
label "late" = s >= 2;
"reached": P=? [ F<=5 "done" ];
P=? [ !"late" U s = 3 ];
S=? [ "done" ];
P<0.5 [ G<=3 s < 3 ];
"""
GALILEO = b"""\
toplevel "T";
"T" or "S" "P" "V";
"S" wsp "A" "B";
"P" pand "C" "D";
"V" 2of3 "E" "F" "G";
"X" fdep "H" "E" "F";
"A" lambda=1e-3; "B" lambda=1e-3 dorm=0.5; "C" lambda=0.1; "D" lambda=0.2 phases=3;
"E" prob=0.1; "F" lambda=1; "G" lambda=2; "H" lambda=0.5;
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
success:
  - {object: crate, at: [0, 0, 0.1], of: camera, tilt: 0.1, rests_on: floor}
  - {called: /camera/enable, with: {data: [1, x, true]}, exactly: 2}
  - steps: [{reached: {panda_joint1: 0.5}}, {passed: {panda_hand: [0.4, 0, 0.5]}}]
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
CHAIN = read_prism_model(_text(PRISM))
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
EXAMPLES = Path(__file__).parent / "examples"
SYSML = Path(__file__).parents[1] / "common" / "hardware" / "sysml"
ROBOTS = Path(tracerisk.__file__).parent / "twin" / "robots" / "shipped"


@dataclass(frozen=True)
class Reader:
    """One reader."""

    read: Callable[[bytes, Path], object]
    """What reads bytes, in a folder that it may write."""
    examples: tuple[bytes, ...]
    """Whole inputs, which it accepts."""
    one_in: int = 1
    """Of so many inputs that are asked for, one is read."""


def _written(path: Path, content: bytes) -> Path:
    """Write a new file: one that is cut and written anew at once waits for the disk."""
    path.unlink(missing_ok=True)
    path.write_bytes(content)
    return path


def _file(name: str, read: Callable[[Path], object]) -> Callable[[bytes, Path], object]:
    def of(data: bytes, folder: Path) -> object:
        return read(_written(folder / name, data))

    return of


def _chain(
    kind: ModelFormat, name: str, beside: tuple[str, bytes] | None = None
) -> Callable[[bytes, Path], object]:
    def of(data: bytes, folder: Path) -> object:
        files = {name: data} if beside is None else {name: data, beside[0]: beside[1]}
        for each, content in files.items():
            _written(folder / each, content)
        first = name if name != "c.lab" else "c.tra"
        return ChainFile((str(folder / first),), kind, None).solve(None, importance=False)

    return of


def _solved_blocks(data: bytes, _folder: Path) -> object:
    return solve(build_model([each.block for each in read_blocks(data, "c.py")], name="m"))


def _with_files(name: str, reader: Reader) -> Reader:
    files = sorted((EXAMPLES / name).glob("*"))
    return replace(reader, examples=(*reader.examples, *(each.read_bytes() for each in files)))


_READERS: dict[str, Reader] = {
    "evidence": Reader(
        lambda data, _: dump_evidence(loads_evidence(_text(data), "tracerisk.evidence")),
        (dump_evidence({"cell.py": EVIDENCE}).encode(),),
    ),
    "blocks": Reader(_solved_blocks, (BLOCK,)),
    "lock": Reader(lambda data, _: loads(data, "tracerisk.lock").dumps(), (Lock().dumps(),)),
    "trace": Reader(
        lambda data, _: trace_json.loads(_text(data), "t.json"),
        (trace_json.dumps(TRACE).encode(),),
    ),
    "recording": Reader(_file("events.jsonl", read_recording), (EVENTS,)),
    "prism": Reader(_chain(ModelFormat.PRISM, "c.sm"), (PRISM, CTMC)),
    "properties": Reader(
        lambda data, _: ask(CHAIN, parse_properties(_text(data), "p.props")), (PROPERTIES,)
    ),
    "transitions": Reader(
        _chain(ModelFormat.EXPLICIT, "c.tra", ("c.lab", b"#DECLARATION\ninit\n#END\n0 init\n")),
        (b"dtmc\n0 1 0.5\n0 0 0.5\n1 1 1\n",),
    ),
    "labels": Reader(
        _chain(ModelFormat.EXPLICIT, "c.lab", ("c.tra", b"dtmc\n0 1 0.5\n0 2 0.5\n1 1 1\n2 2 1\n")),
        (b"#DECLARATION\ninit deadlock done\n#END\n0 init\n1 done\n2 done deadlock\n",),
    ),
    "galileo": Reader(
        lambda data, _: DynamicFile(galileo.loads(_text(data), "t.dft"), 1.0).solve(
            None, importance=True
        ),
        (b'toplevel "A";\n"A" and "B" "C";\n"B" lambda=0.1;\n"C" lambda=1e-3 dorm=0.5;\n', GALILEO),
    ),
    "open_psa": Reader(
        lambda data, _: LogicFile(loads_open_psa(data, "m.xml"), "m.xml", 10.0).solve(
            None, importance=True
        ),
        (OPEN_PSA,),
    ),
    "openpra": Reader(
        lambda data, _: LogicFile(loads_openpra(data, "m.json"), "m.json", 10.0).solve(
            None, importance=True
        ),
        (dumps_openpra(loads_open_psa(OPEN_PSA, "m.xml")).encode(),),
    ),
    "model": Reader(
        lambda data, _: solve(model_json.loads(_text(data), "m.json")),
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
        lambda data, _: linked_json.loads(_text(data), "m.json").solve(),
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
        _file("pyproject.toml", lambda path: ProjectSettings(path.parent).of()), (SETTINGS,)
    ),
}
_READERS |= {name: Reader(*both) for name, both in WORKSPACE.items()}
_READERS["xacro"] = Reader(*EXPANDED, one_in=100)
READERS = {name: _with_files(name, reader) for name, reader in _READERS.items()}
