"""How changes of components are told and put together."""

import pytest

from tracerisk.prm.review.change_records import ChangedField
from tracerisk.prm.review.component_changes import ComponentItem, alike, failure_words


def failures(function, before, after):
    path = f"{function}.gripper.failures"
    return ChangedField(path, function, "gripper", "failures", before, after, None)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (
            "dead 1: unaware 1",
            "dead 1: stopped late 0.53, unaware 0.47",
            "of its failures unaware 100 % -> 47 %, stopped late 0 % -> 53 %",
        ),
        (
            "dead 1/2: unaware 1 | stuck 1/2: stopped safely 1",
            "dead 1/2: back to pick 1 | stuck 1/2: stopped safely 1",
            "of its failures unaware 50 % -> 0 %, back to pick 0 % -> 50 %",
        ),
        (
            "dead 1: unaware 1/2, unaware in place 1/2",
            "dead 1: unaware 1/4, unaware in place 3/4",
            "the same follows its failures, of other modes or in other functions",
        ),
        ("dead 1: unaware 1", None, "what follows its failures is no longer known"),
        (
            None,
            "dead 1: stopped safely 1/4, unaware 3/4",
            "what follows its failures is known now: unaware 75 %, stopped safely 25 %",
        ),
    ],
)
def test_what_follows_failures_is_told_by_the_kinds_that_changed(before, after, words):
    assert failure_words([failures("pick", before, after)]) == words


def test_shares_of_several_functions_are_told_from_the_least_to_the_greatest():
    pairs = [
        ("dead 1: unaware 0.02, stopped late 0.98", "dead 1: stopped late 1"),
        ("dead 1: unaware 0.03, stopped late 0.97", "dead 1: stopped late 1"),
    ]
    fields = [failures(name, *both) for name, both in zip("ab", pairs, strict=True)]
    assert failure_words(fields) == (
        "of its failures unaware 2 to 3 % -> 0 %, stopped late 97 to 98 % -> 100 %"
    )
    items = [ComponentItem("failures", (field,), None, lambda parts: None) for field in fields]
    assert len(alike(items)) == 1


def test_what_rises_and_falls_alike_is_one_change():
    texts = [
        ("dead 1: unaware 1", "dead 1: stopped safely 1"),
        ("dead 1: unaware 1/2, unaware in put 1/2", "dead 1: stopped safely in put 1"),
        ("dead 1: unaware 1", "dead 1: stopped late 1"),
    ]
    items = [
        ComponentItem("failures", (failures(function, *both),), None, lambda parts: None)
        for function, both in zip(("pick", "lift", "put"), texts, strict=True)
    ]
    groups = [[item.field.function for item in group] for group in alike(items)]
    assert groups == [["pick", "lift"], ["put"]]
