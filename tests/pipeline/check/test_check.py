"""Freshness: what `check` tells without a run, and what `refresh` does about it."""

import json
import re
import subprocess
import sys
from argparse import Namespace

import pytest

from tracerisk.adder.lock.lock import data_digest

HEAD = """\
import moveit_commander, rospy
from helper import REACH

rospy.init_node("quick")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)


def reach():
    arm.go([REACH, -0.785, 0, -2.356, 0, 1.571, 0.785], wait=True)


def home():
    arm.go([0, -0.785, 0, -2.356, 0, 1.571, 0.785], wait=True)


reach()
home()
"""
SETTINGS = "[tool.tracerisk]\nseed = 0\n"


@pytest.fixture(scope="module")
def run_once(tmp_path_factory, example_in):
    """The files of a controller that was run once."""
    example = example_in(tmp_path_factory.mktemp("run"))
    example.write("pyproject.toml", SETTINGS)
    example.write("helper.py", "REACH = 0.2\n")
    example.write("c.py", HEAD)
    outcome = example.run("run", "c.py")
    assert outcome.code == 0, outcome.err
    names = ("pyproject.toml", "helper.py", "c.py", "tracerisk.lock")
    cache = {
        path.name: path.read_bytes() for path in (example.folder / ".tracerisk_cache").iterdir()
    }
    return {name: example.read(name) for name in names}, cache


@pytest.fixture
def project(run_once, example):
    files, cache = run_once
    for name, data in files.items():
        (example.folder / name).write_bytes(data)
    (example.folder / ".tracerisk_cache").mkdir()
    for name, data in cache.items():
        (example.folder / ".tracerisk_cache" / name).write_bytes(data)
    return example


def change(project, name: str, before: str, after: str) -> None:
    data = project.read(name).decode()
    assert before in data
    (project.folder / name).write_text(data.replace(before, after, 1))


def check(project, *files: str) -> tuple[int, list[tuple[str, str, int | None]], str]:
    outcome = project.run("check", *files, "--json")
    found = json.loads(outcome.out)
    kinds = [(each["kind"], each["file"], each["line"]) for each in found["findings"]]
    return outcome.code, kinds, " ".join(each["message"] for each in found["findings"])


def line_of(project, text: str) -> int:
    return project.read("c.py").decode().splitlines().index(text) + 1


def test_what_was_just_run_is_fresh(project):
    assert check(project)[:2] == (0, [])
    assert check(project, "c.py")[:2] == (0, [])


def test_comments_and_blank_lines_make_nothing_stale(project):
    change(project, "c.py", "rospy.init_node", "# The node.\n\nrospy.init_node")
    change(project, "helper.py", "REACH", "# How far.\nREACH")
    assert check(project)[:2] == (0, [])
    outcome = project.run("run", "c.py", "--check", "-q")
    assert outcome.code == 0


@pytest.mark.parametrize(
    ("file", "before", "after", "expected"),
    [
        ("c.py", "factor(1.0)", "factor(0.5)", "c.py has changed since the last run"),
        ("helper.py", "0.2", "0.3", "helper.py has changed since the last run"),
        ("pyproject.toml", "seed = 0", "seed = 1", "setting seed was the default, is 1"),
        ("tracerisk.lock", '"tracerisk": "', '"tracerisk": "0.', "version of tracerisk was 0."),
    ],
)
def test_what_a_run_depends_on_makes_it_stale(project, file, before, after, expected):
    change(project, file, before, after)
    code, kinds, message = check(project)
    assert (code, set(kinds)) == (1, {("stale", "c.py", 1)})
    assert expected in message


def test_a_file_that_a_controller_imports_leads_to_the_controller(project):
    change(project, "helper.py", "0.2", "0.3")
    assert check(project, "helper.py")[1] == [("stale", "c.py", 1)]
    project.write("unrelated.py", "x = 1\n")
    assert check(project, "unrelated.py")[:2] == (0, [])
    (project.folder / "helper.py").unlink()
    assert "helper.py is gone" in check(project)[2]


def test_an_edit_without_a_pin_is_reported_with_its_field_and_a_pinned_one_passes(project):
    text = project.read("c.py").decode()
    value = re.search(r"probability = (\S+)", text)[1]
    change(project, "c.py", f"probability = {value}", "probability = 2e-07")
    code, kinds, message = check(project)
    assert (code, kinds) == (
        3,
        [("edited", "c.py", line_of(project, "    # |   probability = 2e-07"))],
    )
    assert f"is 2e-07, was written as {value}" in message
    change(project, "c.py", "probability = 2e-07", "probability := 2e-07  ! ; FMEA-112")
    assert check(project)[:2] == (0, [])


