"""What a review tells: controllers of several files, causes, renames, and the library's `diff`."""

import json
from dataclasses import replace

import pytest

import tracerisk
from tracerisk.adder.lock.lock import Behind, ControllerLock, Lock, written_block
from tracerisk.adder.sources.read import read_blocks
from tracerisk.errors import BlockError, InputError
from tracerisk.pipeline.review.review import review
from tracerisk.report.diff.markdown import render_diff_markdown
from tracerisk.report.diff.text import render_diff


def lock_of(texts: dict[str, str], controller: str, /, **inputs) -> ControllerLock:
    """The entry that a run would have written: its blocks, and what it depended on."""
    blocks = {
        file: {
            each.function: written_block(each.block) for each in read_blocks(text.encode(), file)
        }
        for file, text in texts.items()
    }
    plain = {"sources": {}, "files": {}, "settings": {}, "given": {}, "hardware": "", **inputs}
    return ControllerLock("f", blocks, inputs=plain)


def write(repository, files, *entries, folder=""):
    """Write sources and the lock with the entries `(controller, entry)`."""
    lock = Lock()
    for controller, entry in entries:
        lock = lock.with_controller(controller, entry)
    for name, text in files.items():
        repository.write(f"{folder}{name}", text)
    repository.write(f"{folder}tracerisk.lock", lock.dumps())


@pytest.fixture
def parts(annotated_source):
    """The two files of one controller; `next` leads from one to the other."""

    def make(gripper="= 2e-07", motor="1e-7"):
        text = annotated_source(pick=("place 1", f"motor = {motor} x7"))
        other = annotated_source(place=("done 1", f"gripper {gripper}"))
        return {"main.py": text, "hand.py": other.replace("callSequence = 1", "callSequence = 2")}

    return make


def only(found):
    (diff,) = found.controllers
    return diff


def test_a_controller_of_several_files_is_one_model_by_its_lock(repository, parts):
    write(repository, parts(), ("main.py", lock_of(parts(), "main.py")))
    repository.commit()
    repository.write("hand.py", parts(gripper="= 4e-07")["hand.py"])
    diff = only(review([], repository.folder))
    assert diff.name == "main.py"
    assert diff.before.failure_probability == pytest.approx(9e-7, rel=1e-5)
    assert diff.after.failure_probability == pytest.approx(11e-7, rel=1e-5)
    assert only(review(["hand.py"], repository.folder)) == diff
    assert [str(change.fields[0].location) for change in diff.changes] == ["hand.py:10"]


def test_a_lock_in_a_folder_names_files_from_there(repository, parts):
    write(repository, parts(), ("main.py", lock_of(parts(), "main.py")), folder="cell/")
    repository.commit()
    changed = parts(gripper="= 4e-07")
    write(repository, changed, ("main.py", lock_of(changed, "main.py")), folder="cell/")
    diff = only(review([], repository.folder))
    assert (diff.name, len(diff.functions)) == ("cell/main.py", 2)
    assert diff == only(review([], repository.folder))
    assert only(review([], repository.folder / "cell")).name == "main.py"


def test_a_lock_that_only_one_version_has_says_for_both(repository, parts):
    for name, text in parts().items():
        repository.write(name, text)
    repository.commit()
    changed = parts(gripper="= 4e-07")
    write(repository, changed, ("main.py", lock_of(changed, "main.py")))
    diff = only(review([], repository.folder))
    assert diff.before.failure_probability == pytest.approx(9e-7, rel=1e-5)
    assert diff.ratio == pytest.approx(11 / 9, rel=1e-4)


def test_a_controller_that_moves_keeps_its_files_and_its_past(repository, parts):
    write(repository, parts(), ("main.py", lock_of(parts(), "main.py")))
    repository.commit()
    repository.git("mv", "main.py", "start.py")
    moved = parts(gripper="= 4e-07")
    moved["start.py"] = moved.pop("main.py")
    entry = lock_of(moved, "start.py", sources={"start.py": "b"})
    write(repository, moved, ("start.py", entry))
    diff = only(review([], repository.folder))
    assert (diff.name, diff.was, diff.ratio) == ("start.py", "main.py", pytest.approx(11 / 9, 1e-4))
    assert [change.summary for change in diff.changes] == [
        "gripper in place: probability 2e-07 -> 4e-07 (x2)"
    ]


