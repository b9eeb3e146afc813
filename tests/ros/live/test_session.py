"""How often a live run looks whether its nodes wait."""

from tracerisk.ros.live.session import poll_s


def test_a_node_that_goes_on_is_looked_at_less_and_less_often():
    pauses = [poll_s(polls) for polls in range(1, 101)]
    assert pauses[:15] == [0.0005] * 15
    assert pauses == sorted(pauses)
    assert pauses[-1] == 0.004