def test_a_reason_may_be_demanded_and_a_threshold_set(project):
    text = project.read("c.py").decode()
    value = re.search(r"probability = (\S+)", text)[1]
    change(project, "c.py", f"probability = {value}", "probability := 0.5")
    change(
        project,
        "pyproject.toml",
        "seed = 0",
        "require_reason = true\nmax_failure_probability = 0.1",
    )
    code, kinds, message = check(project)
    assert (code, [kind for kind, _, _ in kinds]) == (1, ["unjustified"])
    assert "is set by hand without a reason" in message
    change(project, "c.py", "probability := 0.5", "probability := 0.5  ! ; FMEA-112")
    code, kinds, message = check(project)
    assert (code, [kind for kind, _, _ in kinds]) == (1, ["over_threshold"])
    assert "above the max_failure_probability of 0.1" in message


def test_of_a_controller_that_is_gone_nothing_else_is_said(project):
    (project.folder / "c.py").unlink()
    outcome = project.run("check")
    assert outcome.code == 1
    assert "c.py: gone" in outcome.out
    assert "gives it" not in outcome.err


def test_a_block_that_is_gone_is_missing_and_comes_back(project):
    text = project.read("c.py").decode()
    block = re.search(r"(?:    # \|.*\n)+", text)[0]
    change(project, "c.py", block, "")
    code, kinds, _ = check(project)
    assert (code, kinds) == (1, [("missing", "c.py", line_of(project, "def reach():"))])
    outcome = project.run("refresh")
    assert outcome.code == 0, outcome.err
    assert "values recomputed from the cached trace" in outcome.err
    assert project.read("c.py").decode() == text


def test_next_lines_that_are_gone_are_missing_and_come_back(project):
    text = project.read("c.py").decode()
    change(project, "c.py", re.search(r"    # \|   next = home.*\n", text)[0], "")
    code, kinds, message = check(project)
    assert (code, [kind for kind, _, _ in kinds]) == (1, ["missing"])
    assert "the `next` lines of reach are gone" in message
    assert project.run("refresh").code == 0
    assert project.read("c.py").decode() == text


def test_a_renamed_controller_keeps_its_pins_and_the_options_of_its_run(project):
    text = project.read("c.py").decode()
    value = re.search(r"probability = (\S+)", text)[1]
    change(project, "c.py", f"probability = {value}", "probability := 2e-07  ! ; FMEA-112")
    (project.folder / "c.py").rename(project.folder / "d.py")
    outcome = project.run("refresh", "d.py")
    assert outcome.code == 0, outcome.err
    assert "c.py: forgotten" in outcome.err
    assert f"probability := 2e-07  ! computed {value}; FMEA-112" in project.read("d.py").decode()
    assert check(project)[:2] == (0, [])


def test_a_renamed_controller_that_cannot_run_is_not_forgotten(project):
    text = project.read("c.py").decode()
    (project.folder / "c.py").unlink()
    project.write("d.py", text + "reach(\n")
    outcome = project.run("refresh", "d.py")
    assert outcome.code == 2
    assert "c.py: not forgotten (d.py may be its new name)" in outcome.err
    assert list(json.loads(project.read("tracerisk.lock"))["controllers"]) == ["c.py"]
    project.write("d.py", text)
    outcome = project.run("refresh", "--json", "d.py")
    assert outcome.code == 0
    assert json.loads(outcome.out)["forgotten"] == [str(project.folder / "c.py")]
    assert list(json.loads(project.read("tracerisk.lock"))["controllers"]) == ["d.py"]
    assert check(project)[:2] == (0, [])


def test_a_component_omitted_by_its_name_stays_when_its_function_becomes_a_helper(project):
    text = project.read("c.py").decode()
    section = re.search(
        r"    # \| @Component \{\n    # \|   name = (\S+)\n(?:    # \|   .*\n)+", text
    )
    short = f"    # | @Component := omit {{  ! why\n    # |   name = {section[1]}\n"
    change(project, "c.py", section[0], short)
    change(project, "pyproject.toml", "seed = 0", 'seed = 0\nhelpers = ["reach"]')
    for _ in range(2):
        assert project.run("refresh").code in (0, 1)
        assert project.run("check").code in (0, 1)
    assert short in project.read("c.py").decode()


