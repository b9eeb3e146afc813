"""`tracerisk overrides`: what was set by hand, why, and how far it lies from what is computed."""

import pytest

PINNED = """\
class Picker:
    def place(self):
        # | RiskAnnotation
        # | @Function {
        # |   name = Picker.place
        # |   callSequence := 3  ! computed 2; as the cell is drawn
        # |   next := init 4/5  ! computed init 9/10, done 1/10; shift book of the line
        # |   next := done 1/5
        # | }
        # | @Component {
        # |   name = gripper
        # |   probability := 2e-07  ! computed 8e-08; supplier derating, FMEA-112, which
        # |     ! also holds for the second batch that was delivered in spring
        # |   quantity := 3  ! computed 2
        # |   redundancy := true  ! computed false; twin valve
        # | }
        # | @Component := {  ! it holds the hose
        # |   name = hose
        # |   probability = 1e-06
        # |   quantity = 2
        # |   redundancy = true
        # | }
        # | @Component := omit {  ! hangs free
        # |   name = motor
        # |   probability = 9.5e-08
        # |   quantity = 7
        # |   redundancy = false
        # | }
        pass


def init():
    # | RiskAnnotation
    # | @Function := {  ! never seen to run; assessed by hand
    # |   name = init
    # |   callSequence = 1
    # |   next = Picker.place 1
    # | }
    # | @Component {
    # |   name = gripper
    # |   probability := 1e-09  ! computed none; guess
    # |   quantity = 1
    # |   redundancy = false
    # | }
    pass
"""

ROWS = [
    ("value", 6, "Picker.place.callSequence", "3", "2", 100.0, "as the cell is drawn"),
    ("value", 7, "Picker.place.next", "init 4/5, done 1/5", "init 9/10, done 1/10", 10.0, "shift"),
    ("value", 12, "Picker.place.gripper.probability", "2e-07", "8e-08", 150.0, "supplier derating"),
    ("value", 14, "Picker.place.gripper.quantity", "3", "2", 50.0, None),
    ("value", 15, "Picker.place.gripper.redundancy", "true", "false", 100.0, "twin valve"),
    ("added", 17, "Picker.place.hose", "added: 1e-06 x 2, redundant", None, None, "it holds"),
    ("omitted", 23, "Picker.place.motor", "omitted", "9.5e-08 x 7", None, "hangs free"),
    ("block", 33, "init", "by hand", None, None, "never seen"),
    ("value", 41, "init.gripper.probability", "1e-09", None, None, "guess"),
]


def test_each_thing_set_by_hand_is_reported_with_its_place_without_any_run(example):
    example.write("pick.py", PINNED)
    outcome = example.run("overrides", "pick.py", "--json")
    assert outcome.code == 0, outcome.err
    found = [
        tuple(
            each[key]
            for key in ("kind", "line", "field", "value", "computed", "drift_percent", "reason")
        )
        for each in outcome.json["overrides"]
    ]
    assert len(found) == len(ROWS)
    for row, expected in zip(found, ROWS, strict=True):
        assert row[:5] == expected[:5]
        assert row[5] == (None if expected[5] is None else pytest.approx(expected[5]))
        assert (row[6] or "").startswith(expected[6] or "")
        assert (row[6] is None) == (expected[6] is None)
    assert {each["file"] for each in outcome.json["overrides"]} == {"pick.py"}


def test_a_component_by_hand_in_some_functions_alone_is_named(example, annotated_source):
    computed, by_hand = "gripper = 1e-07", "gripper := 4e-08"
    source = annotated_source(
        pick=("put 1", by_hand),
        put=("home 1", computed),
        home=("rest 1", computed),
        rest=("done 1", "gripper = 0"),
    )
    example.write("pick.py", source)
    assert (
        "pick.py: gripper is set by hand in pick, and computed in put, home\n"
        in example.run("overrides", "pick.py").err
    )
    example.write("pick.py", source.replace("probability = 1e-07", "probability := 4e-08"))
    assert "computed in" not in example.run("overrides", "pick.py").err


def test_the_table_fits_80_columns_and_shows_every_reason_in_full(example):
    example.write("pick.py", PINNED.replace("gripper", "a_gripper_with_a_name_of_some_length"))
    outcome = example.run("overrides", "pick.py")
    lines = outcome.out.splitlines()
    assert max(map(len, lines)) <= 80
    assert lines[0] == "pick.py"
    assert lines[1].split() == ["line", "field", "set", "by", "hand", "computed", "drift"]
    text = " ".join(outcome.out.split())
    assert "supplier derating, FMEA-112, which also holds for the second batch that was" in text
    assert "+150 %" in text
    assert "9 set by hand, 1 of them without a reason" in outcome.err