@pytest.mark.parametrize("is_run", [True, False])
def test_a_controller_that_moves_is_not_lost_though_the_lock_keeps_its_old_entry(
    repository, parts, is_run
):
    entries = [("main.py", lock_of(parts(), "main.py", sources={"main.py": "a"}))]
    write(repository, parts(), *entries)
    repository.commit()
    repository.git("mv", "main.py", "start.py")
    moved = parts()
    moved["start.py"] = moved.pop("main.py")
    if is_run:
        entries.append(("start.py", lock_of(moved, "start.py", sources={"start.py": "a"})))
    write(repository, moved, *entries)
    for words in ([], ["HEAD", "start.py"]):
        diff = only(review(words, repository.folder))
        assert (diff.name, diff.was, diff.is_unchanged) == ("start.py", "main.py", True)


def test_a_function_that_moves_to_another_file_of_its_controller_is_unchanged(repository, parts):
    write(repository, parts(), ("main.py", lock_of(parts(), "main.py")))
    repository.commit()
    both = {"main.py": parts()["main.py"] + "\n\n" + parts()["hand.py"]}
    write(repository, both, ("main.py", lock_of(both, "main.py")))
    (repository.folder / "hand.py").unlink()
    diff = only(review([], repository.folder))
    assert (diff.name, diff.changes, diff.increase) == ("main.py", (), 0.0)
    assert {each.status for each in diff.functions} == {"unchanged"}


def test_a_lock_in_conflict_is_read_and_a_broken_one_names_its_version(repository, parts):
    write(repository, parts(), ("main.py", lock_of(parts(), "main.py")))
    repository.commit()
    whole = repository.read("tracerisk.lock").decode()
    ours = '"fingerprint": "f"'
    sides = f'<<<<<<< HEAD\n   {ours},\n=======\n   "fingerprint": "g",\n>>>>>>> side\n'
    assert whole.count(f"   {ours},\n") == 1
    repository.write("tracerisk.lock", whole.replace(f"   {ours},\n", sides))
    repository.write("hand.py", parts(gripper="= 4e-07")["hand.py"])
    assert only(review([], repository.folder)).name == "main.py"
    repository.write("tracerisk.lock", whole[:40])
    with pytest.raises(InputError, match=r"^tracerisk\.lock.*: in working tree: is not JSON"):
        review([], repository.folder)
    (repository.folder / "sub").mkdir()
    with pytest.raises(InputError, match=r"^\.\./tracerisk\.lock"):
        review([], repository.folder / "sub")
    repository.commit()
    write(repository, parts(), ("main.py", lock_of(parts(), "main.py")))
    with pytest.raises(InputError, match=r"^HEAD:tracerisk\.lock.*: in HEAD: is not JSON"):
        review([], repository.folder)


@pytest.mark.parametrize(
    ("inputs", "causes"),
    [
        ({"sources": {"main.py": "b"}}, ("code",)),
        ({"hardware": "b"}, ("hardware",)),
        ({"settings": {"hardware": "b.yaml"}}, ("hardware",)),
        ({"settings": {"seed": 1}}, ("settings",)),
        ({"files": {"arm.yaml": "b"}}, ("files",)),
        ({"sources": {"main.py": "b"}, "hardware": "b"}, ("code", "hardware")),
        ({}, ("edit",)),
    ],
)
def test_the_lock_says_the_cause(repository, parts, inputs, causes):
    write(repository, parts(), ("main.py", lock_of(parts(), "main.py")))
    repository.commit()
    after = parts(gripper="= 4e-07")
    write(repository, after, ("main.py", lock_of(after, "main.py", **inputs)))
    (change,) = only(review([], repository.folder)).changes
    assert change.causes == causes