def test_an_edit_within_an_omitted_component_is_one_for_check_and_refresh(project):
    change(project, "c.py", "@Component {", "@Component := omit {  ! why")
    assert project.run("refresh").code == 0
    assert check(project)[:2] == (0, [])
    value = re.search(r"omit \{.*?probability = (\S+)", project.read("c.py").decode(), re.DOTALL)[1]
    change(project, "c.py", f"probability = {value}", "probability = 1.2e-07")
    code, kinds, message = check(project)
    assert (code, {kind for kind, _, _ in kinds}) == (3, {"edited"})
    assert f"is 1.2e-07, was written as {value}" in message
    assert project.run("refresh").code == 3
    assert project.run("refresh", "--discard-edits").code == 0
    assert f"probability = {value}" in project.read("c.py").decode()


def test_a_renamed_function_keeps_its_block_and_the_pins_in_it(project):
    text = project.read("c.py").decode()
    value = re.search(r"probability = (\S+)", text)[1]
    change(project, "c.py", f"probability = {value}", "probability := 2e-07  ! ; FMEA-112")
    change(project, "c.py", "def reach():", "def stretch():")
    change(project, "c.py", "\nreach()\n", "\nstretch()\n")
    code, kinds, message = check(project)
    assert code == 1
    assert {kind for kind, _, _ in kinds} == {"stale", "orphaned"}
    assert "the function of the block `reach` is called `stretch` now" in message
    outcome = project.run("refresh")
    assert outcome.code == 0, outcome.err
    after = project.read("c.py").decode()
    assert "name = stretch" in after
    assert "name = reach" not in after
    assert f"probability := 2e-07  ! computed {value}; FMEA-112" in after
    assert check(project)[:2] == (0, [])
    assert "\nc.py: unchanged" in project.run("refresh").err


# That a run keeps the options that were given with it, a refresh below shows.
@pytest.mark.parametrize("where", ["settings", pytest.param("option", marks=pytest.mark.slow)])
def test_other_hardware_data_change_values_without_a_run(project, where):
    shipped = "components:\n  motor: {quantity: 7, probability: {value: 1e-7, per: minute}, twin: {joints: '*'}}\n"
    project.write("arm.yaml", shipped)
    given = () if where == "settings" else ("--hardware", "arm.yaml")
    if where == "settings":
        project.write("pyproject.toml", '[tool.tracerisk]\nhardware = "arm.yaml"\n')
    assert project.run("run", "c.py", *given, "-q", "--discard-edits").code == 0
    assert check(project)[:2] == (0, [])
    change(project, "arm.yaml", "1e-7", "1e-6")
    code, kinds, message = check(project)
    assert (code, kinds) == (1, [("stale", "c.py", 1)])
    assert "arm.yaml has changed" in message
    assert "/arm.yaml" not in message, "it is named from the root"
    outcome = project.run("refresh")
    assert outcome.code == 0, outcome.err
    assert "values recomputed from the cached trace" in outcome.err
    assert check(project)[:2] == (0, [])


def without_wear(exposure):
    exposure["wear"] = [0.0 for _ in exposure["wear"]]


def without_starts(exposure):
    exposure["starts"] = 0


def half_in_use(exposure):
    for key in ("active_s", "moving_s", "holding_s"):
        exposure[key] /= 2.0


def with_smaller_exposures(project, smaller):
    """Change the exposures of the kept trace; return its file, and what that held before."""
    (cached,) = (project.folder / ".tracerisk_cache").glob("*.json")
    honest = cached.read_bytes()
    trace = json.loads(honest)
    for visit in trace["visits"]:
        for exposure in visit["exposures"].values():
            smaller(exposure)
    cached.write_text(json.dumps(trace))
    return cached, honest


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("smaller", [without_wear, without_starts, half_in_use])
def test_no_values_come_from_a_kept_trace_that_is_not_the_one_of_the_lock(project, smaller):
    """A trace by which the robot has less to bear, with an edit that asks for new values."""
    hardware = "components:\n  motor: {quantity: 7, probability: {value: %s, per: minute}, twin: {joints: '*'}}\n"
    project.write("arm.yaml", hardware % "1e-7")
    project.write("pyproject.toml", '[tool.tracerisk]\nhardware = "arm.yaml"\n')
    assert project.run("run", "c.py", "-q", "--discard-edits").code == 0
    cached, honest = with_smaller_exposures(project, smaller)
    project.write("arm.yaml", hardware % "2e-7")
    outcome = project.run("refresh")
    assert outcome.code == 0, outcome.err
    assert "the trace kept here is not the one of tracerisk.lock" in outcome.err
    assert cached.read_bytes() == honest, "it was run anew"
    assert check(project)[:2] == (0, [])


