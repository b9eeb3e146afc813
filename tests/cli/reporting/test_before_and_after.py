"""`tracerisk report --against REV` with both runs: where that of the revision comes from."""

import json
import math
import re
import shutil
import subprocess

import pytest
from lxml import html

from tests.browser import emulate, violations
from tracerisk.cli import main

CACHE = ".tracerisk_cache"
SIDES = ("before", "now")


def git(folder, *words):
    command = ["git", "-c", "user.name=t", "-c", "user.email=t@t", *words]
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return done.stdout.decode().strip()


def turned(source):
    """The controller, which turns the joint further and goes home by another stop."""
    return source.replace("+= 0.05", "+= 0.25").replace(
        "    act(arm)\n    home(arm)\n", "    act(arm)\n    home(arm)\n    act(arm)\n"
    )


@pytest.fixture(scope="module")
def changed_in(tmp_path_factory, example_in, two_steps):
    """A repository whose controller was run, committed, changed, and run again."""
    example = example_in(tmp_path_factory.mktemp("changed"))
    example.write("cell/controller.py", two_steps)
    example.write("cell/pyproject.toml", '[tool.tracerisk]\nrobot = "panda"\n')
    git(example.folder, "init", "--quiet")
    words = ("--keep", "kept", "--trace", "kept/trace.json", "--quiet")
    assert example.run("run", "cell/controller.py", *words).code == 0
    git(example.folder, "add", "cell")
    git(example.folder, "commit", "--quiet", "-m", "one")
    source = example.read("cell/controller.py").decode()
    example.write("cell/controller.py", turned(source))
    assert example.run("run", "cell/controller.py", "--quiet").code == 0
    return example


@pytest.fixture
def changed(changed_in, example, monkeypatch):
    """A copy of it, to work in."""
    shutil.copytree(changed_in.folder, example.folder, dirs_exist_ok=True)
    monkeypatch.chdir(example.folder / "cell")
    return example


def report(*words):
    return main(["report", "controller.py", "--against", "HEAD", "-o", "out.html", "-q", *words])


def page(example):
    return html.document_fromstring(example.read("cell/out.html"))


def without_earlier(example):
    """Forget the replay of the earlier run; return its file and what it held."""
    found = list((example.folder / "cell" / CACHE).glob("*.replay"))
    assert len(found) == 2
    earlier = min(found, key=lambda path: path.stat().st_mtime_ns)
    data = earlier.read_bytes()
    earlier.unlink()
    return earlier, data


def test_both_runs_are_on_the_page_with_what_differs_and_the_changed_lines(changed):
    assert report() == 0
    document = page(changed)
    (both,) = document.xpath("//section[@id='difference']//div[@class='side-by-side']")
    assert [each.get("id") for each in both.xpath(".//canvas")] == ["side-before", "side-now"]
    versions = [each.text for each in both.xpath(".//*[@class='side-version']")]
    assert versions == ["HEAD", "working tree"]
    data = json.loads(document.get_element_by_id("side-by-side").text)
    assert {each["kind"] for each in data["stretches"]} >= {"same", "other", "now"}
    first = both.xpath(".//ol[@class='side-differences']/li")[0]
    text = " ".join(first.text_content().split())
    assert re.search(r"rest 1 of \d at .* is now \d+ mm (from there, at|higher|lower)", text)
    assert "before: joints[0] += 0.05 HEAD:controller.py:" in text
    assert "now: joints[0] += 0.25 controller.py:" in text
    (link,) = first.xpath(".//a/@href")
    line = document.get_element_by_id(link.removeprefix("#"))
    assert "joints[0] += 0.25" in line.text_content()
    gone, come = (
        ["".join(each.itertext()) for each in document.xpath(f"//section[@id='difference']//{tag}")]
        for tag in ("del", "ins")
    )
    assert gone == ["-     joints[0] += 0.05"]
    assert come == ["+     joints[0] += 0.25", "+     act(arm)"]
    assert "# |" not in both.text_content()
    first_bytes = changed.read("cell/out.html")
    assert report() == 0
    assert changed.read("cell/out.html") == first_bytes


