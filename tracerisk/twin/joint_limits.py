"""Read the default scaling factors of a MoveIt package: those of its joint_limits.yaml."""

from __future__ import annotations

from pathlib import Path

from tracerisk.errors import RobotError
from tracerisk.twin.robot import Scaling
from tracerisk.yaml_reader import read_yaml

NAME = "joint_limits.yaml"


def scaling_beside(srdf: Path, default: Scaling, *, shown: str) -> tuple[Scaling, Path] | None:
    """Return the factors of the joint_limits.yaml in the folder of an SRDF, and that file.

    A factor that it leaves out is that of `default`; `None` where there is no such file, or no
    factor in it. `shown` is the SRDF's name for messages.
    Raises RobotError with file and line for a factor outside (0, 1] or a file that is no YAML.
    """
    path = srdf.with_name(NAME)
    if not path.is_file():
        return None
    top = read_yaml(path, RobotError, shown=str(Path(shown).with_name(NAME)), version=(1, 1))
    found = []
    for kind, value in (("velocity", default.velocity), ("acceleration", default.acceleration)):
        key = f"default_{kind}_scaling_factor"
        factor = top.number(key, default=value, minimum=0.0, maximum=1.0)
        if factor == 0.0:
            top.fail(key, "0 is not allowed; give a fraction of the limits above 0, at most 1")
        found.append(factor)
    scaling = Scaling(*found)
    return None if scaling == default else (scaling, path)
