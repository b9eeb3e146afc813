"""Measure how long the reading of 1,000 parts takes, in SysML v2, in YAML, and by longeron.

    python benchmarks/hardware_reading.py [--parts N] [--times N] [--peer-parts N]

SysML v2 may take at most 0.5 s of processor time for 1,000 parts, the building of the parser's
tables included. Each reading is in a process of its own, and Python's start stands beside it.
"""

from __future__ import annotations

import argparse
import importlib.util
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import quick

MOST_S = 0.5

HEAD = """\
package Plant {
    private import SI::*;
    private import TraceriskHardware::*;

    part plant {
"""
PART = """\
        part motor_{n:04d} [2] {{
            @FailureData {{ rate = {rate!r} [h^-1]; errorFactor = 3; source = "data sheet {n}"; }}
            @TwinBinding {{ joints = ("joint_{n}", "joint_{n}_b"); }}
        }}
"""
READ = """\
import time
from pathlib import Path
from tracerisk.common.hardware.{module} import {function}
began = time.process_time()
components = len({function}(Path({path!r})).components)
print(components, time.process_time() - began)
"""
PEER = """\
import time
from pathlib import Path
import longeron
text = Path({path!r}).read_text(encoding="utf-8")
began = time.process_time()
longeron.loads(text)
print({parts}, time.process_time() - began)
"""


def sysml(parts: int) -> str:
    """Return a description of parts that differ in every figure and name."""
    each = (PART.format(n=n, rate=1e-6 * (1 + n / 7)) for n in range(parts))
    return HEAD + "".join(each) + "    }\n}\n"


def child_seconds(command: list[str]) -> float:
    """Return the processor time of a command [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def reading_seconds(program: str, parts: int) -> float:
    """Return what a program printed as its processor time [s], having read all parts."""
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    text, seconds = done.stdout.split()
    if int(text) != parts:
        raise SystemExit(f"{text} parts were read, not {parts}")
    return float(seconds)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--parts", type=int, default=1000)
    parser.add_argument("--times", type=int, default=5)
    parser.add_argument("--peer-parts", type=int, default=20)
    options = quick.parsed(parser, parts=lambda: 20, times=lambda: 1, peer_parts=lambda: 1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plant.sysml"
        path.write_text(sysml(options.parts), encoding="utf-8")
        yaml = path.with_suffix(".yaml")
        write_yaml(path, yaml)
        ours = READ.format(module="sysml.sysml_reader", function="read_sysml", path=str(path))
        theirs = READ.format(
            module="yaml.hardware_reader", function="read_hardware", path=str(yaml)
        )
        readings: dict[str, list[float]] = {"start": [], "sysml": [], "yaml": []}
        for _ in range(options.times):
            readings["start"].append(child_seconds([sys.executable, "-c", "pass"]))
            readings["sysml"].append(reading_seconds(ours, options.parts))
            readings["yaml"].append(reading_seconds(theirs, options.parts))
        seconds = {name: statistics.median(values) for name, values in readings.items()}
        print(f"python -c pass                  {seconds['start']:.3f} s")
        print(
            f"{options.parts} parts in SysML v2 {seconds['sysml']:16.3f} s"
            f"  (least {min(readings['sysml']):.3f} s)"
        )
        print(f"{options.parts} parts in YAML {seconds['yaml']:20.3f} s")
        if importlib.util.find_spec("longeron") is not None:
            path.write_text(sysml(options.peer_parts), encoding="utf-8")
            program = PEER.format(path=str(path), parts=options.peer_parts)
            peer = reading_seconds(program, options.peer_parts)
            print(f"{options.peer_parts} parts by longeron {peer:18.3f} s  (syntax only)")
    return 0 if options.quick or seconds["sysml"] <= MOST_S * max(options.parts, 1000) / 1000 else 1


def write_yaml(path: Path, yaml: Path) -> None:
    """Write the description in YAML too."""
    from tracerisk.common.hardware.sysml.sysml_reader import read_sysml
    from tracerisk.common.hardware.yaml.writer import write_hardware

    yaml.write_text(write_hardware(read_sysml(path)), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
