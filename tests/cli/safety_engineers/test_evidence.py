"""`tracerisk evidence`: failures tried on the twin, kept, resumed, merged, and in the blocks."""

import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path

import pytest

from tests.commands import ForkedWorkers
from tests.conftest import program
from tracerisk import api
from tracerisk.common.campaign import CampaignOptions
from tracerisk.common.evidence.cells import Cell, Evidence
from tracerisk.common.evidence.file import dump_evidence, merge_evidence, read_evidence
from tracerisk.errors import ScenarioError
from tracerisk.ros.scenario.file.scenario_reader import read_scenario

HARDWARE = """\
robot: panda
components:
  motor:
    failure_rate: {value: 1.0e-5, per: hour}
    twin: {joints: [panda_joint1]}
    quantity: 1
"""
SCENARIO = "success:\n  - {within_s: 100}\n"
GATHER = ("evidence", "controller.py", "--cells", "6", "-j", "1")


class Inline(Executor):
    """An executor that does what it is given at once, in this process."""

    def submit(self, function, /, *arguments, **named):
        future: Future = Future()
        future.set_result(function(*arguments, **named))
        return future


def settled(folder):
    folder.write("controller.py", QUICK[0])
    folder.write("one.yaml", HARDWARE)
    folder.write("mission.yaml", SCENARIO)
    folder.write(
        "pyproject.toml", '[tool.tracerisk]\nhardware = "one.yaml"\nscenario = "mission.yaml"\n'
    )
    return folder


QUICK: list[str] = []


@pytest.fixture(scope="module")
def gathered(tmp_path_factory, example_in):
    """A controller with its evidence, and the outcome of the command that gathered it."""
    from tests.conftest import quick_controller

    QUICK[:] = [quick_controller()]
    folder = settled(example_in(tmp_path_factory.mktemp("evidence")))
    return folder, folder.run(*GATHER, "--json")


def test_every_mode_and_function_is_tried(gathered):
    folder, outcome = gathered
    assert outcome.code == 0, outcome.err
    data = outcome.json
    assert (data["drawn"], data["declared"], data["complete"]) == (6, 6, True)
    assert {row["failure mode"] for row in data["rows"]} == {"dead", "jam"}
    assert all(int(row["cells"]) >= 3 for row in data["rows"])
    assert read_evidence(folder.folder / "tracerisk.evidence").keys() == {"controller.py"}


def test_a_joint_that_jams_on_its_way_does_not_arrive(gathered):
    folder, _ = gathered
    found = api.evidence(folder.folder / "controller.py")
    jammed = [each for each in found.cells if each.mode == "jam" and each.use == "moving"]
    assert jammed
    assert any(each.effect == "wrong_position" and each.told_by for each in jammed)
    # The scenario asks for nothing but an end in time.
    assert not any(each.fails for each in jammed)


def test_nothing_is_tried_twice_and_the_bytes_stay(gathered):
    folder, _ = gathered
    before = folder.read("tracerisk.evidence")
    outcome = folder.run(*GATHER)
    assert outcome.code == 0, outcome.err
    assert folder.read("tracerisk.evidence") == before
    assert "failures tried" in outcome.out
    assert not list((folder.folder / ".tracerisk_cache").glob("evidence-*"))


