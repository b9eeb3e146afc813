"""Turn a robot and a scene into a MuJoCo model of primitive bodies.

The solver's options are those under which a light tube is lifted by friction alone: a pyramidal
cone, the Euler integrator or a step of 10 ms each let it slip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from tracerisk.common.geometry.rotation import quaternion_of
from tracerisk.common.geometry.shapes import Shape
from tracerisk.errors import RobotError
from tracerisk.twin.physics.motion import STEP_S
from tracerisk.twin.physics.no_display import no_display
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.robots.robot import Robot, without_stiffness
from tracerisk.twin.robots.robot_parts import Attachment, Gripper, Joint, Link

with no_display():
    import mujoco

# Collision classes. A pair meets if contype of one has a bit of conaffinity of the other:
# the robot does not meet itself, for primitive hulls of neighbouring links overlap.
# What is free also rests on what only bears things.
FIXTURE, ROBOT, OBJECT, FREE = 1, 2, 4, 8
_PAD_MARGIN = 0.003  # how far the site that feels a pad's contacts reaches around it [m]

_GEOMS = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
}


@dataclass(frozen=True, slots=True)
class SensorLayout:
    """The columns of the quantities in the model's sensor data."""

    position: slice
    """One column a joint [rad or m], in the robot's order."""
    velocity: slice
    """One column a joint [rad/s or m/s], in the robot's order."""
    torque: slice
    """One column a joint [N m or N], in the robot's order."""
    pads: slice
    """One column a pad with its contact force [N], gripper by gripper."""
    touching: slice
    """One column: the number of contacts of the robot."""

    @staticmethod
    def of(robot: Robot) -> SensorLayout:
        """Return the layout that `build_spec` gives the robot's sensors."""
        n = len(robot.joints)
        n_pads = sum(len(gripper.pads) for gripper in robot.grippers)
        return SensorLayout(
            position=slice(0, n),
            velocity=slice(n, 2 * n),
            torque=slice(2 * n, 3 * n),
            pads=slice(3 * n, 3 * n + n_pads),
            touching=slice(3 * n + n_pads, 3 * n + n_pads + 1),
        )


def build_spec(robot: Robot, scene: Scene | None = None) -> Any:
    """Return an MjSpec of the robot in the scene; of the robot alone when there is no scene.

    Actuators are one position servo an arm joint, in the order of `robot.arm_joints`, then one a
    gripper. Sensors are laid out as `SensorLayout.of(robot)` says.
    Raises RobotError when a name stands for two bodies.
    """
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.compiler.degree = False
    spec.compiler.autolimits = False
    # Identified inertias of public robots miss the triangle inequality by a few percent.
    spec.compiler.balanceinertia = True
    option = spec.option
    option.timestep = STEP_S
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = _impratio(robot)
    # Standing objects sleep until something touches them: they cost nothing meanwhile.
    option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    if scene is not None:
        _add_scene(spec, robot, scene)
    _add_robot(spec, robot, scene)
    if scene is not None:
        _part_from_mounting(spec, robot, scene)
    return spec


def _impratio(robot: Robot) -> float:
    """Return how much harder friction is than contact.

    Pads on hinges stand at an angle to one another, which pushes out what they hold. At 10 a ball
    between the jaws of the SO-ARM100 creeps by 1 mm/s, at 100 one between the fingers of the
    CRANE-X7 by 0.3 mm/s; at 1000 neither does.
    """
    fingers = {name for gripper in robot.grippers for name in gripper.joints}
    hinged = any(joint.type != "prismatic" for joint in robot.joints if joint.name in fingers)
    return 1000.0 if hinged else 10.0


def compile_model(robot: Robot, scene: Scene | None = None) -> Any:
    """Return the compiled MjModel; raise RobotError with MuJoCo's reason when it is refused."""
    try:
        return build_spec(robot, scene).compile()
    except ValueError as cause:
        reason = " ".join(str(cause).split())
        if "allocate memory" in reason:
            # The process is short of it, and nothing is wrong with the robot.
            raise MemoryError(reason) from cause
        raise RobotError(
            f"robot '{robot.name}' ({robot.file}) cannot be built: {reason}"
        ) from cause


def place_robot(model: Any, data: Any, robot: Robot) -> None:
    """Put the robot's joints and set-points where the run begins, and compute the rest."""
    initial = robot.initial_state
    for joint in robot.joints:
        data.qpos[model.joint(joint.name).qposadr[0]] = initial[joint.name]
    for joint in robot.arm_joints:
        data.ctrl[model.actuator(joint.name).id] = initial[joint.name]
    for gripper in robot.grippers:
        data.ctrl[model.actuator(gripper.name).id] = gripper.position(initial)
    mujoco.mj_forward(model, data)


