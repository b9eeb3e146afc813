"""PyKDL, its parser of URDFs, trac_ik and posemath: against the real library, and MuJoCo's twin.

The figures of rotations, motions and dynamics are those of PyKDL 1.5.1 for the same calls.
"""

import copy
import math
import pickle

import numpy as np
import pytest

from tests.slow import slow_but
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.urdf.text import urdf_text

ARMS = [("ur5e", "base_link", "tool0"), ("panda", "panda_link0", "panda_hand")]


@pytest.fixture(scope="module", autouse=True)
def stand_ins():
    with StandInFinder():
        yield


@pytest.fixture
def kdl():
    import PyKDL

    return PyKDL


def array(kdl, values):
    made = kdl.JntArray(len(values))
    for place, value in enumerate(values):
        made[place] = value
    return made


def near(figures):
    return pytest.approx(figures, abs=2e-6)


def cells(matrix):
    return [[matrix[i, j] for j in range(matrix.columns())] for i in range(matrix.rows())]


def three_joints(kdl):
    """Return a chain of three joints with their masses."""
    chain = kdl.Chain()
    ways = [((0, 0, 1), (0, 0, 0.3)), ((0, 1, 0), (0.4, 0, 0)), ((1, 1, 0), (0.2, 0.1, 0))]
    for i, (axis, tip) in enumerate(ways):
        origin = kdl.Vector(0, 0, 0.1 * i)
        joint = kdl.Joint(f"j{i}", origin, kdl.Vector(*axis), kdl.Joint.RotAxis)
        frame = kdl.Frame(kdl.Rotation.RPY(0.1 * i, 0.2, 0.3), kdl.Vector(*tip))
        moments = kdl.RotationalInertia(0.1, 0.2, 0.3, 0.01, 0, 0.02)
        body = kdl.RigidBodyInertia(i + 1.0, kdl.Vector(0.1, 0, 0.02), moments)
        chain.addSegment(kdl.Segment(f"s{i}", joint, frame, body))
    return chain


def arm_of(name, base, tip):
    from kdl_parser_py.urdf import treeFromString

    robot = load_robot(name)
    is_whole, tree = treeFromString(urdf_text(robot))
    assert is_whole
    chain = tree.getChain(base, tip)
    segments = [chain.getSegment(i) for i in range(chain.getNrOfSegments())]
    joints = [each.getJoint() for each in segments if each.getJoint().getTypeName() != "Fixed"]
    return robot, chain, [robot.joint(joint.getName()) for joint in joints]


def test_rotations_follow_the_conventions_of_the_library(kdl):
    turn = kdl.Rotation.RPY(0.3, -0.4, 2.0)
    assert turn.GetQuaternion() == near((0.24443, 0.017105, 0.831478, 0.498604))
    zyx = kdl.Rotation.EulerZYX(0.3, -0.4, 2.0)
    assert zyx.GetQuaternion() == near((0.831478, 0.017105, 0.24443, 0.498604))
    zyz = kdl.Rotation.EulerZYZ(0.3, -0.4, 2.0)
    assert zyz.GetQuaternion() == near((-0.149256, -0.131118, 0.894569, 0.400345))
    assert turn.GetRPY() == near((0.3, -0.4, 2.0))
    assert turn.GetEulerZYX() == near((2.0, -0.4, 0.3))
    assert turn.GetEulerZYZ() == near((-0.470304, 0.495096, 2.531558))
    assert list(turn.GetRot()) == near((0.591488, 0.041392, 2.012071))
    assert kdl.Rotation.Quaternion(*turn.GetQuaternion()) == turn
    assert kdl.Rotation.Rot(turn.GetRot(), turn.GetRotAngle()[0]) == turn
    assert turn * turn.Inverse() == kdl.Rotation.Identity()
    # Roll and yaw about one axis, half a turn, and none.
    assert kdl.Rotation.RPY(0.3, math.pi / 2, 0.2).GetRPY() == near((0.0, math.pi / 2, -0.1))
    assert list(kdl.Rotation.RotX(math.pi).GetRot()) == near((math.pi, 0.0, 0.0))
    assert kdl.Rotation().GetRotAngle() == (0.0, kdl.Vector(0, 0, 1))