@pytest.mark.parametrize(("limit", "code"), [("150", 0), ("149", 1), ("0", 1)])
def test_a_drift_beyond_the_limit_exits_1_and_names_the_field(limit, code, example):
    example.write("pick.py", PINNED)
    outcome = example.run("overrides", "pick.py", "--max-drift", limit)
    assert outcome.code == code
    text = "pick.py:12: Picker.place.gripper.probability has drifted by +150 %"
    assert (text in outcome.err) == bool(code)


def test_a_smaller_value_drifts_below_zero_and_where_zero_is_computed_without_bound(example):
    text = PINNED.replace(":= 2e-07  ! computed 8e-08", ":= 2e-08  ! computed 8e-08")
    text = text.replace(":= 1e-09  ! computed none", ":= 1e-09  ! computed 0")
    example.write("pick.py", text)
    outcome = example.run("overrides", "pick.py", "--json", "--max-drift", "100")
    drifts = {each["field"]: each["drift_percent"] for each in outcome.json["overrides"]}
    beyond = [each["field"] for each in outcome.json["overrides"] if each["exceeds"]]
    assert drifts["Picker.place.gripper.probability"] == pytest.approx(-75.0)
    assert outcome.code == 1
    assert beyond == ["init.gripper.probability"]
    assert "infinite" in example.run("overrides", "pick.py").out


def test_of_a_value_set_since_the_last_refresh_the_lock_says_what_is_computed(annotated):
    source = annotated.read("controller.py").decode()
    value = source.split("probability = ")[1].split("\n")[0]
    annotated.write(
        "controller.py", source.replace(f"probability = {value}", "probability := 1", 1)
    )
    outcome = annotated.run("overrides", "--json")
    assert outcome.code == 0, outcome.err
    (found,) = outcome.json["overrides"]
    assert (found["file"], found["value"], found["computed"]) == ("controller.py", "1", value)
    assert found["drift_percent"] == pytest.approx(100 * (1 - float(value)) / float(value))


def test_of_an_omission_in_short_the_lock_says_the_figure(annotated):
    source = annotated.read("controller.py").decode()
    head, _, rest = source.partition("    # | @Component {\n    # |   name = ")
    name = rest.split("\n")[0]
    after = rest.partition("    # | }\n")[2]
    annotated.write(
        "controller.py",
        f"{head}    # | @Component := omit {{  ! none\n    # |   name = {name}\n    # | }}\n{after}",
    )
    (found,) = annotated.run("overrides", "controller.py", "--json").json["overrides"]
    assert (found["kind"], found["value"]) == ("omitted", "omitted")
    assert found["computed"].split(" x ")[0] == rest.split("probability = ")[1].split("\n")[0]


def test_blocks_of_the_published_form_are_read_too(example):
    example.write(
        "place.c",
        "/***\n * RiskAnnotation\n * @Function {\n *   name = place\n *   callSequence = 1\n * }\n"
        " * @Component {\n *   name = g\n *   probability := 2e-7  ! computed 1e-7; FMEA\n"
        " *   quantity = 1\n *   redundancy = false\n * }\n ***/\nvoid place() {}\n",
    )
    (found,) = example.run("overrides", "place.c", "--json").json["overrides"]
    assert (found["line"], found["field"]) == (9, "place.g.probability")
    assert found["drift_percent"] == pytest.approx(100.0)


def test_a_file_named_twice_is_reported_once_and_one_without_blocks_has_nothing(example):
    example.write("pick.py", PINNED)
    example.write("plain.py", "x = 1\n")
    twice = example.run("overrides", "pick.py", "./pick.py", "plain.py", "--json")
    assert len(twice.json["overrides"]) == len(ROWS)
    outcome = example.run("overrides", "plain.py")
    assert (outcome.code, outcome.out) == (0, "")
    assert outcome.err == "0 set by hand, 0 of them without a reason\n"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], "no tracerisk.lock in or below this folder knows a controller; name a FILE"),
        (["nowhere.py"], "nowhere.py: cannot be read: No such file or directory"),
        (["bad.py"], "bad.py:3: the `@Function {` of this line has no `}`"),
        (["bad.py", "--max-drift", "-1"], "-1 is not a percentage from 0 up"),
    ],
)
def test_bad_input_is_reported(arguments, expected, example):
    example.write("bad.py", "def f():\n    # | RiskAnnotation\n    # | @Function {\n    pass\n")
    outcome = example.run("overrides", *arguments)
    assert outcome.code == 2
    assert expected in outcome.err
