"""Kinematics of the UR10e by its Denavit-Hartenberg table; poses of the flange in base_link."""
import numpy as np

#        d        a         alpha
DH = ((0.1807, 0.0, np.pi / 2),
      (0.0, -0.6127, 0.0),
      (0.0, -0.57155, 0.0),
      (0.17415, 0.0, np.pi / 2),
      (0.11985, 0.0, -np.pi / 2),
      (0.11655, 0.0, 0.0))
BASE = np.diag([-1.0, -1.0, 1.0, 1.0])  # base_link is the DH base, turned by half a turn


def forward(q):
    t = BASE.copy()
    for (d, a, alpha), angle in zip(DH, q):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        t = t @ np.array([[c, -s * ca, s * sa, a * c],
                          [s, c * ca, -c * sa, a * s],
                          [0.0, sa, ca, d],
                          [0.0, 0.0, 0.0, 1.0]])
    return t


def _error(q, xyz, rotation):
    t = forward(q)
    d = rotation @ t[:3, :3].T
    turn = 0.5 * np.array([d[2, 1] - d[1, 2], d[0, 2] - d[2, 0], d[1, 0] - d[0, 1]])
    return np.concatenate([np.asarray(xyz) - t[:3, 3], turn])


def inverse(xyz, rotation, seed, rounds=60):
    """Damped least squares from a seed near the solution."""
    q = np.array(seed, dtype=float)
    for _ in range(rounds):
        e = _error(q, xyz, rotation)
        if np.abs(e).max() < 1e-6:
            return q
        jac = np.empty((6, 6))
        for i in range(6):
            step = np.zeros(6)
            step[i] = 1e-6
            jac[:, i] = (e - _error(q + step, xyz, rotation)) / 1e-6
        q = q + np.clip(np.linalg.solve(jac.T @ jac + 1e-6 * np.eye(6), jac.T @ e), -0.3, 0.3)
    raise ArithmeticError(f"no joint values for {xyz}")