def test_frames_carry_twists_and_wrenches(kdl):
    frame = kdl.Frame(kdl.Rotation.RPY(0.3, -0.4, 2.0), kdl.Vector(1, 2, 3))
    first, second = kdl.Vector(1, 2, 3), kdl.Vector(0.1, 0.2, 0.3)
    twist, wrench = kdl.Twist(first, second), kdl.Wrench(first, second)
    carried = (0.204266, -1.396437, 3.64315, -0.075429, -0.081279, 0.357357)
    assert list(frame * twist) == near(carried)
    loaded = (-0.754286, -0.812794, 3.573572, 9.510098, -5.917711, 1.053136)
    assert list(frame * wrench) == near(loaded)
    assert frame.Inverse(frame * twist) == twist
    assert list(twist.RefPoint(kdl.Vector(1, 0, 0))) == near((1.0, 2.3, 2.8, 0.1, 0.2, 0.3))
    way = kdl.diff(kdl.Frame(), frame)
    assert list(way) == near((1.0, 2.0, 3.0, 0.591488, 0.041392, 2.012071))
    assert kdl.addDelta(kdl.Frame(), way) == frame
    assert kdl.dot(first, second) == pytest.approx(1.4)
    assert first * second == kdl.Vector.Zero()


def test_parts_of_a_frame_are_written_in_place_and_copies_stand_alone(kdl):
    frame = kdl.Frame(kdl.Vector(1, 2, 3))
    kept, place = copy.deepcopy(frame), frame.p
    frame.p.x(5)
    frame.p[1] = 6
    frame.M.DoRotZ(math.pi / 2)
    assert list(place) == [5.0, 6.0, 3.0]
    assert frame.M.UnitX() == kdl.Vector(0, 1, 0)
    assert list(kept.p) == [1.0, 2.0, 3.0]
    assert pickle.loads(pickle.dumps(frame)) == frame
    assert repr(kdl.JntArray(2)) == "[           0           0]"
    assert str(kdl.Vector(1, 2, 3)) == "[           1,           2,           3]"


def test_what_no_form_of_a_call_fits_is_an_error(kdl):
    for wrong in (lambda: kdl.Vector("a"), lambda: kdl.Frame(3), lambda: kdl.Rotation(1, 2)):
        with pytest.raises(TypeError, match="incompatible"):
            wrong()
    for beyond in (lambda: kdl.Vector()[3], lambda: kdl.JntArray(2)[-1], lambda: kdl.Frame()[3, 0]):
        with pytest.raises(IndexError):
            beyond()


def test_joints_and_bodies_are_made_by_names_too(kdl):
    joint = kdl.Joint("lift", type=kdl.Joint.TransX, scale=2.0, offset=0.1)
    segment = kdl.Segment(joint=joint, f_tip=kdl.Frame(kdl.Vector(0, 0, 1)))
    assert segment.pose(0.5).p == kdl.Vector(1.0, 0.0, 1.0)
    assert segment.twist(0.5, 0.25).vel == kdl.Vector(0.5, 0.0, 0.0)
    moments = kdl.RotationalInertia(Ixx=1.0, Izz=2.0)
    assert [moments[0], moments[4], moments[8]] == [1.0, 0.0, 2.0]
    assert kdl.RigidBodyInertia(m=2.0, oc=kdl.Vector(x=1, y=2, z=3)).getCOG() == kdl.Vector(1, 2, 3)


def test_dynamics_are_those_of_the_library(kdl):
    chain, q = three_joints(kdl), array(kdl, (0.3, -0.5, 0.7))
    parts = kdl.ChainDynParam(chain, kdl.Vector(0, 0, -9.81))
    weight, motion, masses = kdl.JntArray(3), kdl.JntArray(3), kdl.JntSpaceInertiaMatrix(3)
    codes = [
        parts.JntToGravity(q, weight),
        parts.JntToCoriolis(q, array(kdl, (0.1, 0.2, -0.3)), motion),
        parts.JntToMass(q, masses),
    ]
    assert codes == [0, 0, 0]
    assert list(weight) == near((0.0, -25.305973, 0.698678))
    assert list(motion) == near((0.041568, 0.002658, 0.015103))
    assert np.array(cells(masses)) == near(
        np.array(
            [
                [2.514076, 0.012366, 0.414078],
                [0.012366, 1.698467, 0.078194],
                [0.414078, 0.078194, 0.300858],
            ]
        )
    )


def test_a_chain_goes_up_a_tree_and_down_again(kdl):
    tree = kdl.Tree("base")
    assert tree.addChain(three_joints(kdl), "base")
    camera = kdl.Joint("pan", kdl.Joint.RotX)
    assert tree.addSegment(kdl.Segment("camera", camera, kdl.Frame(kdl.Vector(0, 0.5, 0))), "s0")
    assert not tree.addSegment(kdl.Segment("lost"), "nowhere")
    way, frame = tree.getChain("s2", "camera"), kdl.Frame()
    kdl.ChainFkSolverPos_recursive(way).JntToCart(array(kdl, (0.1, 0.2, 0.3)), frame)
    names = [way.getSegment(i).getName() for i in range(way.getNrOfSegments())]
    assert (way.getNrOfJoints(), names) == (3, ["s1", "s0", "camera"])
    assert list(frame.p) == near((-0.290299, 0.557091, -0.197602))
    assert (tree.getNrOfJoints(), tree.getNrOfSegments()) == (4, 4)
    older = kdl.Joint("plate", getattr(kdl.Joint, "None"))
    assert older.getTypeName() == "Fixed"