@pytest.mark.parametrize(
    ("inputs", "described", "causes"),
    [
        ({"sources": {"main.py": "b"}, "hardware": "b"}, {"motor": "2"}, ("code",)),
        ({"sources": {"main.py": "b"}, "hardware": "b"}, {"gripper": "2"}, ("code", "hardware")),
        ({"hardware": "b"}, {"gripper": "2"}, ("hardware",)),
        # Nothing else explains it.
        ({"hardware": "b"}, {"motor": "2"}, ("hardware",)),
        ({"files": {"a": "b"}, "settings": {"hardware": "b.yaml"}}, {}, ("files",)),
        ({"files": {"a": "b"}, "settings": {"active": "x"}}, {}, ("files", "hardware")),
    ],
)
def test_a_component_changed_by_the_hardware_data_only_where_its_own_entry_differs(
    repository, parts, inputs, described, causes
):
    entries = {"gripper": "1", "motor": "1"}
    before = replace(lock_of(parts(), "main.py"), behind=Behind(components=entries))
    write(repository, parts(), ("main.py", before))
    repository.commit()
    after = parts(gripper="= 4e-07")
    behind = Behind(components={**entries, **described})
    write(
        repository,
        after,
        ("main.py", replace(lock_of(after, "main.py", **inputs), behind=behind)),
    )
    (change,) = only(review([], repository.folder)).changes
    assert change.component == "gripper"
    assert change.causes == causes


def test_what_the_runs_depended_on_is_reported(repository, parts):
    old = {"sources": {"main.py": "a", "old.py": "a"}, "hardware": "a", "settings": {"seed": 1}}
    new = {"sources": {"main.py": "b", "new.py": "a"}, "hardware": "b", "settings": {"robot": "r"}}
    write(repository, parts(), ("main.py", lock_of(parts(), "main.py", **old)))
    repository.commit()
    after = parts(gripper="= 4e-07")
    write(repository, after, ("main.py", lock_of(after, "main.py", **new)))
    found = review([], repository.folder)
    assert only(found).inputs == (
        "main.py has changed",
        "new.py is part of the run now",
        "old.py is no part of the run any more",
        "the hardware description has changed",
        "setting robot was the default, is r",
        "setting seed was 1, is the default",
    )
    assert "  - setting seed was 1, is the default\n" in render_diff(found)
    assert "- setting seed was 1, is the default\n" in render_diff_markdown(found)


def test_a_value_that_the_lock_did_not_write_is_an_edit_and_a_pin_is_a_pin(repository, parts):
    write(repository, parts(), ("main.py", lock_of(parts(), "main.py")))
    repository.commit()
    entry = lock_of(parts(), "main.py", sources={"main.py": "b"})
    write(repository, parts(motor="2e-7", gripper=":= 4e-07 ! computed"), ("main.py", entry))
    changed = {
        change.component: change.causes for change in only(review([], repository.folder)).changes
    }
    assert changed == {"motor": ("edit",), "gripper": ("pin",)}
    (pin,) = only(review([], repository.folder)).pins
    assert (pin.kind, pin.path, pin.after) == ("new", "place.gripper.probability", "4e-07")


def test_without_a_lock_the_code_says_the_cause(repository, two_steps):
    repository.write("pick.py", two_steps())
    repository.commit()
    repository.write("pick.py", two_steps(gripper="= 4e-07").replace('arm.go("', 'arm.run("'))
    assert only(review([], repository.folder)).changes[0].causes == ("code",)
    repository.write("pick.py", "# A comment.\n" + two_steps(gripper="= 4e-07"))
    assert only(review([], repository.folder)).changes[0].causes == ("edit",)