@pytest.mark.slow
def test_an_edit_of_a_failure_is_noticed_by_all_and_tried_again(gathered, tmp_path, example_in):
    whole, _ = gathered
    folder = example_in(tmp_path / "edited")
    shutil.copytree(whole.folder, folder.folder)
    settings = folder.read("pyproject.toml").decode()
    folder.write("pyproject.toml", settings + "evidence = true\n")
    # The settings that a campaign has taken are older than this one: it changes no cell.
    assert folder.run(*GATHER, "-q").code == 0
    assert folder.run("run", "controller.py", "-q").code == 0
    text = folder.read("tracerisk.evidence").decode()
    assert folder.run("check", "controller.py").code == 0
    line = next(each for each in text.splitlines() if '"effect": "wrong_position"' in each)
    folder.write(
        "tracerisk.evidence",
        text.replace(line, line.replace('"effect"', '"fails": true, "effect"')),
    )

    checked = folder.run("check", "controller.py")
    assert checked.code == 3
    assert "tracerisk.evidence: edited: the failure of panda_joint1 (" in checked.out
    shown = folder.run("evidence", "controller.py", "--show")
    assert "the file was edited: the failure of panda_joint1 (" in shown.out
    solved = folder.run("solve", "controller.py")
    assert "warning: tracerisk.evidence was edited: the failure of" in solved.err
    again = folder.run("run", "controller.py", "--check")
    assert "figures take no evidence, though the settings ask for it: it was edited" in again.err
    merged = folder.run("evidence", "merge", "tracerisk.evidence", "-o", "all")
    assert merged.code == 2
    assert "was edited" in merged.err

    done = folder.run(*GATHER)
    assert done.code == 0, done.err
    said = " ".join(done.err.split())
    assert "tracerisk.evidence was edited: the failure of panda_joint1 (" in said
    assert "left out and tried again" in said
    assert folder.read("tracerisk.evidence").decode() == text
    assert folder.run("check", "controller.py").code == 0


# What is claimed is left to its batch (tests/pipeline/evidence/test_fate.py), and a worker that
# dies loses nothing (test_interrupted.py).
@pytest.mark.slow
def test_two_workers_share_the_cells_and_what_none_of_them_had_is_run_after_all(
    gathered, tmp_path, example_in, monkeypatch
):
    whole, _ = gathered
    folder = settled(example_in(tmp_path / "two"))
    from tracerisk.pipeline.evidence import campaign, workers

    def with_one_taken(**named):
        """Return a folder of claims in which one is that of a worker which died."""
        found = tempfile.mkdtemp(**named)
        Path(found, "0").touch()
        return found

    class Folders:
        mkdtemp = staticmethod(with_one_taken)

    monkeypatch.setattr(campaign, "tempfile", Folders)
    monkeypatch.setattr(workers, "_CONTEXT", ForkedWorkers())
    api.gather_evidence(folder.folder / "controller.py", options=CampaignOptions(jobs=2), cells=6)
    assert folder.read("tracerisk.evidence") == whole.read("tracerisk.evidence")


def test_a_file_of_the_version_without_digests_is_taken_and_that_is_said(
    gathered, tmp_path, example_in
):
    whole, _ = gathered
    folder = example_in(tmp_path / "old")
    shutil.copytree(whole.folder, folder.folder)
    new = folder.read("tracerisk.evidence")
    without = re.sub(rb' +"digest": "\w+",\n|, "digest": "\w+"', b"", new)
    old = without.replace(b": 3,", b": 1,", 1)
    assert b"digest" not in old
    folder.write("tracerisk.evidence", old)
    assert "edits of it do not show" in folder.run("evidence", "controller.py", "--show").out
    merged = folder.run("evidence", "merge", "tracerisk.evidence", "-o", "all")
    assert (merged.code, folder.read("all")) == (0, new)
    assert "edits do not show" in " ".join(merged.err.split())
    done = folder.run(*GATHER)
    assert (done.code, folder.read("tracerisk.evidence")) == (0, new)
    assert "of an earlier version, which shows no edits" in " ".join(done.err.split())