def test_a_page_made_at_the_end_of_the_run_shows_both_too(changed):
    assert report() == 0
    later = page(changed).xpath("//div[@class='side-by-side']")[0]
    words = ("--report", "cell/out.html", "--against", "HEAD", "--quiet")
    assert changed.run("run", "cell/controller.py", *words).code == 0
    at_end = page(changed).xpath("//div[@class='side-by-side']")[0]
    assert len(at_end.xpath(".//canvas")) == len(later.xpath(".//canvas")) == 2
    assert at_end.text_content().count("rest 1 of") == later.text_content().count("rest 1 of")


def test_versions_have_the_names_that_were_given(changed):
    words = ("controller.py", "--against", "HEAD...HEAD", "-o", "out.html", "-q")
    assert main(["report", *words]) == 0
    assert "After: working tree." in page(changed).get_element_by_id("difference").text_content()
    git(changed.folder, "checkout", "-q", "-b", "change")
    git(changed.folder, "commit", "-q", "-a", "-m", "two")
    main_branch = git(changed.folder, "branch", "--list", "ma*").strip()
    words = ("controller.py", "--against", f"{main_branch}...HEAD", "-o", "out.html", "-q")
    assert main(["report", *words]) == 0
    document = page(changed)
    text = " ".join(document.get_element_by_id("difference").text_content().split())
    assert f"Before: {main_branch} (merge base). After: HEAD." in text
    versions = [each.text for each in document.xpath("//*[@class='side-version']")]
    assert versions == [f"{main_branch} (merge base)", "HEAD"]
    assert re.search(r"before: joints\[0\] \+= 0.05 [0-9a-f]{10}:controller.py:", text)


def test_a_run_that_cannot_be_made_is_refused_and_not_left_out(changed, monkeypatch, capsys):
    monkeypatch.setattr("tracerisk.common.dependencies.is_installed", lambda name: name != "mujoco")
    assert report("--run-against") == 2
    said = capsys.readouterr().err
    assert "running the earlier version (--run-against) needs the simulator; install it" in said


def test_where_the_present_run_is_not_kept_the_page_says_what_brings_it(changed):
    for path in (changed.folder / "cell" / CACHE).glob("*.json"):
        path.unlink()
    assert report() == 0
    document = page(changed)
    text = " ".join(document.get_element_by_id("difference").text_content().split())
    assert "The present run is not kept on this machine: a .tracerisk_cache that holds it" in text
    assert "No run is known" not in text
    assert [each.text for each in document.xpath("//del")] == ["-     joints[0] += 0.05"]


def test_a_figure_of_another_version_is_not_the_largest_text(changed):
    def headline():
        (figure,) = page(changed).xpath("//h1//span[contains(@class, 'headline-figure')]")
        return figure.get("class"), bool(page(changed).xpath("//*[@class='headline-odds']"))

    assert report() == 0
    assert headline() == ("headline-figure", True)
    changed.write("cell/controller.py", changed.read("cell/controller.py") + b"\nMORE = 1\n")
    assert report() == 0
    assert headline() == ("headline-figure is-apart", False)
    lead = page(changed).xpath("//section[@class='lead']")[0]
    text = " ".join(lead.text_content().split())
    assert "Of the blocks, which are not those of a run of these files: probability" in text
    # What changed comes before any figure.
    assert text.index("is not assessed as it is now") < text.index("Of the blocks")


