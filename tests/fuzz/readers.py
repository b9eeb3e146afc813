"""The readers that take what others wrote, each as a function of bytes, with whole examples."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from tracerisk import trace_json
from tracerisk.adder.lock import Lock, loads
from tracerisk.adder.read import read_blocks
from tracerisk.hardware.reader import read_hardware
from tracerisk.instrument.recording import read_recording
from tracerisk.pipeline.console_scripts import console_scripts
from tracerisk.prm.formats import galileo, model_json
from tracerisk.prm.formats.explicit import read_explicit
from tracerisk.prm.formats.open_psa.reader import loads_open_psa
from tracerisk.prm.formats.openpra.reader import loads_openpra
from tracerisk.prm.formats.prism.reader import read_prism

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


READERS: Mapping[str, Reader] = {
    "blocks": Reader(lambda data, _: read_blocks(data, "c.py"), (BLOCK,)),
    "lock": Reader(lambda data, _: loads(data, "tracerisk.lock").dumps(), (Lock().dumps(),)),
    "trace": Reader(
        lambda data, _: trace_json.loads(_text(data), "t.json"),
        (b'{"schema": "tracerisk.trace", "version": 1, "visits": [1e3, -2]}',),
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
        (b'toplevel "A";\n"A" and "B" "C";\n"B" lambda=0.1;\n"C" lambda=1e-3 dorm=0.5;\n',),
    ),
    "open_psa": Reader(
        lambda data, _: loads_open_psa(data, "m.xml"),
        (
            b'<opsa-mef><define-fault-tree name="f"><define-gate name="g"><or>'
            b'<basic-event name="a"/><basic-event name="b"/></or></define-gate>'
            b'<define-basic-event name="a"><float value="0.1"/></define-basic-event>'
            b'<define-basic-event name="b"><float value="0.2"/></define-basic-event>'
            b"</define-fault-tree></opsa-mef>",
        ),
    ),
    "openpra": Reader(
        lambda data, _: loads_openpra(data, "m.json"),
        (b'{"name": "m", "faultTrees": [{"name": "f", "gates": []}]}',),
    ),
    "model": Reader(
        lambda data, _: model_json.loads(_text(data), "m.json"),
        (b'{"schema": "tracerisk-model", "version": 1, "name": "m", "states": []}',),
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
}