@pytest.mark.slow
def test_shards_and_a_resumed_campaign_give_the_same_bytes(gathered, tmp_path, example_in):
    whole, _ = gathered
    first, second = (settled(example_in(tmp_path / each)) for each in ("a", "b"))
    done = first.run(*GATHER, "--shard", "1/2", "-q")
    assert done.code == 0, done.err
    part = (first.folder / "tracerisk.evidence").read_bytes()
    assert 0 < len(read_evidence(first.folder / "tracerisk.evidence")["controller.py"].cells) < 12
    # A second machine with any executor does the rest.
    api.gather_evidence(
        second.folder / "controller.py",
        options=CampaignOptions(shard=(2, 2), executor=Inline()),
        cells=6,
    )
    merged = merge_evidence([each.folder / "tracerisk.evidence" for each in (first, second)])
    assert dump_evidence(merged).encode() == whole.read("tracerisk.evidence")
    out = first.run(
        *("evidence", "merge", "tracerisk.evidence", "../b/tracerisk.evidence", "-o", "all")
    )
    assert out.code == 0, out.err
    assert first.read("all") == whole.read("tracerisk.evidence")
    assert part != first.read("all")


@pytest.mark.slow
def test_a_killed_campaign_goes_on_from_its_journal(gathered, tmp_path, example_in):
    whole, _ = gathered
    killed = example_in(tmp_path / "killed")
    shutil.copytree(whole.folder, killed.folder)
    path = killed.folder / "tracerisk.evidence"
    lines = [line.strip().rstrip(",") for line in path.read_text().splitlines()]
    cells = [line for line in lines if line.startswith('{"component"')]
    from tracerisk.pipeline.evidence.campaign import plan_campaign

    journal = plan_campaign(killed.folder / "controller.py", cells=6).journal
    path.unlink()
    # Of the last cell the kill left the beginning alone.
    journal.write_text("\n".join([*cells[:-1], cells[-1][:40]]))
    assert killed.run(*GATHER, "-q").code == 0
    assert path.read_bytes() == whole.read("tracerisk.evidence")


def test_blocks_take_evidence_where_the_settings_ask(gathered, tmp_path, example_in):
    whole, _ = gathered
    folder = example_in(tmp_path / "on")
    shutil.copytree(whole.folder, folder.folder)
    assert folder.run("run", "controller.py", "-q").code == 0
    without = folder.read("controller.py").decode()
    assert "with evidence" not in without
    text = folder.read("pyproject.toml").decode()
    folder.write("pyproject.toml", text + "evidence = true\n")
    stale = folder.run("check", "controller.py")
    assert stale.code == 1
    assert "tracerisk.evidence has changed" in stale.out + stale.err
    done = folder.run("refresh", "controller.py")
    assert done.code == 0, done.err
    source = folder.read("controller.py").decode()
    assert "with evidence" in source
    # No failure of it misses the mission that the scenario declares, but three tries say little.
    was, now = (float(re.search(r"probability = (\S+)", text)[1]) for text in (without, source))
    assert now == pytest.approx((1.0 - 0.05 ** (1 / 3)) * was, rel=1e-3)
    assert folder.run("check", "controller.py").code == 0
    solved = folder.run("solve", "controller.py")
    assert "blocks take evidence" in solved.err
    explained = folder.run("run", "controller.py", "--check", "--explain", "act", "-q")
    assert "evidence" in folder.run("run", "controller.py", "--check").out
    assert " c " in explained.out
    assert folder.run("report", "controller.py", "-o", "out.html", "-q").code == 0
    page = folder.read("out.html").decode()
    assert "The figures of this report count only failures that end the mission." in page
    assert 'class="effect-wrong_position"' in page
    assert "In use, but harmless" in page
    # Evidence of another mission is stale.
    folder.write("mission.yaml", "success:\n  - {within_s: 99}\n")
    assert folder.run("refresh", "controller.py").code == 0
    assert "with evidence" not in folder.read("controller.py").decode()
    assert "another version" in folder.run("check", "controller.py").out