def test_a_renamed_function_is_reported_as_renamed_and_changes_nothing(repository, two_steps):
    repository.write("pick.py", two_steps())
    repository.commit()
    renamed = two_steps().replace("def pick(", "def grab(").replace("name = pick", "name = grab")
    renamed = renamed.replace("next = pick", "next = grab")
    repository.write("pick.py", renamed)
    diff = only(review([], repository.folder))
    first = diff.functions[0]
    assert (first.name, first.was, first.status) == ("grab", "pick", "renamed")
    assert (diff.changes, diff.increase) == ((), 0.0)
    # Its code may change as well, if its block stays.
    repository.write("pick.py", renamed.replace('arm.go("pick")', 'arm.run("grab")'))
    assert only(review([], repository.folder)).functions[0].was == "pick"


def test_two_renamed_functions_with_one_body_are_not_mixed_up(annotated_source):
    before = (
        annotated_source(a=("b 1", "motor = 1e-7"), b=("done 1", "motor = 3e-7"))
        .replace('arm.go("a")', "arm.go()")
        .replace('arm.go("b")', "arm.go()")
    )
    after = before.replace("def a(", "def c(").replace("name = a\n", "name = c\n")
    after = after.replace("def b(", "def d(").replace("name = b\n", "name = d\n")
    after = after.replace("next = b 1", "next = d 1")
    diff = tracerisk.diff({"x.py": before.encode()}, {"x.py": after.encode()})
    assert {each.name: each.was for each in diff.functions} == {"c": "a", "d": "b"}
    assert diff.changes == ()


def test_the_library_compares_sources(two_steps):
    before, after = two_steps().encode(), two_steps(power="1e-5 x2").encode()
    diff = tracerisk.diff({"pick.py": before}, {"pick.py": after}, name="cell")
    assert diff.name == "cell"
    assert [change.marks for change in diff.changes] == [
        ("lost_redundancy", "single_point_of_failure")
    ]
    assert tracerisk.diff({}, {"pick.py": after}).before is None
    assert tracerisk.diff({"pick.py": before}, {"pick.py": b"x = 1\n"}).after is None
    with pytest.raises(BlockError, match=r"pick\.py:\d+: .*next leads to 'x'"):
        tracerisk.diff(
            {"pick.py": before}, {"pick.py": after.replace(b"next = place", b"next = x")}
        )


def test_of_two_controllers_only_the_one_that_changed_is_reported(repository, annotated_source):
    def files(gripper):
        return {
            "a.py": annotated_source(reach=("done 1", "motor = 1e-7")),
            "b.py": annotated_source(lift=("done 1", f"gripper = {gripper}")),
        }

    old, new = files("1e-7"), files("5e-7")
    both = [
        ("a.py", lock_of({"a.py": old["a.py"]}, "a.py")),
        ("b.py", lock_of({"b.py": old["b.py"]}, "b.py")),
    ]
    write(repository, old, *both)
    repository.commit()
    write(repository, new, *both)
    found = review([], repository.folder)
    assert [each.name for each in found.controllers] == ["b.py"]


def test_the_greatest_change_comes_first(repository, two_steps):
    for name in ("a.py", "b.py", "c.py"):
        repository.write(name, two_steps())
    repository.commit()
    for name, gripper in (("a.py", "3e-07"), ("b.py", "9e-07"), ("c.py", "3e-07")):
        repository.write(name, two_steps(gripper=f"= {gripper}"))
    found = review([], repository.folder)
    assert [each.name for each in found.controllers] == ["b.py", "a.py", "c.py"]


def test_a_review_is_plain_json(repository, two_steps):
    from tracerisk.prm.formats.diff_json import review_to_json

    repository.write("pick.py", two_steps(gripper="= 0"))
    repository.commit()
    repository.write("pick.py", two_steps(gripper=":= 4e-07 ! computed 2e-07"))
    data = review_to_json(review([], repository.folder))
    assert json.loads(json.dumps(data, allow_nan=False)) == json.loads(json.dumps(data))
    (controller,) = data["controllers"]
    assert controller["functions"][1]["status"] == "changed"
    assert controller["changes"][0]["fields"][0]["location"]["file"] == "pick.py"