def _add_scene(spec: Any, robot: Robot, scene: Scene) -> None:
    taken = set(robot.link_names)
    names = [fixture.name for fixture in scene.fixtures] + [thing.name for thing in scene.objects]
    for name in names:
        if name in taken:
            raise RobotError(
                f"scene '{scene.name}' and robot '{robot.name}' both have a body '{name}'; "
                "rename it in the scene"
            )
    for fixture in scene.fixtures:
        body = spec.worldbody.add_body(
            name=fixture.name, pos=fixture.xyz, quat=quaternion_of(fixture.rpy)
        )
        kind, meets = (FIXTURE, ROBOT | OBJECT) if fixture.meets_robot else (0, FREE)
        for shape in fixture.shapes:
            add_geom(body, shape, contype=kind, conaffinity=meets, friction=0.3)
    for thing in scene.objects:
        body = spec.worldbody.add_body(
            name=thing.name, pos=thing.xyz, quat=quaternion_of(thing.rpy)
        )
        body.add_freejoint(name=thing.name)
        total = sum(shape_volume(shape) for shape in thing.shapes)
        for shape in thing.shapes:
            geom = add_geom(
                body,
                shape,
                contype=OBJECT | FREE,
                conaffinity=FIXTURE | ROBOT | OBJECT,
                friction=thing.friction,
            )
            geom.mass = thing.mass * shape_volume(shape) / total


def _add_robot(spec: Any, robot: Robot, scene: Scene | None) -> None:
    xyz = (0.0, 0.0, 0.0) if scene is None else scene.robot_xyz
    rpy = (0.0, 0.0, 0.0) if scene is None else scene.robot_rpy
    links = {link.name: link for link in robot.links}
    joints = {joint.name: joint for joint in robot.joints}
    root = spec.worldbody.add_body(name=robot.base_link, pos=xyz, quat=quaternion_of(rpy))
    bodies = {robot.base_link: root}
    _fill_link(root, links[robot.base_link])
    waiting = list(robot.attachments)
    while waiting:
        ready = [attachment for attachment in waiting if attachment.parent in bodies]
        for attachment in ready:
            body = bodies[attachment.parent].add_body(
                name=attachment.child, pos=attachment.xyz, quat=quaternion_of(attachment.rpy)
            )
            bodies[attachment.child] = body
            if attachment.name in joints:
                _add_joint(body, attachment, joints[attachment.name])
            _fill_link(body, links[attachment.child])
        waiting = [attachment for attachment in waiting if attachment not in ready]
    for joint in robot.arm_joints:
        servo = joint.servo
        if servo.stiffness <= 0.0:
            raise RobotError(without_stiffness(joint.name))
        _servo(spec, joint.name, mujoco.mjtTrn.mjTRN_JOINT, servo.stiffness, servo.damping)
    for gripper in robot.grippers:
        _add_gripper(spec, gripper)
    _add_sensors(spec, robot, bodies)


def _part_from_mounting(spec: Any, robot: Robot, scene: Scene) -> None:
    """Exclude contacts of links with the fixtures that they stand in when the run begins.

    The shapes of links overstate them: one that reaches into its table would be held fast by it.
    """
    model = spec.compile()
    data = mujoco.MjData(model)
    place_robot(model, data, robot)
    fixtures = {fixture.name for fixture in scene.fixtures}
    links = set(robot.link_names)
    pairs = set()
    for geoms in data.contact.geom[: data.ncon]:
        one, other = (model.body(model.geom_bodyid[geom]).name for geom in geoms)
        pairs |= {(a, b) for a, b in ((one, other), (other, one)) if a in fixtures and b in links}
    for fixture, link in sorted(pairs):
        spec.add_exclude(bodyname1=fixture, bodyname2=link)


def _fill_link(body: Any, link: Link) -> None:
    body.gravcomp = 1.0
    if link.mass > 0.0:
        body.explicitinertial = True
        body.mass = link.mass
        body.ipos = link.centre_of_mass
        if link.inertia is not None:
            body.fullinertia = link.inertia
        else:
            body.inertia = (1e-3 * link.mass,) * 3
    for shape in link.shapes:
        geom = add_geom(body, shape, contype=ROBOT, conaffinity=FIXTURE | OBJECT, friction=0.5)
        geom.mass = 0.0  # the link's own mass is given
        if shape.pad:
            # The pad's softness and friction hold against whatever it touches.
            geom.priority = 1
            geom.condim = 4
            geom.friction = (1.0, 0.005, 0.0001)
            geom.solref = (0.004, 1.0)
            body.add_site(
                name=f"{link.name}/pad",
                type=mujoco.mjtGeom.mjGEOM_BOX,
                pos=shape.xyz,
                quat=quaternion_of(shape.rpy),
                size=_site_size(shape),
            )


