"""`tracerisk report --against REV` with both runs: where that of the revision comes from."""

import json
import re
import shutil
import subprocess

import pytest
from lxml import html

from tracerisk.cli import main

CACHE = ".tracerisk_cache"


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
    assert re.search(r"rest 1 of \d at .* is now \d+ mm from there", text)
    assert "before: joints[0] += 0.05 HEAD:controller.py:" in text
    assert "now: joints[0] += 0.25 controller.py:" in text
    (link,) = first.xpath(".//a/@href")
    line = document.get_element_by_id(link.removeprefix("#"))
    assert "joints[0] += 0.25" in line.text_content()
    gone, come = (
        ["".join(each.itertext()) for each in both.xpath(f".//{tag}")] for tag in ("del", "ins")
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


def test_what_is_not_kept_is_named_with_the_commands_that_bring_it(changed):
    earlier, data = without_earlier(changed)
    assert report() == 0
    document = page(changed)
    assert not document.xpath("//div[@class='side-by-side']")
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