@pytest.fixture
def showed(repository, parts):
    """Commit a version whose run showed `first`, and leave one whose run showed `later`."""

    def make(first, later, code=""):
        def entry(trace):
            return replace(lock_of(parts(), "main.py"), trace=trace)

        write(repository, parts(), ("main.py", entry(first)))
        repository.commit()
        texts = {**parts(), "main.py": f"{parts()['main.py']}\n{code}"}
        write(repository, texts, ("main.py", entry(later)))
        return review([], repository.folder)

    return make


@pytest.mark.parametrize(
    ("later", "n_unchanged"),
    [
        ({"motor": "1.02e-7"}, 1),
        ({"motor": "0.98e-7", "gripper": "= 2.1e-07"}, 2),
        ({"motor": "1.04e-7"}, 0),
        ({"gripper": ":= 2.1e-07 ! computed 2e-07"}, 0),
    ],
)
def test_what_lies_within_how_far_a_live_run_repeats_is_not_reported(
    repository, parts, later, n_unchanged
):
    repeats = {"pick": {"repeats": 0.03}, "place": {"repeats": 0.06}}

    def live(texts):
        return replace(lock_of(texts, "main.py"), trace={"functions": repeats})

    write(repository, parts(), ("main.py", live(parts())))
    repository.commit()
    write(repository, parts(**later), ("main.py", live(parts(**later))))
    diff = only(review([], repository.folder))
    assert diff.within_noise == n_unchanged
    assert diff.is_unchanged == bool(n_unchanged)
    assert diff.noise == {0: 0.01, 1: 0.03, 2: 0.06}[n_unchanged]


@pytest.mark.parametrize("earlier", [{}, {"pick": {"repeats": 0.03}}])
def test_a_live_run_that_repeats_hides_no_limit_and_needs_another_one(repository, parts, earlier):
    def live(texts, repeats):
        return replace(lock_of(texts, "main.py"), trace={"functions": repeats})

    write(repository, parts(), ("main.py", live(parts(), earlier)))
    repository.commit()
    now = parts(motor="1.02e-7")
    write(repository, now, ("main.py", live(now, {"pick": {"repeats": 0.25}})))
    diff = only(review([], repository.folder))
    assert diff.within_noise == len(earlier)
    if earlier:
        assert diff.stated.failure_probability > diff.after.failure_probability
    else:
        assert diff.stated is None


TOUCH = {"unexpected_contacts": {"hand.py": {"place": [["finger", "table"]]}}}


def test_a_contact_that_the_earlier_run_did_not_show_is_reported_whatever_the_figure_does(showed):
    found = showed({}, {**TOUCH, "uncovered": {"main.py": ["drop"]}}, code="LATER = 1\n")
    diff = only(found)
    assert diff.is_unchanged
    assert diff.of_run == (
        "finger and table touch in place, which was not to be expected",
        "drop can move the arm and did not run: no risk data",
    )
    assert found.is_worth_telling(0.5)
    assert "finger and table touch in place" in " ".join(render_diff(found, width=200).split())
    assert "- finger and table touch in place" in render_diff_markdown(found)


def bump(from_grasp_s, *, force=30.1, expected=False):
    touches = {"number": 1, "force_n": force, "touching_s": 0.04, "start_s": 6.0}
    kind = "expected" if expected else "unexpected"
    own = {kind: {**touches, "from_grasp_s": from_grasp_s}}
    pair = {"hand.py": {"place": {"palm": {"tube": own}}}}
    contacts = {} if expected else {"hand.py": {"place": [["palm", "tube"]]}}
    return {"unexpected_contacts": contacts, "touches": pair}


def test_a_touch_that_a_longer_wait_parts_from_its_grasp_is_no_news(showed):
    found = showed(bump(-0.7, expected=True), bump(-1.5), code="LATER = 1\n")
    assert only(found).of_run == ()


def test_a_harder_touch_before_the_grasp_is_news_with_its_force_and_time(showed):
    found = showed(bump(-0.7, expected=True), bump(-1.5, force=60.0), code="LATER = 1\n")
    assert only(found).of_run == (
        "palm and tube touch in place, which was not to be expected: up to 60 N, 0.04 s, at 6.0 s, "
        "1.5 s before it is held",
    )


