"""What changed between two models, and what each change does to the mission's figure."""

from fractions import Fraction

import pytest

from tracerisk.adder.blocks.block import Field
from tracerisk.prm.review.model_parts import RiskVersion
from tracerisk.prm.review.risk_change import compare


def code(_):
    return ("code",)


@pytest.fixture
def version(block, component):
    """Make a version of blocks told as `name: (components, next)`, in call sequence."""

    def make(**functions):
        blocks = [
            block(name, rank, [component(*each) for each in components], after)
            for rank, (name, (components, after)) in enumerate(functions.items(), start=1)
        ]
        return RiskVersion.of_blocks(blocks, "c.py")

    return make


def difference(before, after, **options):
    return compare(before, after, name="c.py", cause_of=code, **options)


PICK = ([("gripper", 1e-7), ("motor", 2e-7, 7)], {"place": 1})
PLACE = ([("gripper", 3e-7)], {"pick": "9/10", "done": "1/10"})


def kinds(diff):
    return [change.kind for change in diff.changes]


def test_the_same_blocks_differ_in_nothing(version):
    diff = difference(version(pick=PICK, place=PLACE), version(pick=PICK, place=PLACE))
    assert (diff.changes, diff.pins, diff.single_points, diff.interaction) == ((), (), (), 0.0)
    assert diff.is_unchanged
    assert {each.status for each in diff.functions} == {"unchanged"}


@pytest.mark.parametrize(("rate", "kept"), [(2.0, ("code",)), (3.0, ())])
def test_the_hardwares_figure_and_all_else_are_changes_apart(version, rate, kept):
    """Of a probability that is 3 times as high, twice by the data; at 3 times nothing is left."""
    before = version(pick=([("motor", 2e-7, 7)], {"done": 1}))
    after = version(pick=([("motor", 6e-7, 7)], {"done": 1}))

    def cause(_):
        return ("code", "hardware")

    diff = compare(before, after, name="c.py", cause_of=cause, rated={"motor": rate})
    assert sorted(change.causes for change in diff.changes) == sorted(
        [("hardware",), *([kept] if kept else [])]
    )
    by_cause = {change.causes: change.contribution for change in diff.changes}
    base = before.figures.mission.failure_probability
    assert by_cause["hardware",] == pytest.approx((rate - 1.0) * base, rel=1e-5)
    if kept:
        assert by_cause[kept] == pytest.approx(0.5 * base, rel=1e-5)
    assert {share.kinds for share in diff.causes} == {("hardware data",), *([kept] if kept else [])}
    whole = compare(before, after, name="c.py", cause_of=cause)
    assert [change.causes for change in whole.changes] == [("code", "hardware")]


def test_one_figure_that_doubles_contributes_all_of_the_change(version, exact):
    before = version(pick=PICK, place=PLACE)
    after = version(pick=PICK, place=([("gripper", 6e-7)], PLACE[1]))
    diff = difference(before, after)
    (change,) = diff.changes
    rise = float(exact.mission(after.model) - exact.mission(before.model))
    assert (change.kind, change.component, change.functions) == (
        "probability",
        "gripper",
        ("place",),
    )
    assert change.contribution == pytest.approx(rise, rel=1e-6)
    assert abs(diff.interaction) < 1e-6 * rise
    assert change.summary == "gripper in place: probability 3e-07 -> 6e-07 (x2)"
    assert [each.status for each in diff.functions] == ["unchanged", "changed"]


def test_contributions_and_interaction_sum_to_the_change(version, exact):
    before = version(pick=([("motor", 0.1), ("gripper", 0.1)], {"done": 1}))
    after = version(pick=([("motor", 0.2), ("gripper", 0.4)], {"done": 1}))
    diff = difference(before, after)
    found = {change.component: change.contribution for change in diff.changes}
    assert found == pytest.approx(
        {"motor": (1 - 0.8 * 0.9) - (1 - 0.81), "gripper": (1 - 0.9 * 0.6) - (1 - 0.81)}
    )
    assert [change.component for change in diff.changes] == ["gripper", "motor"], "greatest first"
    assert diff.interaction == pytest.approx((1 - 0.8 * 0.6) - 0.19 - sum(found.values()))
    assert sum(found.values()) + diff.interaction == pytest.approx(diff.increase)


def test_a_change_within_one_percent_is_noise(version):
    before = version(pick=PICK, place=([("gripper", 3e-7)], {"pick": "80/100", "done": "20/100"}))
    after = version(
        pick=PICK, place=([("gripper", 3.02e-7)], {"pick": "801/1000", "done": "199/1000"})
    )
    diff = difference(before, after)
    assert (diff.changes, diff.within_noise) == ((), 2)
    assert diff.is_unchanged