def test_a_refresh_with_nothing_to_mend_runs_anew_what_is_not_the_run_of_the_lock(project):
    cached, honest = with_smaller_exposures(project, half_in_use)
    outcome = project.run("refresh")
    assert outcome.code == 0, outcome.err
    assert "the trace kept here is not the one of tracerisk.lock" in outcome.err
    assert cached.read_bytes() == honest


def better_verdict(trace):
    trace["verdict"]["coverage"]["ran"] += 1


def another_digest(trace):
    trace["digest"] = "0" * 64


def no_digest(trace):
    del trace["digest"]


@pytest.mark.parametrize("edit", [better_verdict, another_digest, no_digest])
def test_a_verdict_or_a_digest_of_the_run_that_was_edited_is_found(project, edit):
    lock = json.loads(project.read("tracerisk.lock"))
    edit(lock["controllers"]["c.py"]["trace"])
    project.write("tracerisk.lock", json.dumps(lock))
    code, kinds, message = check(project)
    assert (code, kinds) == (1, [("stale", "c.py", 1)])
    assert "is not as tracerisk wrote it" in message


def test_other_tolerances_of_the_outcome_come_into_the_lock_without_a_run(project):
    change(project, "pyproject.toml", "seed = 0\n", "seed = 0\noutcome_place_mm = 5.0\n")
    code, kinds, message = check(project)
    assert (code, kinds) == (1, [("stale", "c.py", 1)])
    assert "setting outcome_place_mm was 2, is 5" in message
    source = project.read("c.py")
    outcome = project.run("refresh")
    assert "values recomputed from the cached trace" in outcome.err
    assert project.read("c.py") == source
    (entry,) = json.loads(project.read("tracerisk.lock"))["controllers"].values()
    assert entry["trace"]["outcome"]["tolerances"]["place_m"] == 0.005
    assert check(project)[:2] == (0, [])


def test_what_an_edited_lock_says_of_a_verdict_is_not_repeated(project):
    lock = json.loads(project.read("tracerisk.lock"))
    better_verdict(lock["controllers"]["c.py"]["trace"])
    # A version that is another one by the same hand does not hide that it was edited.
    lock["controllers"]["c.py"]["inputs"]["settings"]["tracerisk"] += ".1"
    project.write("tracerisk.lock", json.dumps(lock))
    said = project.run("check").out
    assert said.startswith("c.py: verdict unknown")
    assert "complete" not in said
    assert "is not as tracerisk wrote it" in said


def test_a_check_that_passes_says_what_was_set_by_hand_and_given_to_the_run(project):
    text = project.read("c.py").decode()
    value = re.search(r"probability = (\S+)", text)[1]
    change(project, "c.py", f"probability = {value}", "probability := 1e-12")
    passed = project.run("check")
    assert passed.code == 0
    assert (
        "c.py: 1 value is set by hand, 1 without a reason; `tracerisk overrides c.py` lists them"
        in passed.err
    )
    assert "given on the command line" not in passed.err
    assert project.run("run", "c.py", "-q", "--", "--quick").code == 0
    passed = project.run("check", "--json")
    assert passed.code == 0
    assert json.loads(passed.out)["verdicts"][0]["notes"][1:] == [
        "its last run was given on the command line, beside the settings: args = ['--quick']"
    ]


def test_a_refresh_uses_the_options_of_the_last_run_again(project):
    project.write("cell.yaml", "name: cell\ntitle: A cell\n")
    assert project.run("run", "c.py", "--seed", "7", "--scene", "cell.yaml", "-q").code == 0
    change(project, "helper.py", "0.2", "0.25")
    assert project.run("refresh", "-q").code == 0
    assert json.loads(project.read("tracerisk.lock"))["controllers"]["c.py"]["inputs"]["given"] == {
        "scene": "cell.yaml",
        "seed": 7,
    }
    assert check(project)[:2] == (0, [])
    project.write("cell.yaml", "name: cell\ntitle: Another cell\n")
    assert "cell.yaml has changed since the last run" in check(project)[2]


def test_a_setting_of_another_version_in_the_lock_is_passed_over(project):
    lock = json.loads(project.read("tracerisk.lock"))
    lock["controllers"]["c.py"]["inputs"]["given"] = {"gravity": 9.81}
    project.write("tracerisk.lock", json.dumps(lock))
    assert check(project)[:2] == (0, [])


