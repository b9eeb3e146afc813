"""The search for a way under a rule ends, whether or not there is one."""

import numpy as np

from tracerisk.twin.motion.rrt_connect import connect

LOWER, UPPER = np.full(7, -3.0), np.full(7, 3.0)


def test_a_rule_that_only_the_ends_keep_to_is_given_up_after_so_many_looks():
    looks = []
    start, goal = np.zeros(7), np.full(7, 2.0)

    def excess(values):
        looks.append(values)
        # Each projection is led on and comes nowhere.
        return np.array([1.0 + abs(values[0] - 1.0), np.sin(9.0 * values).sum()])

    def is_free(values):
        return bool((values == start).all() or (values == goal).all())

    assert connect(start, [goal], LOWER, UPPER, is_free, excess, most_looks=2000) is None
    assert 2000 < len(looks) < 2200


def test_a_way_on_which_the_rule_holds_is_found():
    start = np.array([1.0, 0, 0, 0, 0, 0, 0])
    goal = np.array([-1.0, 0, 0, 0, 0, 0, 0])

    def excess(values):
        # On the ring around the first two joints' origin.
        far = float(np.hypot(values[0], values[1]))
        return np.array([far - 1.1 if far > 1.1 else min(far - 0.9, 0.0)])

    def is_free(values):
        return 0.85 < float(np.hypot(values[0], values[1])) < 1.15

    path = connect(start, [goal], LOWER, UPPER, is_free, excess)
    assert path is not None
    assert all(0.8 < np.hypot(*point[:2]) < 1.2 for point in path)