def test_one_ratio_in_several_functions_is_one_change(version):
    def motors(factor):
        return version(
            pick=([("motor", 1e-7 * factor)], {"place": 1}),
            place=([("motor", 4e-7 * factor)], {"home": 1}),
            home=([("motor", 3e-7 * (factor if factor == 1 else 5))], {"done": 1}),
        )

    diff = difference(motors(1), motors(2))
    assert [(change.summary, change.functions) for change in diff.changes] == [
        ("motor in home: probability 3e-07 -> 1.5e-06 (x5)", ("home",)),
        ("motor in 2 functions: probability x2", ("pick", "place")),
    ]


def test_lost_redundancy_and_the_single_point_it_leaves_are_marked(version):
    before = version(pick=([("power", 1e-4, 2, True), ("arm", 1e-9)], {"done": 1}))
    after = version(pick=([("power", 1e-4, 2, False), ("arm", 1e-9)], {"done": 1}))
    diff = difference(before, after)
    (change,) = diff.changes
    assert (change.kind, change.marks) == (
        "redundancy",
        ("lost_redundancy", "single_point_of_failure"),
    )
    assert change.contribution == pytest.approx(2e-4 - 1e-8 - 1e-8, rel=1e-3)
    assert [(p.component, p.functions, p.is_new) for p in diff.single_points] == [
        ("power", ("pick",), False)
    ]
    back = difference(after, before)
    assert (back.changes[0].marks, back.single_points) == ((), ())


def test_fewer_redundant_units_are_less_redundancy_and_no_single_point(version):
    before = version(pick=([("power", 1e-4, 3, True)], {"done": 1}))
    after = version(pick=([("power", 1e-4, 2, True)], {"done": 1}))
    (change,) = difference(before, after).changes
    assert (change.kind, change.marks) == ("quantity", ("lost_redundancy",))


def test_quantity_and_redundancy_of_one_component_are_one_change(version):
    before = version(pick=([("power", 1e-4, 2, True)], {"done": 1}))
    after = version(pick=([("power", 1e-4, 1, False)], {"done": 1}))
    diff = difference(before, after)
    (change,) = diff.changes
    assert change.kind == "redundancy"
    assert change.summary.lower() == "power in pick: quantity 2 -> 1, redundancy true -> false"
    assert [field.key for field in change.fields] == ["quantity", "redundancy"]
    assert change.marks == ("lost_redundancy", "single_point_of_failure")
    assert change.contribution == pytest.approx(diff.increase)
    assert abs(diff.interaction) < 1e-18


def test_a_new_state_and_the_next_that_leads_to_it_are_one_change(version, exact):
    before = version(pick=PICK, place=([("gripper", 3e-7)], {"done": 1}))
    after = version(
        pick=([("gripper", 2e-7), ("motor", 2e-7, 7)], {"check": 1}),
        check=([("camera", 1e-6)], {"pick": "1/4", "place": "3/4"}),
        place=([("gripper", 3e-7)], {"done": 1}),
    )
    diff = difference(before, after)
    assert sorted(kinds(diff)) == ["probability", "structure"]
    (structure,) = [change for change in diff.changes if change.kind == "structure"]
    assert set(structure.functions) == {"check", "pick"}
    assert structure.marks == ("new_next", "new_state", "single_point_of_failure")
    alone = version(
        pick=([("gripper", 1e-7), ("motor", 2e-7, 7)], {"check": 1}),
        check=([("camera", 1e-6)], {"pick": "1/4", "place": "3/4"}),
        place=([("gripper", 3e-7)], {"done": 1}),
    )
    expected = float(exact.mission(alone.model) - exact.mission(before.model))
    assert structure.contribution == pytest.approx(expected, rel=1e-6)
    assert structure.summary == "new state check; pick: next place 1 -> check 1"
    back = difference(after, before)
    (gone,) = [change for change in back.changes if change.kind == "structure"]
    assert gone.summary == "removed state: check; pick: next check 1 -> place 1"
    assert gone.contribution is not None


def test_steps_that_lead_nowhere_alone_are_one_change(version):
    before = version(
        a=([("x", 1e-3)], {"b": 1}),
        b=([("x", 1e-3)], {"done": 1}),
    )
    after = version(
        a=([("x", 1e-3)], {"done": "1/2", "b": "1/2"}),
        b=([("x", 1e-3)], {"a": 1}),
    )
    diff = difference(before, after)
    (change,) = diff.changes
    assert change.functions == ("a", "b")
    assert change.contribution == pytest.approx(diff.increase)


def test_another_beginning_is_a_change(version):
    after = version(place=PLACE, pick=PICK)
    diff = difference(version(pick=PICK, place=PLACE), after)
    (change,) = diff.changes
    assert change.summary == "the mission starts with place, no longer pick"
    assert change.contribution == pytest.approx(diff.increase)


