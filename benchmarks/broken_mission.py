"""Judge from the physics of two runs whether a mission is still carried out.

It reads the files that a run keeps by itself, and shares nothing with the verdict of a run.
The run of the unbroken controller says what the mission is: the postures in which arm and gripper
rest, in their order, where things are taken, and how many commands succeed on each part of the
hardware. A run carries the mission out that does all of it; more, from a retry say, is allowed.
"""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SAME_ARM, SAME_FINGER, SAME_PLACE = 0.010, 0.0015, 0.010
"""How far a posture [rad or m], an opening [m or rad] and a thing [m] may be off."""
SLOW_ARM, SLOW_FINGER = 0.02, 0.005
"""Joints rest below these speeds [rad/s or m/s]."""
LEAST_WAY = 0.97
"""Of the way that each joint goes, what must still be gone."""


@dataclass(frozen=True)
class Thing:
    """Where something is at the end [m], where it began, and how far it was from there at most."""

    begin: Array
    end: Array
    most: float


@dataclass(frozen=True)
class Mission:
    """What happened in a run, as physics has it.

    rests: (n_rests, n_joints), positions at rest, each unlike the one before [rad or m];
    tolerance, way: (n_joints,), how far a position may be off and the way gone [rad or m].
    commands: how many succeeded on each set of joints and grippers.
    """

    rests: Array
    tolerance: Array
    way: Array
    things: dict[str, Thing]
    commands: Counter[tuple[str, ...]]


def read_mission(folder: Path) -> Mission | None:
    """Return what happened in the run that was kept in `folder`; None where nothing ever moved."""
    if not (folder / "samples.json").exists() or not (folder / "robot.json").exists():
        return None
    header = json.loads((folder / "samples.json").read_text(encoding="utf-8"))
    robot = json.loads((folder / "robot.json").read_text(encoding="utf-8"))
    joints, n_controls = header["joints"], len(header["controls"])
    n_joints = len(joints)
    width = 1 + n_controls + 3 * n_joints + len(header["pads"])
    flat = np.fromfile(folder / "samples.bin")
    rows = flat[: len(flat) // width * width].reshape(-1, width)
    rows = rows[rows[:, 0] > 0.0]
    if not len(rows):
        return None
    position = rows[:, 1 + n_controls : 1 + n_controls + n_joints]
    velocity = rows[:, 1 + n_controls + n_joints : 1 + n_controls + 2 * n_joints]
    fingers = {name for gripper in robot["grippers"] for name in gripper["joints"]}
    is_finger = np.array([name in fingers for name in joints])
    spread = np.ptp(position, axis=0)
    # Fingers that turn go further than a finger's breadth.
    tolerance = np.where(is_finger & (spread < 0.2), SAME_FINGER, SAME_ARM)
    slow = np.where(is_finger & (spread < 0.2), SLOW_FINGER, SLOW_ARM)
    at_rest: NDArray[np.bool_] = np.all(np.abs(velocity) < slow, axis=1)
    last_of_rest = np.flatnonzero(at_rest & ~np.append(at_rest[1:], False))
    rests: list[Array] = []
    for row in position[last_of_rest]:
        if not rests or (np.abs(row - rests[-1]) > tolerance).any():
            rests.append(row)
    way = np.abs(np.diff(position[::10], axis=0)).sum(axis=0)
    array = np.array(rests) if rests else np.empty((0, n_joints))
    return Mission(array, tolerance, way, _things(folder, header), _commands(folder))


def _things(folder: Path, header: dict[str, list[int]]) -> dict[str, Thing]:
    n_pose = int(header["n_pose"])  # type: ignore[call-overload]
    flat = np.fromfile(folder / "poses.bin")
    poses = flat[: len(flat) // n_pose * n_pose].reshape(-1, n_pose) if n_pose else flat[:0]
    things = {}
    for name, at in zip(header["free_bodies"], header["free_at"], strict=True):
        if not len(poses):
            continue
        track = poses[:, at : at + 3]
        far = np.linalg.norm(track - track[0], axis=1)
        things[str(name)] = Thing(track[0], track[-1], float(far.max()))
    return things


def _commands(folder: Path) -> Counter[tuple[str, ...]]:
    begun: dict[int, tuple[str, ...]] = {}
    done: Counter[tuple[str, ...]] = Counter()
    for line in (folder / "events.jsonl").read_text(encoding="utf-8").splitlines():
        event = json.loads(line)
        if event["event"] == "command":
            begun[event["id"]] = tuple(event["elements"])
        elif event["event"] == "command_ended" and event["end"] == "arrived":
            done[begun[event["id"]]] += 1
    return done


def missing(nominal: Mission, other: Mission | None) -> str:
    """Return in a few words what a run lacks of the mission; empty where it carries it out."""
    if other is None:
        return "nothing ever moved"
    if nominal.rests.shape[1] != other.rests.shape[1]:
        return "it moved another robot"
    place = 0
    for number, posture in enumerate(nominal.rests):
        ahead = np.abs(other.rests[place:] - posture) <= nominal.tolerance
        hits = np.flatnonzero(ahead.all(axis=1))
        if not len(hits):
            return f"posture {number + 1} of {len(nominal.rests)} was not reached"
        place += int(hits[0]) + 1
    short = other.way < LEAST_WAY * nominal.way - 2 * nominal.tolerance
    if short.any():
        return f"joint {int(np.argmax(short)) + 1} went less far"
    for name, thing in nominal.things.items():
        if name not in other.things:
            return f"{name} is gone"
        now = other.things[name]
        if thing.most < SAME_PLACE:
            if np.linalg.norm(now.end - now.begin) > SAME_PLACE:
                return f"{name} was moved"
        elif np.linalg.norm(now.end - thing.end) > SAME_PLACE:
            return f"{name} is not at its place"
        elif now.most < thing.most - SAME_PLACE and np.allclose(now.begin, thing.begin, atol=1e-3):
            return f"{name} was not taken as far"
    fewer = nominal.commands - other.commands
    if fewer:
        elements, number = next(iter(fewer.items()))
        return f"{number} of {nominal.commands[elements]} commands to {elements[0]} were not made"
    return ""