def _add_joint(body: Any, attachment: Attachment, joint: Joint) -> None:
    slide = joint.type == "prismatic"
    added = body.add_joint(
        name=joint.name,
        type=mujoco.mjtJoint.mjJNT_SLIDE if slide else mujoco.mjtJoint.mjJNT_HINGE,
        axis=attachment.axis,
        limited=joint.type != "continuous",
        range=(joint.lower, joint.upper),
        armature=joint.servo.armature,
        damping=joint.servo.friction,
    )
    # Gravity compensation goes through the motor, and with it counts against its torque.
    added.actgravcomp = True
    added.actfrclimited = True
    added.actfrcrange = (-joint.torque_limit, joint.torque_limit)


def _servo(spec: Any, name: str, transmission: Any, stiffness: float, damping: float) -> Any:
    actuator = spec.add_actuator(
        name=name,
        target=name,
        trntype=transmission,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
    )
    actuator.gainprm[0] = stiffness
    actuator.biasprm[:3] = (0.0, -stiffness, -damping)
    return actuator


def _add_gripper(spec: Any, gripper: Gripper) -> None:
    """One servo on the mean of the finger positions; fingers of equal travel, as by one gear."""
    share = 1.0 / len(gripper.joints)
    tendon = spec.add_tendon(name=gripper.name)
    for name in gripper.joints:
        tendon.wrap_joint(name, share * gripper.sign(name))
    first = gripper.joints[0]
    for other in gripper.joints[1:]:
        equality = spec.add_equality(
            name=f"{first}={other}",
            type=mujoco.mjtEq.mjEQ_JOINT,
            name1=first,
            name2=other,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            solref=(0.005, 1.0),
            solimp=(0.95, 0.99, 0.001, 0.5, 2.0),
        )
        equality.data[:2] = (0.0, gripper.sign(other))
    tendons = mujoco.mjtTrn.mjTRN_TENDON
    actuator = _servo(spec, gripper.name, tendons, gripper.stiffness, gripper.damping)
    actuator.forcelimited = True
    actuator.forcerange = (-gripper.effort / share, gripper.effort / share)


def _add_sensors(spec: Any, robot: Robot, bodies: dict[str, Any]) -> None:
    for kind, what in (
        (mujoco.mjtSensor.mjSENS_JOINTPOS, "position"),
        (mujoco.mjtSensor.mjSENS_JOINTVEL, "velocity"),
        (mujoco.mjtSensor.mjSENS_JOINTACTFRC, "torque"),
    ):
        for joint in robot.joints:
            spec.add_sensor(
                name=f"{joint.name}/{what}",
                type=kind,
                objtype=mujoco.mjtObj.mjOBJ_JOINT,
                objname=joint.name,
            )
    for gripper in robot.grippers:
        for pad in gripper.pads:
            if not any(site.name == f"{pad}/pad" for site in bodies[pad].sites):
                raise RobotError(
                    f"gripper '{gripper.name}' of robot '{robot.name}': link '{pad}' has no shape "
                    "marked 'pad: true'; mark the one that touches what is held"
                )
            spec.add_sensor(
                name=f"{pad}/touch",
                type=mujoco.mjtSensor.mjSENS_TOUCH,
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=f"{pad}/pad",
            )
    # Last, for what is sampled ends before it.
    touching = spec.add_sensor(
        name="touching",
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_XBODY,
        objname=robot.base_link,
    )
    touching.intprm[:] = (1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND), 0, 1)


def add_geom(body: Any, shape: Shape, *, contype: int, conaffinity: int, friction: float) -> Any:
    """Add a shape to a body of a spec and return its geom."""
    size = (*shape.size, 0.0, 0.0)[:3]
    return body.add_geom(
        type=_GEOMS[shape.kind],
        size=size,
        pos=shape.xyz,
        quat=quaternion_of(shape.rpy),
        contype=contype if shape.contact else 0,
        conaffinity=conaffinity if shape.contact else 0,
        friction=(friction, 0.005, 0.0001),
    )


def _site_size(shape: Shape) -> tuple[float, float, float]:
    if shape.kind == "box":
        x, y, z = shape.size
    elif shape.kind == "sphere":
        x = y = z = shape.size[0]
    else:
        x = y = shape.size[0]
        z = shape.size[1] + (shape.size[0] if shape.kind == "capsule" else 0.0)
    return x + _PAD_MARGIN, y + _PAD_MARGIN, z + _PAD_MARGIN


def shape_volume(shape: Shape) -> float:
    """Return the volume of a shape [m^3]."""
    if shape.kind == "box":
        x, y, z = shape.size
        return 8 * x * y * z
    ball = 4 / 3 * math.pi * shape.size[0] ** 3
    if shape.kind == "sphere":
        return ball
    straight = 2 * math.pi * shape.size[0] ** 2 * shape.size[1]
    return straight + (ball if shape.kind == "capsule" else 0.0)