def test_a_renamed_function_is_no_change_of_risk(version):
    before = version(pick=PICK, place=PLACE)
    after = version(grab=PICK, place=([("gripper", 3e-7)], {"grab": "9/10", "done": "1/10"}))
    diff = difference(before, after, renamed={"pick": "grab"})
    assert (diff.changes, diff.increase) == ((), 0.0)
    assert [(each.name, each.was, each.status) for each in diff.functions] == [
        ("grab", "pick", "renamed"),
        ("place", None, "unchanged"),
    ]
    apart = difference(before, after)
    assert {each.status for each in apart.functions} == {"added", "removed", "unchanged"}


def test_a_component_left_out_by_hand_is_reported_as_that(block, component):
    def of(**marks):
        entries = [component("motor", 1e-7), component("gripper", 2e-7, **marks)]
        return RiskVersion.of_blocks([block("pick", 1, entries, {"done": 1})], "c.py")

    (change,) = difference(of(), of(omitted=True)).changes
    assert (change.kind, change.causes) == ("component_omitted", ("pin",))
    assert change.contribution == pytest.approx(-2e-7, rel=1e-6)
    (back,) = difference(of(omitted=True), of()).changes
    assert (back.kind, back.causes) == ("component_restored", ("pin",))
    assert back.contribution == pytest.approx(2e-7, rel=1e-6)


def pinned(value, computed, reason=None):
    return Field(value, str(value), pinned=True, computed=computed, reason=reason)


def test_pins_are_new_removed_changed_or_drifted(block, component):
    from dataclasses import replace

    def of(field):
        entry = component("gripper", 2e-7)
        entry = entry if field is None else replace(entry, probability=field)
        return RiskVersion.of_blocks([block("pick", 1, [entry], {"done": 1})], "c.py")

    def only(before, after):
        (pin,) = difference(of(before), of(after)).pins
        return pin.kind, pin.path, pin.after, pin.computed_after

    first = pinned(3e-7, "2e-07", "FMEA-1")
    path = "pick.gripper.probability"
    assert only(None, first) == ("new", path, "3e-07", "2e-07")
    assert only(first, None) == ("removed", path, None, None)
    assert only(first, pinned(4e-7, "2e-07")) == ("changed", path, "4e-07", "2e-07")
    assert only(first, pinned(3e-7, "2.5e-07")) == ("drifted", path, "3e-07", "2.5e-07")
    assert difference(of(first), of(pinned(3e-7, "2.01e-07"))).pins == (), "noise"
    assert difference(of(first), of(pinned(4e-7, "2e-07"))).changes[0].causes == ("pin",)


def test_a_version_without_blocks_has_no_changes_but_functions(version):
    after = version(pick=PICK, place=PLACE)
    diff = difference(None, after)
    assert (diff.before, diff.changes, diff.ratio, diff.interaction) == (None, (), None, None)
    assert [each.status for each in diff.functions] == ["added", "added"]
    assert difference(after, None).after is None


def test_weights_are_compared_as_fractions(version):
    one = version(a=([("x", 0.1)], {"a": Fraction(8, 10), "done": Fraction(2, 10)}))
    other = version(a=([("x", 0.1)], {"a": Fraction(4, 5), "done": Fraction(1, 5)}))
    assert difference(one, other).changes == ()


def test_a_unit_that_moved_to_a_component_of_its_own_is_no_new_single_point(version):
    before = version(pick=([("motor", 2e-7, 7)], {"done": 1}))
    after = version(pick=([("motor", 2e-7, 6), ("elbow", 4e-7)], {"done": 1}))
    (point,) = difference(before, after).single_points
    assert point.component == "elbow"
    moved = difference(before, after, moved={"elbow": ("motor",)})
    assert moved.single_points == ()
    (elbow,) = (change for change in moved.changes if change.component == "elbow")
    assert (elbow.summary, elbow.marks) == ("elbow in pick: now counted apart from motor", ())
    (cause,) = moved.causes
    assert cause.summary == "elbow and motor in pick"
    assert cause.contribution == pytest.approx(moved.increase)
    back = difference(after, before, moved={"elbow": ("motor",)})
    (elbow,) = (change for change in back.changes if change.component == "elbow")
    assert elbow.summary == "elbow in pick: no longer counted apart, but within motor"


def test_a_unit_that_was_redundant_where_it_was_is_a_new_single_point(version):
    before = version(pick=([("motor", 2e-7, 2, True)], {"done": 1}))
    after = version(pick=([("motor", 2e-7), ("elbow", 4e-7)], {"done": 1}))
    points = difference(before, after, moved={"elbow": ("motor",)}).single_points
    assert [point.component for point in points] == ["elbow", "motor"]