def test_what_is_not_kept_is_named_with_the_commands_that_bring_it(changed):
    earlier, data = without_earlier(changed)
    assert report() == 0
    document = page(changed)
    assert not document.xpath("//div[@class='side-by-side']")
    # The changed lines need git alone.
    assert [each.text for each in document.xpath("//del")] == ["-     joints[0] += 0.05"]
    text = " ".join(document.get_element_by_id("difference").text_content().split())
    assert (
        "Both runs are not shown side by side. The run of HEAD is not kept on this machine. "
        "tracerisk report controller.py --against HEAD --run-against runs it once more, in a "
        "folder of its own; --against-recording PATH names a recording"
    ) in text
    # As an artefact has it: the cache of another machine, its replay, the folder of `--keep`.
    other = changed.folder / "artifact" / CACHE
    other.mkdir(parents=True)
    shutil.copy(earlier.with_suffix(".json"), other)
    (other / earlier.name).write_bytes(data)
    for path in (other.parent, other, other / earlier.name, changed.folder / "kept"):
        assert report("--against-recording", str(path)) == 0, path
        assert page(changed).xpath("//div[@class='side-by-side']"), path


def test_a_revision_is_run_again_in_a_folder_of_its_own(changed, capsys):
    assert report() == 0
    wanted = changed.read("cell/out.html")
    without_earlier(changed)
    before, branches = changed.files(), git(changed.folder, "worktree", "list")
    words = ("-o", "cell/out.html", "--against", "HEAD", "--run-against", "--quiet")
    outcome = changed.run("report", "cell/controller.py", *words)
    assert outcome.code == 0, outcome.err
    assert git(changed.folder, "worktree", "list") == branches
    left = changed.files()
    assert left.pop("cell/out.html") != b""
    assert left == {name: data for name, data in before.items() if name != "cell/out.html"}
    # It is kept, and is the run that was kept before.
    assert report() == 0
    assert changed.read("cell/out.html") == wanted


OPENED = """
const done = arguments[0];
tracerisk.bothRuns.ready.then(() => requestAnimationFrame(() => done("ready")), (e) => done(`${e}`));
"""
STATE = """
const { cursor, clocks, before, now } = tracerisk.bothRuns;
const arm = (replay) => replay.bodies.filter(({ kind }) => kind === "robot").map(({ name }) => name);
const places = (replay) => arm(replay).map((name) => replay.bodyPosition(name));
return {
  cursor: [cursor.time, cursor.end],
  clocks: [clocks.before.time, clocks.now.time],
  places: [places(before), places(now)],
  isOneCamera: before.camera === now.camera,
  text: [...document.querySelectorAll("[data-side-now]")].map((each) => each.textContent),
};
"""


@pytest.fixture(scope="module")
def opened(changed_in, chromium):
    """The page with both runs in a browser."""
    words = ("--against", "HEAD", "-o", "both.html", "--quiet")
    assert changed_in.run("report", "cell/controller.py", *words).code == 0
    chromium.get((changed_in.folder / "both.html").as_uri())
    assert chromium.execute_async_script(OPENED) == "ready"
    return chromium


def distance(state):
    """How far the links of one run are from those of the other at most [m]."""
    return max(math.dist(*pair) for pair in zip(*state["places"], strict=True))


def align(page, mode):
    selector = f'[data-side-mode="{mode}"]'
    page.execute_script("document.querySelector(arguments[0]).click()", selector)


@pytest.mark.slow
def test_one_cursor_moves_both_arms_in_step_and_in_plain_time(opened):
    # It begins at the first difference: there both are at rest, each in its own place.
    begun = opened.execute_script(STATE)
    assert begun["isOneCamera"]
    assert 0.0 < begun["cursor"][0] < begun["cursor"][1]
    assert distance(begun) > 0.02
    assert all(re.fullmatch(r"home, \d\.\d\d s of \d\.\d\d s", text) for text in begun["text"])
    # At the stop that both have, they are at one place, although at different times.
    data = opened.execute_script("return tracerisk.data('side-by-side')")
    (last_other,) = [each for each in data["stretches"] if each["kind"] == "other"][-1:]
    before, now = last_other["before"][1], last_other["now"][1]
    until = data["stretches"][: data["stretches"].index(last_other) + 1]
    along = sum(max(each[side][1] - each[side][0] for side in SIDES) for each in until)
    opened.execute_script("tracerisk.bothRuns.cursor.set(arguments[0], 'test')", along)
    home = opened.execute_script(STATE)
    assert home["clocks"] == pytest.approx([before, now], abs=0.01)
    assert distance(home) < 0.005
    align(opened, "time")
    plain = opened.execute_script(STATE)
    ends = [data["before"]["end"], opened.execute_script("return tracerisk.clock.end")]
    assert plain["clocks"] == pytest.approx([min(now, ends[0]), now], abs=0.01)
    assert plain["cursor"][1] == pytest.approx(max(ends), abs=0.01)
    align(opened, "step")
    assert opened.execute_script(STATE)["clocks"] == pytest.approx([before, now], abs=0.01)