def pressed(**functions):
    """What the lock keeps of a held jar that touched the floor, by function: force, s, start."""
    keys = ("number", "force_n", "touching_s", "start_s")
    touches = {
        name: {"jar": {"floor": {"unexpected": dict(zip(keys, (1, *value), strict=True))}}}
        for name, value in functions.items()
    }
    contacts = {name: [["jar", "floor"]] for name in functions}
    return {"unexpected_contacts": {"hand.py": contacts}, "touches": {"hand.py": touches}}


@pytest.mark.parametrize(
    ("now", "news"),
    [
        ({"place": (26.0, 0.28, 9.7), "drop": (1.9, 0.03, 10.0)}, 0),
        ({"place": (60.0, 0.28, 9.7)}, 1),
        ({"place": (26.0, 3.1, 9.7)}, 1),
        ({"place": (26.0, 0.31, 14.0)}, 1),
        ({"pick": (26.0, 0.31, 9.7), "place": (26.0, 0.31, 20.0)}, 1),
    ],
    ids=["cut otherwise", "harder", "longer", "at another time", "once more"],
)
def test_a_touch_that_is_in_another_function_now_is_no_news(showed, now, news):
    found = showed(pressed(pick=(26.0, 0.31, 9.7)), pressed(**now), code="LATER = 1\n")
    assert len(only(found).of_run) == news


def test_a_short_touch_beside_the_long_one_of_another_function_is_news(showed):
    """All touches together are about as hard and long as before."""
    long = {"pick": (26.0, 3.1, 9.7)}
    found = showed(pressed(**long), pressed(**long, place=(20.0, 0.3, 14.0)), code="LATER = 1\n")
    (line,) = only(found).of_run
    assert line.startswith("jar and floor touch in place")


def test_a_contact_that_the_earlier_run_showed_too_is_not_reported_again(showed):
    found = showed(TOUCH, TOUCH, code="LATER = 1\n")
    assert only(found).of_run == ()
    assert not found.is_worth_telling(0.5)


def test_a_branch_that_has_moved_on_is_named_with_its_figure(repository, two_steps):
    repository.write("pick.py", two_steps())
    repository.commit()
    repository.git("branch", "-M", "main")
    repository.git("switch", "-q", "-c", "side")
    repository.write("pick.py", two_steps(gripper="= 4e-07"))
    repository.commit()
    assert review(["main...side"], repository.folder).moved_on == ()
    repository.git("switch", "-q", "main")
    repository.write("other.txt", "nothing of it")
    repository.commit()
    assert review(["main...side"], repository.folder).moved_on == ()
    repository.write("pick.py", two_steps(motor="9e-8"))
    repository.commit()
    figure = review(["side..main"], repository.folder).controllers[0].after.failure_probability
    (line,) = review(["main...side"], repository.folder).moved_on
    assert line.startswith(
        f"main has moved on since: pick.py is another one there, and gives {figure:.3e}; "
    )
    for form in ("text", "markdown"):
        out = repository.run("diff", "main...side", "--format", form, "--silent-below", "9").out
        assert "main has moved on since" in " ".join(out.split())[:200]
    assert review(["main..side"], repository.folder).moved_on == ()


def test_a_step_that_is_a_helper_now_is_not_said_to_be_removed(repository, annotated_source):
    source = annotated_source(pick=("place 1", "motor = 1e-7"), place=("done 1", "gripper = 2e-7"))
    repository.write("pick.py", source)
    repository.commit()
    alone = annotated_source(pick=("done 1", "motor = 1e-7"))
    repository.write("pick.py", f"{alone}\n\ndef place(arm):\n    arm.go()\n")
    assert only(review([], repository.folder)).without_step == ("place",)
    assert "place (no step of its own any more)" in repository.run("diff").out
    repository.write("pick.py", alone)
    assert "place (removed)" in repository.run("diff").out