@pytest.mark.slow
def test_another_campaign_keeps_what_lies_in_its_intervals(gathered, tmp_path, example_in):
    whole, _ = gathered
    other = example_in(tmp_path / "other")
    shutil.copytree(whole.folder, other.folder)
    path = other.folder / "tracerisk.evidence"
    first = read_evidence(path)["controller.py"]
    assert other.run(*GATHER, "--seed", "7", "-q").code == 0
    second = read_evidence(path)["controller.py"]
    assert second.before == first.shares()
    assert second.shares() == first.shares()
    few = ("evidence", "controller.py", "--cells", "1", "-j", "1")
    assert other.run(*few, "--seed", "7", "--fresh", "-q").code == 0
    assert not read_evidence(path)["controller.py"].before


def test_the_table_is_written_as_csv_and_markdown(gathered):
    folder, _ = gathered
    outcome = folder.run(
        "evidence", "controller.py", "--show", "--csv", "t.csv", "--markdown", "t.md"
    )
    assert outcome.code == 0, outcome.err
    rows = folder.read("t.csv").decode().splitlines()
    assert rows[0].startswith("component,failure mode,failure cause,function,local effect,end")
    assert "severity" in rows[0]
    assert all(line.startswith("motor,") for line in rows[1:])
    assert "| motor | jam |" in folder.read("t.md").decode()
    assert "- over within 100 s" in folder.read("t.md").decode()


@pytest.mark.slow
def test_failures_that_end_the_mission_are_replayed(gathered, tmp_path, example_in):
    whole, _ = gathered
    folder = example_in(tmp_path / "replays")
    shutil.copytree(whole.folder, folder.folder)
    # Nothing is declared: a joint that jams keeps the run from what it reached without.
    folder.write("pyproject.toml", '[tool.tracerisk]\nhardware = "one.yaml"\n')
    done = folder.run(*GATHER, "--replays", "pages")
    assert done.code == 0, done.err
    found = read_evidence(folder.folder / "tracerisk.evidence")["controller.py"]
    matter = {(each.unit, each.mode) for each in found.cells if each.fails}
    pages = sorted(each.name for each in (folder.folder / "pages").iterdir())
    assert {"index.html", "without.html", "beside.html"} < set(pages)
    shown = [each for each in pages if each.startswith("panda_joint1-")]
    assert {tuple(each.split("-")[:2]) for each in shown} == matter
    index = folder.read("pages/index.html").decode()
    for name in [*shown, "without.html"]:
        assert f'href="{name}"' in index
        text = folder.read(f"pages/{name}").decode()
        assert 'href="index.html"' in text
        assert "replay" in text
        assert (f'href="beside.html#{name}"' in text) == (name != "without.html")
        assert f'"{name}"' in folder.read("pages/beside.html").decode()
    assert f"{len(shown)} replays, and index.html, in pages" in done.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("controller.py", "--shard", "3/2"), "expected I/N"),
        (("controller.py", "--cells", "0"), "allowed: 1 to"),
        (("controller.py", "--cells", "1000000"), "allowed: 1 to"),
        (("controller.py", "-o", "x"), "goes with `evidence merge`"),
        (("controller.py", "--show", "--replays", "x"), "does not go with --show"),
        ((*GATHER[1:], "--replays", "one.yaml"), "is a file; name a folder"),
        (("merge",), "name the files"),
        (("merge", "nothing.evidence"), "does not exist"),
        (("other.py", "--show"), "other.py"),
    ],
)
def test_what_is_asked_wrongly_is_said(gathered, arguments, message):
    folder, _ = gathered
    outcome = folder.run("evidence", *arguments)
    assert outcome.code == 2
    assert message in outcome.err


def test_a_time_in_which_no_failure_was_tried_is_said_in_the_place_of_an_empty_table(example):
    outcome = settled(example).run(*GATHER, "--time", "0.01")
    assert outcome.code == 0
    assert "no failure was tried: the time was over after the run without one" in outcome.err
    assert "6 are to be drawn" in outcome.err
    assert outcome.out == ""


