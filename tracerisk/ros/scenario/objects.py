"""What a scenario says of the twin: the objects of its scene, and where the robot begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from tracerisk.common.geometry.shapes import Shape
from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import Location, ScenarioError, one_of
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.scenario import Scenario
from tracerisk.twin.motion.plausible_units import shown_limits
from tracerisk.twin.physics.scene import Fixture, GraspableObject, Scene, load_scene
from tracerisk.twin.robots.robot import WORLD, WORLD_LINK, Robot
from tracerisk.twin.robots.robot_parts import Attachment, Link

_SHAPES = ("box", "cylinder", "sphere")
_FRICTION = 0.5


def simulated_scene(name: str, scenario: str | None) -> Scene:
    """Return a scene by its name or path, with the objects of the scenario at a path.

    Raises RobotError for an unknown scene, ScenarioError for a malformed scenario.
    """
    scene = load_scene(name)
    return scene if scenario is None else with_objects(scene, read_scenario(Path(scenario)).objects)


def with_objects(scene: Scene, objects: Sequence[YamlMap]) -> Scene:
    """Return the scene with the objects of a scenario in it; lengths are in [m], masses in [kg].

    Raises:
        ScenarioError: an object is malformed, or its name is taken.
    """
    fixtures, graspable = list(scene.fixtures), list(scene.objects)
    taken = {fixture.name for fixture in fixtures} | {
        graspable_object.name for graspable_object in graspable
    }
    for entry in objects:
        if is_known(entry):
            _check_known(entry)
            continue
        read = _object(entry)
        if read.name in taken:
            entry.fail("name", f"the scene has a '{read.name}' already; take another name")
        taken.add(read.name)
        if isinstance(read, Fixture):
            fixtures.append(read)
        else:
            graspable.append(read)
    if not objects:
        return scene
    # Of another name: what is recorded in it cannot be replayed in the scene alone.
    name = f"{scene.name}, with objects of a scenario"
    return replace(scene, name=name, fixtures=tuple(fixtures), objects=tuple(graspable))


def with_start(robot: Robot, start: Sequence[tuple[str, float, Location]]) -> Robot:
    """Return the robot with joints where a scenario says that they are when the run begins.

    Raises:
        ScenarioError: the robot lacks a joint, or it cannot be there.
    """
    known = {joint.name: joint for joint in robot.joints}
    for name, value, place in start:
        if name not in known:
            raise ScenarioError(
                f"robot '{robot.name}' has no joint '{name}'; {one_of(sorted(known), name)}", place
            )
        joint = known[name]
        if joint.type != "continuous" and not joint.lower <= value <= joint.upper:
            raise ScenarioError(
                f"{value:g} for joint '{name}' is outside its limits {shown_limits(joint, value)}",
                place,
            )
    moved = {name: value for name, value, _ in start}
    return replace(robot, initial_state=MappingProxyType({**robot.initial_state, **moved}))


def with_mount(robot: Robot, scenario: Scenario) -> Robot:
    """Return the robot on a link `world`, with its base where a scenario says that it is mounted.

    Raises:
        ScenarioError: the robot's file says already where it is in the world.
    """
    if scenario.mount is None:
        return robot
    if WORLD_LINK in robot.link_names:
        raise ScenarioError(
            f"mount: {robot.file} has a link '{WORLD}', and says where the robot is in it; leave "
            "mount out",
            Location(scenario.file),
        )
    xyz, rpy = scenario.mount
    fixed = Attachment(
        f"{WORLD}_joint", "fixed", WORLD_LINK, robot.base_link, xyz, rpy, (0.0, 0.0, 1.0)
    )
    return replace(
        robot,
        base_link=WORLD_LINK,
        links=(Link(WORLD_LINK, 0.0, (0.0, 0.0, 0.0), None, ()), *robot.links),
        attachments=(fixed, *robot.attachments),
    )


def is_known(entry: YamlMap) -> bool:
    """Return whether an object is one of the planning scene, which makes it a body."""
    return entry.boolean("known", default="attached" in entry)


def _check_known(entry: YamlMap) -> None:
    entry.forbid_unknown({"name", *_SHAPES, "xyz", "rpy", "known", "attached"})
    entry.string("name")
    entry.string("attached", default="")
    shape_of(entry)
    entry.triple("xyz")
    entry.triple("rpy")


def _object(entry: YamlMap) -> Fixture | GraspableObject:
    keys = {"name", *_SHAPES, "xyz", "rpy", "mass", "graspable", "friction", "known", "attached"}
    entry.forbid_unknown(keys)
    if "attached" in entry:
        entry.fail("attached", "what is attached is known to the planning scene; leave known out")
    name = entry.string("name")
    shape = shape_of(entry)
    xyz, rpy = entry.triple("xyz"), entry.triple("rpy")
    if not entry.boolean("graspable", default="mass" in entry):
        for key in ("mass", "friction"):
            if key in entry:
                entry.fail(key, "is only for what can be grasped; set graspable: true")
        return Fixture(name, xyz, rpy, (shape,))
    mass = entry.number("mass", minimum=1e-6, maximum=1e4)
    friction = entry.number("friction", default=_FRICTION, minimum=0.0)
    return GraspableObject(name, xyz, rpy, mass, friction, (shape,))


def shape_of(entry: YamlMap) -> Shape:
    """Return the shape of an object."""
    given = [key for key in _SHAPES if key in entry]
    if len(given) != 1:
        entry.fail(
            given[1] if given else "name", "expected exactly one of box, cylinder and sphere"
        )
    if given == ["box"]:
        lengths = entry.numbers("box", length=3)
        if min(lengths) <= 0.0:
            entry.fail("box", "every length must be above 0")
        return Shape("box", tuple(length / 2 for length in lengths))
    round_shape = entry.map(given[0])
    round_shape.forbid_unknown({"radius", "height"} if given == ["cylinder"] else {"radius"})
    radius = round_shape.number("radius", minimum=1e-4)
    if given == ["sphere"]:
        return Shape("sphere", (radius,))
    return Shape("cylinder", (radius, round_shape.number("height", minimum=1e-4) / 2))