def test_a_second_refresh_does_nothing_and_one_without_a_kept_trace_runs(project):
    change(project, "c.py", "factor(1.0)", "factor(0.5)")
    first = project.run("refresh")
    assert "c.py: changed (c.py has changed)" in first.err
    before = project.read("c.py"), project.read("tracerisk.lock")
    assert project.run("refresh").err == (
        "c.py: complete, 2 of 2 functions with commands ran\n"
        "c.py: unchanged (nothing that it depends on has changed)\n"
    )
    for path in (project.folder / ".tracerisk_cache").glob("*.json"):
        path.unlink()
    assert "its trace is not kept here" in project.run("refresh", "--fresh").err
    assert (project.read("c.py"), project.read("tracerisk.lock")) == before


def test_a_hand_edit_stops_a_refresh_until_it_is_accepted(project):
    value = re.search(r"probability = (\S+)", project.read("c.py").decode())[1]
    change(project, "c.py", f"probability = {value}", "probability = 2e-07")
    before = project.read("c.py")
    outcome = project.run("refresh")
    assert outcome.code == 3
    assert project.read("c.py") == before
    assert project.run("refresh", "--accept-edits").code == 0
    assert f"probability := 2e-07  ! computed {value}".encode() in project.read("c.py")


def test_blocks_that_the_lock_does_not_know_are_unknown(project):
    (project.folder / "tracerisk.lock").unlink()
    assert check(project, "c.py")[:2] == (1, [("unknown", "c.py", 1)])
    outcome = project.run("check")
    assert outcome.code == 1
    assert "c.py:1: unknown: tracerisk.lock knows nothing of its 2 risk blocks" in outcome.out


def test_a_malformed_block_is_an_error_beside_what_is_found_of_others(project):
    project.write("d.py", "def f():\n    # | RiskAnnotation\n    # | @Function {\n    pass\n")
    outcome = project.run("check", "c.py", "d.py")
    assert outcome.code == 2
    assert "d.py:3: the `@Function {` of this line has no `}`" in outcome.out
    assert "2 controllers checked, 1 to mend" in outcome.err