@pytest.mark.parametrize(("name", "base", "tip"), ARMS)
def test_an_arm_is_where_its_twin_is_and_moves_alike(kdl, name, base, tip):
    robot, chain, joints = arm_of(name, base, tip)
    twin = Kinematics(robot)
    solver, jacobians = kdl.ChainFkSolverPos_recursive(chain), kdl.ChainJntToJacSolver(chain)
    generator = np.random.default_rng(3)
    for _ in range(5):
        values = generator.uniform([j.lower for j in joints], [j.upper for j in joints])
        frame, jacobian = kdl.Frame(), kdl.Jacobian(len(joints))
        assert solver.JntToCart(array(kdl, values), frame) == 0
        assert jacobians.JntToJac(array(kdl, values), jacobian) == 0
        at = {joint.name: value for joint, value in zip(joints, values, strict=True)}
        pose = twin.forward(at, tip)
        there = kdl.Frame(kdl.Rotation.Quaternion(*pose.orientation), kdl.Vector(*pose.position))
        assert kdl.Equal(frame, there, 1e-5)
        for place, joint in enumerate(joints):
            moved = twin.forward({**at, joint.name: at[joint.name] + 1e-5}, tip)
            near_by = kdl.Frame(
                kdl.Rotation.Quaternion(*moved.orientation), kdl.Vector(*moved.position)
            )
            rate = kdl.diff(there, near_by, 1e-5)
            assert list(jacobian.getColumn(place)) == pytest.approx(list(rate), abs=1e-4)
        speeds = array(kdl, generator.uniform(-1, 1, len(joints)))
        moving, twist = kdl.FrameVel(), kdl.Twist()
        velocities = kdl.ChainFkSolverVel_recursive(chain)
        assert velocities.JntToCart(kdl.JntArrayVel(array(kdl, values), speeds), moving) == 0
        kdl.MultiplyJacobian(jacobian, speeds, twist)
        assert moving.GetTwist() == twist
        assert moving.GetFrame() == frame


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(("name", "base", "tip"), ARMS)
def test_positions_are_found_within_limits_or_a_code_reports_it(kdl, name, base, tip):
    _, chain, joints = arm_of(name, base, tip)
    lower, upper = ([getattr(joint, end) for joint in joints] for end in ("lower", "upper"))
    forward = kdl.ChainFkSolverPos_recursive(chain)
    speeds = kdl.ChainIkSolverVel_pinv(chain)
    limited = kdl.ChainIkSolverPos_NR_JL(
        chain, array(kdl, lower), array(kdl, upper), forward, speeds
    )
    solvers = [
        kdl.ChainIkSolverPos_NR(chain, forward, speeds),
        limited,
        kdl.ChainIkSolverPos_LMA(chain, np.ones(6)),
    ]
    centre, generator = (np.array(lower) + upper) / 2 + 0.3, np.random.default_rng(1)
    for _ in range(4):
        goal, found, back = kdl.Frame(), kdl.JntArray(len(joints)), kdl.Frame()
        forward.JntToCart(array(kdl, centre + generator.uniform(-0.5, 0.5, len(joints))), goal)
        for solver in solvers:
            assert solver.CartToJnt(array(kdl, centre), goal, found) == 0
            forward.JntToCart(found, back)
            assert kdl.Equal(back, goal, 1e-4)
        limited.CartToJnt(array(kdl, centre), goal, found)
        assert (np.array([*found]) >= lower).all()
        assert (np.array([*found]) <= upper).all()
    goal.p = kdl.Vector(9, 0, 0)
    for solver in solvers:
        assert solver.CartToJnt(array(kdl, centre), goal, found) < 0
        assert solver.getError() < 0
    assert limited.strError(limited.getError()) == "The maximum number of iterations is exceeded"
    assert limited.CartToJnt(kdl.JntArray(2), goal, found) == -4


def test_velocities_where_an_arm_is_singular_are_reported(kdl):
    _, chain, joints = arm_of(*ARMS[0])
    solver, found = kdl.ChainIkSolverVel_pinv(chain), kdl.JntArray(len(joints))
    twist = kdl.Twist(kdl.Vector(0.1, 0, 0), kdl.Vector())
    assert solver.CartToJnt(kdl.JntArray(len(joints)), twist, found) == 100
    assert np.isfinite([*found]).all()


