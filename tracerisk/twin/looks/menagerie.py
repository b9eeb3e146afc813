"""A model with meshes of a shipped robot, where the user asks for those of mujoco_menagerie.

Nothing is fetched or searched for: the folder is the one that `TRACERISK_MENAGERIE` names, so that
the same run gives the same page on every machine.
"""

from __future__ import annotations

import os
from pathlib import Path

from tracerisk.errors import TraceRiskError
from tracerisk.twin.looks.look import Piece
from tracerisk.twin.looks.meshes import meshes_of_model
from tracerisk.twin.model_files.model_file import read_model_file
from tracerisk.twin.model_files.paths import ModelFolder
from tracerisk.twin.robots.robot import Robot

VARIABLE = "TRACERISK_MENAGERIE"
"""Environment variable that names the folder of mujoco_menagerie; none by default."""

_MODELS = {
    "fr3": "franka_fr3/fr3.xml",
    "gen3": "kinova_gen3/gen3.xml",
    "iiwa14": "kuka_iiwa_14/iiwa14.xml",
    "lite6": "ufactory_lite6/lite6.xml",
    "panda": "franka_emika_panda/panda.xml",
    "sawyer": "rethink_robotics_sawyer/sawyer.xml",
    "so100": "trs_so_arm100/so_arm100.xml",
    "ur10e": "universal_robots_ur10e/ur10e.xml",
    "ur5e": "universal_robots_ur5e/ur5e.xml",
    "vx300s": "trossen_vx300s/vx300s.xml",
    "wx250s": "trossen_wx250s/wx250s.xml",
    "xarm7": "ufactory_xarm7/xarm7.xml",
}


def menagerie_meshes(robot: Robot) -> tuple[dict[str, tuple[Piece, ...]], str]:
    """Return the meshes of a shipped robot by its links, and a sentence on them.

    Both are empty where the user names no folder; without meshes the sentence says why.
    """
    name = _MODELS.get(robot.name, "")
    path = None if robot.is_described or not name else _model(name)
    if path is None:
        return {}, ""
    shown = f"mujoco_menagerie/{name}"
    try:
        model = read_model_file(path, ModelFolder(path.parent, path.parent), shown=shown).robot
    except TraceRiskError as error:
        return {}, f"The meshes of {shown} are not drawn: {error}."
    meshes = meshes_of_model(robot, model)
    if not meshes:
        why = f"its joints are not where those of {robot.name} are"
        return {}, f"The meshes of {shown} are not drawn: {why}."
    return meshes, f"The arm is drawn with the meshes of {shown}; what was simulated has none."


def _model(name: str) -> Path | None:
    """Return the file of a model; the package keeps each in a folder that ends with its digest."""
    named = os.environ.get(VARIABLE)
    if not named:
        return None
    model, file = name.split("/")
    folder = _at(named)
    paths = (folder / name, *sorted(folder.glob(f"models/{model}-*/**/{file}")))
    return next((path for path in paths if path.is_file()), None)


def _at(place: str) -> Path:
    try:
        return Path(place).expanduser()
    except RuntimeError:  # no home is known
        return Path(place)
