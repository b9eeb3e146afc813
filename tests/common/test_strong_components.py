"""Strongly connected components."""

from tracerisk.common.strong_components import strong_components


def test_rings_come_together_and_after_what_they_lead_to():
    found = strong_components({"a": "b", "b": "c", "c": "bd", "d": ""})
    assert [sorted(each) for each in found] == [["d"], ["b", "c"], ["a"]]


def test_a_long_chain_needs_no_recursion():
    size = 50_000
    following = {number: [number + 1] for number in range(size)} | {size: [size // 2]}
    found = strong_components(following)
    assert len(found[0]) == size // 2 + 1
    assert len(found) == size // 2 + 1