def test_no_simulator_is_imported(project):
    script = (
        "import sys\nfrom tracerisk.cli import main\nassert main(['check', 'c.py']) == 0\n"
        "print(sorted({'mujoco', 'libcst', 'numpy', 'dm_control'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=project.folder,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_without_a_file_the_locks_of_packages_below_count_too(project):
    # A ROS workspace: the packages are below the repository's top, each with its own lock.
    files = list(project.folder.iterdir())
    package = project.folder / "pick"
    package.mkdir()
    for each in files:
        each.rename(package / each.name)
    assert check(project)[:2] == (0, [])
    (package / "helper.py").write_text("REACH = 0.3\n")
    assert check(project)[:2] == (1, [("stale", "pick/c.py", 1)])
    assert check(project, ".")[:2] == (1, [("stale", "pick/c.py", 1)])
    assert project.run("overrides").code == 0
    before = project.files()
    assert project.run("refresh", "--check").code == 1
    assert project.files() == before, "it says what would be refreshed, and writes nothing"


def test_within_a_folder_of_a_project_the_lock_above_counts(project, example_in):
    (project.folder / "launch").mkdir()
    within = example_in(project.folder / "launch")
    assert check(within)[:2] == (0, [])
    change(project, "helper.py", "0.2", "0.3")
    assert check(within)[0] == 1


def test_a_folder_stands_for_all_that_its_lock_knows(project):
    assert check(project, ".")[:2] == (0, [])
    change(project, "helper.py", "0.2", "0.3")
    assert check(project, ".")[1] == [("stale", "c.py", 1)]
    (project.folder / "empty").mkdir()
    outcome = project.run("check", "empty")
    assert outcome.code == 2
    assert "empty: no tracerisk.lock in or below it knows a controller" in outcome.err


def test_a_refresh_that_goes_wrong_prints_all_that_did(project, monkeypatch):
    from tracerisk.cli.authors import refresh
    from tracerisk.common.verdict import Reason, Verdict
    from tracerisk.pipeline.check.refresh import Refreshed

    reasons = [
        Reason("planning-failed", "faulted", "no plan 0"),
        Reason("planning-failed", "faulted", "no plan 1"),
        Reason("distro-assumed", "partial", "no plan 2"),
    ]
    done = Refreshed("kept", "c.py has changed", verdict=Verdict("faulted", tuple(reasons)))
    monkeypatch.setattr(refresh, "refresh_controller", lambda *_, **__: done)
    said = []
    monkeypatch.setattr(refresh, "note", lambda line, **_: said.append(line))
    monkeypatch.chdir(project.folder)
    options = Namespace(
        files=["c.py"], quiet=False, accept_edits=False, discard_edits=False, sandbox=None,
        check=False, diff=False, json=False, fresh=False,
    )  # fmt: skip
    monkeypatch.setattr(refresh.shared, "merge_policy", lambda _: None)
    assert refresh.run(options) == 1
    assert said[:3] == [
        "c.py: faulted: no plan 0; 0 of 0 functions with commands ran",
        "  faulted: no plan 1",
        "  partial: no plan 2",
    ]


def test_a_refresh_that_goes_wrong_keeps_the_blocks_of_a_good_run(project):
    change(project, "c.py", "\nhome()\n", '\nraise ValueError("no part")\n')
    before = {name: project.read(name) for name in ("c.py", "tracerisk.lock")}
    outcome = project.run("refresh", "c.py")
    assert outcome.code == 1
    assert project.read("c.py") == before["c.py"]
    lines = [line for line in outcome.err.splitlines() if line.startswith("c.py: ")]
    assert lines[0].startswith("c.py: faulted: the controller raised ValueError: no part")
    assert lines[1].startswith(
        "c.py: unchanged (c.py has changed): the blocks of its last good run"
    )
    assert len(lines) == 2
    assert check(project)[1] == [("stale", "c.py", 1)]
    said = project.run("check").out
    assert (
        "its last run wrote no blocks: faulted: the controller raised ValueError: no part" in said
    )
    assert "mend it, then `tracerisk refresh c.py`" in said
    change(project, "c.py", "no part", "no other part")
    assert "c.py has changed since the last run" in project.run("check").out
    change(project, "c.py", "no other part", "no part")
    first = project.run("check").out.splitlines()[0]
    assert first.startswith("c.py: complete, ")
    assert first.endswith(" (of the run behind the blocks, which is stale)")
    # A run that is asked for by name writes what it shows.
    assert project.run("run", "c.py").code == 1
    assert project.read("c.py") != before["c.py"]


def test_a_refresh_without_a_file_follows_a_controller_that_moved(project):
    (project.folder / "src").mkdir()
    (project.folder / "c.py").rename(project.folder / "src" / "c.py")
    outcome = project.run("refresh")
    assert outcome.code == 0, outcome.err
    assert "src/c.py: " in outcome.err
    assert set(json.loads(project.read("tracerisk.lock"))["controllers"]) >= {"src/c.py"}
    assert "c.py: forgotten (the lock knows it by its new name now)" in outcome.err


def test_the_first_line_gives_the_reason_that_makes_the_verdict(project):
    lock = json.loads(project.read("tracerisk.lock"))
    entry = lock["controllers"]["c.py"]
    verdict = entry["trace"]["verdict"]
    plain = {"function": "", "object": "", "time_s": None, "location": None, "accepted": ""}
    verdict["kind"] = "faulted"
    verdict["reasons"] = [
        {**plain, "code": "object-dropped", "verdict": "faulted", "words": "'cup' fell 90 mm"},
        {**plain, "code": "never-called", "verdict": "partial", "words": "go was not executed"},
    ]
    entry["digest"] = data_digest(entry)
    project.write("tracerisk.lock", json.dumps(lock))
    first = project.run("check").out.splitlines()[0]
    assert first == "c.py: faulted: 'cup' fell 90 mm; 2 of 2 functions with commands ran"


HOSE = """\
    # | @Component := {  ! the hose
    # |   name = hose
    # |   probability = 1e-06
    # |   quantity = 1
    # |   redundancy = false
    # | }
"""


def test_what_is_set_by_hand_in_a_function_that_a_run_reaches_no_more_is_named(project):
    head, home, rest = project.read("c.py").decode().partition("def home():\n")
    begin, component, tail = rest.partition("    # | @Component {")
    project.write("c.py", head + home + begin + HOSE + component + tail)
    assert project.run("refresh", "-q").code == 0
    assert project.run("check").code == 0
    change(project, "c.py", "\nreach()\nhome()\n", "\nreach()\n")
    assert project.run("refresh", "-q").code == 0
    assert b"hose" in project.read("c.py")
    code, kinds, message = check(project)
    assert (code, [kind for kind, _, _ in kinds]) == (1, ["moved"])
    assert (
        "what is set by hand in the block of home counts nothing: no `next` leads to it" in message
    )