@pytest.mark.slow
def test_keys_and_marks_go_from_difference_to_difference(opened):
    opened.execute_script("tracerisk.bothRuns.cursor.set(0, 'test')")
    canvas = opened.find_element("id", "side-now")
    canvas.send_keys("\ue00f")  # Page Down
    first = opened.execute_script(STATE)["cursor"][0]
    jump = opened.find_element("css selector", "[data-side-at='0']")
    assert jump.text == f"{first:.2f} s"
    canvas.send_keys("\ue010")  # End
    assert opened.execute_script(STATE)["cursor"][0] == opened.execute_script(STATE)["cursor"][1]
    opened.execute_script("arguments[0].click()", jump)
    assert opened.execute_script(STATE)["cursor"][0] == pytest.approx(first)
    # The page's own cursor is another one.
    assert opened.execute_script("return tracerisk.clock.time") == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("width", [1400, 400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_both_runs_are_accessible_and_fit_the_window(opened, scheme, width):
    emulate(opened, scheme)
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 0.25, "mobile": False}
    opened.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    found, report = violations(opened, scheme)
    assert not found, report
    assert opened.execute_script("return document.documentElement.scrollWidth") <= width
    tops = opened.execute_script(
        "return [...document.querySelectorAll('.side-run')]"
        ".map((each) => each.getBoundingClientRect().top)"
    )
    assert (tops[0] == tops[1]) == (width == 1400)
    opened.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--against-recording", "empty"], "no trace belongs to this recording of HEAD"),
        (["--against-recording", "controller.py"], "no trace belongs to this recording of HEAD"),
    ],
)
def test_a_recording_that_does_not_fit_is_refused(changed, capsys, words, message):
    (changed.folder / "cell" / "empty").mkdir()
    earlier, _ = without_earlier(changed)
    earlier.with_suffix(".json").unlink()
    assert report(*words) == 2
    assert message in capsys.readouterr().err


def test_the_options_go_with_a_revision(changed, capsys):
    assert main(["report", "controller.py", "-o", "out.html", "--run-against"]) == 2
    assert "--run-against goes with --against; add it" in capsys.readouterr().err


def test_what_a_helper_commands_leads_to_the_changed_line_that_called_it(
    example, quick, monkeypatch
):
    source = quick("turn(arm, 0.1)", "turn(arm, -0.1)").replace(
        "\ndef act(",
        "\ndef turn(arm, angle):\n    joints = arm.get_current_joint_values()\n"
        "    joints[0] += angle\n    arm.go(joints, wait=True)\n\n\ndef act(",
    )
    assert "def turn" in source
    example.write("controller.py", source)
    git(example.folder, "init", "--quiet")
    assert example.run("run", "controller.py", "--robot", "panda", "--quiet").code == 0
    git(example.folder, "add", "controller.py", "tracerisk.lock")
    git(example.folder, "commit", "--quiet", "-m", "one")
    text = example.read("controller.py").decode()
    example.write("controller.py", text.replace("turn(arm, 0.1)", "turn(arm, 0.3)"))
    assert example.run("run", "controller.py", "--robot", "panda", "--quiet").code == 0
    monkeypatch.chdir(example.folder)
    assert report() == 0
    document = html.document_fromstring(example.read("out.html"))
    first = document.xpath("//ol[@class='side-differences']/li")[0]
    said = " ".join(first.text_content().split())
    assert "now: turn(arm, 0.3) controller.py:" in said
