"""What our subset accepts and writes is SysML v2, by a parser of all of it.

That parser takes seconds for a few lines, and far more for the first ones: inputs are small, and
the large ones are for the slow run.
"""

import re
from pathlib import Path

import pytest

from tracerisk.common.hardware.model import (
    Basis,
    Component,
    FailureFigure,
    FailureMode,
    Hardware,
    LoadLaw,
    TwinBinding,
)
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.common.hardware.sysml.sysml_reader import read_sysml
from tracerisk.common.hardware.sysml.writer import write_sysml

longeron = pytest.importorskip("longeron", reason="longeron, a full parser, is not installed")

HERE = Path(__file__).parent
ROOT = HERE.parents[3]
LIBRARY = Path(read_sysml.__code__.co_filename).parent / "library" / "TraceriskHardware.sysml"


def problems(text: str) -> list[str]:
    """Parse a text with the official libraries; return what they say of it."""
    model = longeron.loads(text)
    longeron.add_standard_library(model)
    return [str(each) for each in longeron.validate(model)]


SMALL = """\
package Hardware {
    private import ScalarValues::*;
    private import SI::*;
    private import TraceriskHardware::*;

    part robot {
        part m {
            @FailureData { rate = 1e-06 [h^-1]; }
        }
    }
}
"""


def test_a_small_description_is_written_as_the_parser_takes_it():
    small = Hardware("x", (Component("m", (FailureFigure("failure_rate", 1e-6, Basis.HOUR),)),))
    assert write_sysml(small) == SMALL


@pytest.mark.slow
def test_a_small_description_is_parsed():
    longeron.loads(SMALL)


def everything() -> Hardware:
    moving = Component(
        "arm.h",
        (
            FailureFigure("failure_rate", 1e-6, Basis.HOUR, error_factor=3.0, value_is="mean"),
            FailureFigure("failure_rate", 1e-9, Basis.MINUTE, standby=True, source='a "b"\n'),
            FailureFigure("weibull", 30000.0, Basis.HOUR, shape=2.0),
            FailureFigure("probability", 1e-7, Basis.DEMAND, demand="start"),
        ),
        quantity=None,
        twin=TwinBinding(joints="*"),
        load_law=LoadLaw(0.3, 0.6, 10 / 3, 0.2, "a data sheet"),
        modes=(
            FailureMode("jam", 0.4, ("moving", "start")),
            FailureMode("lost torque", 0.5, ("moving",)),
        ),
        age_s=3600.0,
    )
    group = Redundancy(True, 2, 0.1, 0.5, 0.01, "each_visit")
    psu = Component(
        "power-supply", (FailureFigure("probability", 0.1, Basis.HOUR),), 3, group, True
    )
    sensors = Component(
        "arm.camera.part",
        (FailureFigure("probability", 0.1, Basis.VISIT),),
        quantity=None,
        twin=TwinBinding(sensors="camera", optional=True),
    )
    return Hardware("x", (moving, sensors, psu), "panda", "here")


@pytest.mark.slow
def test_the_library_and_all_that_uses_it_mean_something_in_sysml():
    """One text, so that the parser warms up once: every name in it resolves."""
    documented = re.findall(
        r"```sysml\n(.*?)```", (ROOT / "docs" / "sysml.md").read_text(encoding="utf-8"), re.DOTALL
    )
    texts = [
        LIBRARY.read_text(encoding="utf-8"),
        (HERE / "panda.sysml").read_text(encoding="utf-8"),
        (HERE / "everything.sysml").read_text(encoding="utf-8"),
        write_sysml(everything()),
        *documented,
    ]
    found = problems("\n".join(texts))
    # The library of the risk metadata is none of those that the parser brings along.
    known = (
        "RiskMetadata",
        "RiskLevelEnum",
        "RiskLevel",
        "Risk",
        "totalRisk",
        "technicalRisk",
        "high",
    )
    assert [each for each in found if not any(f"'{name}'" in each for name in known)] == []