def test_a_controller_without_evidence_is_said(tmp_path, example, quick):
    example.write("controller.py", quick())
    outcome = example.run("evidence", "controller.py", "--show")
    assert outcome.code == 2
    assert "holds no evidence of controller.py" in outcome.err


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("{object: 3}", "object"),
        ("{tube: x}", "expected exactly one of"),
        ("{object: a, called: /b}", "expected exactly one of"),
        ("{object: a, at: [1, 2]}", "at"),
        ("{joints: {}}", "expected joints by name"),
        ("{visited: place, times: 0}", "times"),
        ("{within_s: -1}", "within_s"),
        ("{sent: /a, within: 3}", "within"),
    ],
)
def test_a_malformed_success_is_named_with_its_line(tmp_path, entry, message):
    path = Path(tmp_path, "s.yaml")
    path.write_text(f"success:\n  - {entry}\n")
    with pytest.raises(ScenarioError, match=message) as raised:
        read_scenario(path)
    assert raised.value.location is not None
    assert raised.value.location.line == 2


def test_diff_says_what_a_change_did_to_failures(repository, quick):
    repository.write("controller.py", quick())
    repository.write("one.yaml", HARDWARE)
    repository.write("pyproject.toml", '[tool.tracerisk]\nhardware = "one.yaml"\n')
    assert repository.run("run", "controller.py", "-q").code == 0
    cells = [
        Cell(
            *("motor", "panda_joint1", "jam", float(at), "moving", "act", True, float(at)),
            states_s=(float(at), 0.0, 0.0),
        )
        for at in range(20)
    ]
    before = Evidence("f", "panda", 0, 20, (), tuple(cells))
    reported = [replace(each, told_after_s=0.4, told_by="path_cut", fails=True) for each in cells]
    after = replace(before, cells=tuple(reported))
    repository.write("tracerisk.evidence", dump_evidence({"controller.py": before}))
    repository.git("add", "-A")
    repository.git("commit", "-qm", "before")
    repository.write("controller.py", repository.read("controller.py").decode() + "\n# more\n")
    repository.write("tracerisk.evidence", dump_evidence({"controller.py": after}))
    outcome = repository.run("diff")
    assert outcome.code == 0, outcome.err
    said = " ".join(outcome.out.split())
    assert "a failure of motor (jam) is now reported after 0.4 s, before: never" in said
    assert "now ends the mission in 20 of 20 tries, before: 0 of 20" in said
    assert "the run showed" not in said
    text = repository.read("tracerisk.evidence").decode()
    repository.write("tracerisk.evidence", text.replace('"fails": true, ', "", 1))
    said = " ".join(repository.run("diff").out.split())
    assert "the evidence was edited (now): the failure of panda_joint1 (jam) at 0 s" in said


HOSTILE = {
    "hangs": "for _ in iter(int, 1): pass",
    "dies": "import os; os.kill(os.getpid(), 9)",
    "exits": "import os; os._exit(3)",
    "raises": "raise RuntimeError('no way')",
    "forks": "import os; os.fork()",
    "fills the disk": "open('junk', 'wb').write(b'0' * 50_000_000)",
}


