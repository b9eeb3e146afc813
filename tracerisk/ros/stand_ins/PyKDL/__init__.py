# ruff: noqa: F401 - all names of the library, also for `import *`
"""Stand-in for PyKDL: vectors, frames, chains of joints and their solvers."""

from ._chain import Chain, Joint, Segment, Tree
from ._frames import Frame, FrameVel, Rotation, addDelta, diff, dot
from ._joints import (
    Add,
    Divide,
    Equal,
    Jacobian,
    JntArray,
    JntArrayVel,
    JntSpaceInertiaMatrix,
    Multiply,
    MultiplyJacobian,
    RigidBodyInertia,
    RotationalInertia,
    SetToZero,
    Subtract,
)
from ._solvers import (
    ChainDynParam,
    ChainFkSolverPos_recursive,
    ChainFkSolverVel_recursive,
    ChainIdSolver_RNE,
    ChainIkSolverPos_LMA,
    ChainIkSolverPos_NR,
    ChainIkSolverPos_NR_JL,
    ChainIkSolverVel_pinv,
    ChainJntToJacSolver,
    SolverI,
)
from ._values import Twist, Vector, Wrench