@pytest.mark.parametrize(("name", "base", "tip"), slow_but(ARMS[1:], ARMS))
def test_trac_ik_finds_positions_within_limits_or_none(kdl, name, base, tip):
    from trac_ik_python.trac_ik import IK

    robot, chain, joints = arm_of(name, base, tip)
    solver = IK(base, tip, urdf_string=urdf_text(robot))
    assert solver.joint_names == tuple(joint.name for joint in joints)
    assert solver.number_of_joints == len(joints)
    assert solver.link_names[-1] == tip
    lower, upper = solver.get_joint_limits()
    assert lower == near([joint.lower for joint in joints])
    forward, generator = kdl.ChainFkSolverPos_recursive(chain), np.random.default_rng(2)
    seed = [(low + high) / 2 for low, high in zip(lower, upper, strict=True)]
    for _ in range(2):
        goal, back = kdl.Frame(), kdl.Frame()
        forward.JntToCart(array(kdl, generator.uniform(lower, upper)), goal)
        found = solver.get_ik(seed, *goal.p, *goal.M.GetQuaternion())
        assert found == solver.get_ik(seed, *goal.p, *goal.M.GetQuaternion())
        forward.JntToCart(array(kdl, found), back)
        assert kdl.Equal(back.p, goal.p, 2e-5)
        assert (back.M.Inverse() * goal.M).GetRotAngle()[0] < 2e-3
        assert all(a <= b <= c for a, b, c in zip(lower, found, upper, strict=True))
    # Where the orientation is free, any will do; the place is still reached.
    free = solver.get_ik(seed, *goal.p, 0.0, 0.0, 0.0, 1.0, 1e-4, 1e-4, 1e-4, 7.0, 7.0, 7.0)
    forward.JntToCart(array(kdl, free), back)
    assert kdl.Equal(back.p, goal.p, 2e-4)
    assert solver.get_ik(seed, 9.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0) is None
    still = [value - 1e-3 for value in seed], [value + 1e-3 for value in seed]
    solver.set_joint_limits(*still)
    assert solver.get_ik(seed, *goal.p, *goal.M.GetQuaternion()) is None
    with pytest.raises(ValueError, match="qinit has length 2"):
        solver.get_ik([0.0, 0.0], 0, 0, 0, 0, 0, 0, 1)
    with pytest.raises(ValueError, match="no link 'hand'"):
        IK(base, "hand", urdf_string=urdf_text(robot))


def test_a_urdf_that_is_none_is_reported_with_its_line():
    from kdl_parser_py.urdf import treeFromString

    with pytest.raises(ValueError, match=r"robot_description:1.*<links>"):
        treeFromString("<links/>")
    with pytest.raises(ValueError, match="2 links that hang on nothing"):
        treeFromString("<robot name='r'><link name='a'/><link name='b'/></robot>")


def test_posemath_leads_to_messages_matrices_and_tf_and_back(kdl):
    from tf_conversions import posemath, transformations

    frame = kdl.Frame(kdl.Rotation.RPY(0.1, 0.2, 0.3), kdl.Vector(1, 2, 3))
    assert posemath.fromMsg(posemath.toMsg(frame)) == frame
    assert posemath.fromMatrix(posemath.toMatrix(frame)) == frame
    place, turn = posemath.toTf(frame)
    assert posemath.fromTf((place, turn)) == frame
    assert turn == near(transformations.quaternion_from_euler(0.1, 0.2, 0.3))
    seen = posemath.fromCameraParams(None, [[0.1], [0.2], [0.3]], [1.0, 2.0, 3.0])
    assert list(seen.M.GetRot()) == near((0.1, 0.2, 0.3))


def test_vectors_and_frames_are_transformed_by_tf2(run_node):
    def main():
        import PyKDL
        import tf2_geometry_msgs
        import tf2_kdl
        import tf2_ros
        from geometry_msgs.msg import PointStamped, TransformStamped

        transform = TransformStamped()
        transform.header.frame_id = "base"
        transform.transform.translation.x = 1.0
        transform.transform.rotation.z = transform.transform.rotation.w = math.sqrt(0.5)
        moved = tf2_kdl.do_transform_vector(PyKDL.Vector(1, 0, 0), transform)
        assert moved == PyKDL.Vector(1, 1, 0)
        assert moved.header.frame_id == "base"
        point = tf2_ros.convert(moved, PointStamped)
        assert (point.point.x, point.header.frame_id) == (near(1.0), "base")
        assert tf2_ros.convert(point, PyKDL.Vector) == moved
        frame = tf2_kdl.do_transform_frame(PyKDL.Frame(), transform)
        assert frame == tf2_geometry_msgs.transform_to_kdl(transform)
        return "done"

    assert run_node(main) == "done"