@pytest.mark.parametrize(
    "what",
    [each if each == "dies" else pytest.param(each, marks=pytest.mark.slow) for each in HOSTILE],
)
def test_what_a_controller_does_when_a_part_fails_ends_its_own_cell_alone(what, example, quick):
    source = quick(
        "import rospy",
        "before = arm.get_current_joint_values()[0]",
        "arm.set_joint_value_target([before + 0.2, *arm.get_current_joint_values()[1:]])",
        "arm.go(wait=True)",
        "after = arm.get_current_joint_values()[0]",
        "if abs(after - before - 0.2) > 0.05:",
        f"    {HOSTILE[what]}",
    )
    example.write("controller.py", source)
    example.write("one.yaml", HARDWARE)
    example.write(
        "pyproject.toml", '[tool.tracerisk]\nhardware = "one.yaml"\nstall_limit_s = 1.5\n'
    )
    outcome = example.run("evidence", "controller.py", "--cells", "1", "-j", "1", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["complete"]
    found = api.evidence(example.folder / "controller.py")
    failed = [each for each in found.cells if each.fails]
    assert failed
    if what in ("hangs", "dies", "exits", "raises"):
        assert any(each.effect == "ended_badly" for each in failed)
    assert not (example.folder / "junk").exists()


@pytest.mark.parametrize(
    ("number", "is_afresh", "left"),
    [
        (signal.SIGKILL, False, 1),
        (signal.SIGTERM, False, 0),
        # It ends as by SIGTERM.
        pytest.param(signal.SIGINT, False, 0, marks=pytest.mark.slow),
        pytest.param(signal.SIGKILL, True, 1, marks=pytest.mark.slow),
        pytest.param(signal.SIGTERM, True, 0, marks=pytest.mark.slow),
        pytest.param(signal.SIGINT, True, 0, marks=pytest.mark.slow),
    ],
)
def test_a_killed_campaign_leaves_no_process_and_no_folder_of_its_workers(
    number, is_afresh, left, example, quick, tmp_path_factory
):
    kept = tmp_path_factory.mktemp("kept")
    example.write("controller.py", quick())
    example.write("one.yaml", HARDWARE)
    example.write("pyproject.toml", '[tool.tracerisk]\nhardware = "one.yaml"\n')

    def ours() -> set[str]:
        found = set()
        for each in Path("/proc").glob("[0-9]*/cwd"):
            try:
                if each.readlink() == example.folder:
                    found.add(each.parent.name)
            except OSError:
                continue
        return found

    environment = {**os.environ, "TMPDIR": str(kept)}
    command = program(environment, is_afresh=is_afresh)
    begun = subprocess.Popen(
        [*command, "evidence", "controller.py", "-j", "2", "-q"],
        cwd=example.folder,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    deadline = time.monotonic() + 120.0
    cells = "*/worker-*/tracerisk-cells-*"
    while len(list(kept.glob(cells))) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    assert len(ours()) >= 3
    # Where the command was forked, it is killed outright with the one who asked for it.
    begun.send_signal(number)
    begun.wait()
    deadline = time.monotonic() + 60.0
    while ours() and time.monotonic() < deadline:
        time.sleep(0.2)
    assert not ours()
    # That of the process which was killed outright is all that is left.
    assert len(list(kept.iterdir())) == left


def test_failures_that_pass_are_tried_as_the_description_says(gathered, tmp_path, example_in):
    folder = settled(example_in(tmp_path / "passing"))
    folder.write(
        "one.yaml",
        HARDWARE
        + "    modes:\n"
        + "      sticks: {fraction: 0.5, fault: jam, lasts_s: 0.1}\n"
        + "      jams: {fraction: 0.5, fault: jam}\n",
    )
    done = folder.run(*GATHER, "--dfmea", "dfmea.csv")
    assert done.code == 0, done.err
    cells = read_evidence(folder.folder / "tracerisk.evidence")["controller.py"].cells
    by_mode = {mode: [each for each in cells if each.mode == mode] for mode in ("jam", PASSING)}
    assert all(len([each for each in own if each.drawn]) >= 3 for own in by_mode.values())
    assert len(cells) == sum(map(len, by_mode.values()))
    # The joint goes on when it is free again: those that pass leave it where it should be.
    failed = {mode: sum(each.fails for each in own) for mode, own in by_mode.items()}
    off = {
        mode: sum("wrong_position" in each.effects for each in own) for mode, own in by_mode.items()
    }
    assert failed[PASSING] <= failed["jam"]
    assert off[PASSING] < off["jam"]
    assert "motor,act" in folder.read("dfmea.csv").decode()
    assert "intermittent" in folder.read("dfmea.csv").decode()


PASSING = "jam for 0.1 s"
