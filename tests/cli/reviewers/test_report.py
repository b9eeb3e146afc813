import hashlib
import json
import subprocess
import sys

import pytest
from lxml import html

from tracerisk.cli import main


def parsed(example, name="out.html"):
    return html.document_fromstring(example.read(name))


def sections(document):
    return document.xpath("//main/section/@id")


def reported(document, section):
    return " ".join(document.get_element_by_id(section).text_content().split())


def git(example, *words):
    command = ["git", "-c", "user.name=t", "-c", "user.email=t@t", *words]
    subprocess.run(command, cwd=example.folder, check=True, capture_output=True)


ALL = [
    "timeline", "brought-about", "functions", "touches", "chain", "fault-trees", "importance", "hardware",
    "findings", "coverage", "pins", "assumptions", "record", "source",
]  # fmt: skip
WITHOUT_A_RUN = [
    each for each in ALL if each not in ("timeline", "brought-about", "touches", "hardware")
]


@pytest.fixture
def kept(annotated, annotated_run, monkeypatch):
    """The folder of a run, with the trace that it keeps."""
    run, _ = annotated_run
    for path in (run.folder / ".tracerisk_cache").glob("*-*"):
        annotated.write(f".tracerisk_cache/{path.name}", path.read_bytes())
    monkeypatch.chdir(annotated.folder)
    return annotated


def test_a_run_writes_its_report(example, two_steps):
    example.write("controller.py", two_steps)
    outcome = example.run("run", "controller.py", "--report", "out.html", "--check", "--quiet")
    assert outcome.code == 1, outcome.err
    assert example.read("controller.py").decode() == two_steps
    document = parsed(example)
    assert sections(document) == ALL
    assert "Replay and timeline" in reported(document, "timeline")
    assert len(document.xpath("//*[@class='line block']")) > 20
    assert "act" in reported(document, "functions")


def test_a_report_is_made_of_what_a_run_has_kept(kept):
    before = kept.files()
    assert main(["report", "controller.py", "-o", "out.html", "--quiet"]) == 0
    document = parsed(kept)
    assert sections(document) == ALL
    assert "panda" in document.xpath("//*[@class='context']")[0].text_content()
    assert document.xpath("//canvas[@id='replay-canvas']")
    first = kept.read("out.html")
    assert main(["report", "controller.py", "--output", "out.html", "-q"]) == 0
    assert kept.read("out.html") == first
    assert {name: data for name, data in kept.files().items() if name != "out.html"} == before


def test_the_record_is_on_the_page_and_in_the_json(kept, capsys):
    assert main(["report", "controller.py", "-o", "out.html", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)["record"]
    document = parsed(kept)
    assert json.loads(document.get_element_by_id("record-data").text) == record
    shown = reported(document, "record")
    digests = {file["path"]: file["sha256"] for file in record["files"]}
    assert digests["controller.py"] == hashlib.sha256(kept.read("controller.py")).hexdigest()
    assert all(digest in shown for digest in digests.values())
    assert "panda, shipped with tracerisk" in shown
    assert record["verdict"] == ["complete, 3 of 3 functions with commands ran"]
    assert record["outcome"]
    assert record["assumptions"]
    assert str(kept.folder) not in json.dumps(record)


def test_the_band_of_known_error_factors_is_shown_without_being_asked_for(kept):
    kept.write(
        "hardware.yaml",
        "components:\n  electric_motor:\n    quantity: 7\n"
        "    probability: {value: 9.5e-08, per: minute, error_factor: 3}\n"
        '    twin: {joints: "*"}\n',
    )
    assert main(["report", "controller.py", "-o", "out.html", "-q"]) == 0
    assert "error factors" not in kept.read("out.html").decode()
    words = ["report", "controller.py", "-o", "out.html", "--hardware", "hardware.yaml", "-q"]
    assert main(words) == 0
    (lead,) = parsed(kept).xpath("//section[@class='lead']")
    assert "by the error factors of electric_motor in 2,000 samples" in lead.text_content()


def test_a_stale_trace_is_not_shown_and_the_page_says_why(kept):
    source = kept.read("controller.py").decode()
    kept.write("controller.py", source.replace("+= 0.05", "+= 0.06"))
    assert main(["report", "controller.py", "-o", "out.html", "-q"]) == 0
    document = parsed(kept)
    assert sections(document) == WITHOUT_A_RUN
    assert (
        "The trace of its last run is stale: controller.py has changed. "
        "After `tracerisk run controller.py` the page shows it; `--trace` names another."
    ) in reported(document, "coverage")


def test_of_a_run_that_is_not_kept_the_page_shows_what_the_lock_and_the_description_know(
    kept, monkeypatch
):
    (trace,) = (kept.folder / ".tracerisk_cache").glob("*.json")
    trace.unlink()
    monkeypatch.setattr(
        "tracerisk.cli.reviewers.report.is_installed", lambda name: name != "mujoco"
    )
    assert main(["report", "controller.py", "-o", "out.html", "-q"]) == 0
    document = parsed(kept)
    assert "hardware" in sections(document)
    assert "electric_motor" in reported(document, "hardware")
    # Nothing here could run it.
    assert (
        "The trace of its last run is not kept on this machine. With the .tracerisk_cache of where "
        "it ran, as CI keeps one, the page shows it"
    ) in reported(document, "coverage")


def test_a_replay_that_is_not_kept_is_missed_with_the_command_that_keeps_it(kept):
    (replay,) = (kept.folder / ".tracerisk_cache").glob("*.replay")
    data = replay.read_bytes()
    replay.unlink()
    assert main(["report", "controller.py", "-o", "out.html", "-q"]) == 0
    assert (
        "there is no replay. The replay of its last run is not kept on this machine. "
        "After tracerisk run controller.py the page has it."
    ) in reported(parsed(kept), "timeline")
    kept.write("artifact.replay", data)
    words = ["report", "controller.py", "-o", "out.html", "--recording", "artifact.replay", "-q"]
    assert main(words) == 0
    assert parsed(kept).xpath("//canvas[@id='replay-canvas']")
    replay.write_bytes(data[: len(data) // 2])
    assert main(["report", "controller.py", "-o", "out.html", "-q"]) == 0
    assert "cannot be read" in reported(parsed(kept), "timeline")


def test_a_report_needs_no_numpy_and_says_what_its_replay_needs(kept, monkeypatch):
    monkeypatch.setattr(
        "tracerisk.pipeline.pictures.run_section.is_installed", lambda name: name != "numpy"
    )
    assert main(["report", "controller.py", "-o", "out.html", "-q"]) == 0
    text = reported(parsed(kept), "timeline")
    assert "needs NumPy: pip install 'tracerisk[large]' brings it." in text


def test_a_trace_that_is_not_kept_is_missed(annotated, monkeypatch):
    monkeypatch.chdir(annotated.folder)
    assert main(["report", "controller.py", "-o", "out.html", "-q"]) == 0
    document = parsed(annotated)
    # The description is that of the settings, whatever the run showed.
    assert [each for each in sections(document) if each != "hardware"] == WITHOUT_A_RUN
    assert "The trace of its last run is not kept on this machine." in reported(
        document, "coverage"
    )


def test_without_a_lock_no_run_is_known(annotated, monkeypatch):
    monkeypatch.chdir(annotated.folder)
    (annotated.folder / "tracerisk.lock").unlink()
    assert main(["report", "controller.py", "-o", "out.html", "-q"]) == 0
    assert "tracerisk.lock knows of no run of it." in reported(parsed(annotated), "coverage")
    assert main(["report", "controller.py", "-o", "b.html", "--trace", "trace.json", "-q"]) == 0
    assert sections(parsed(annotated, "b.html")) == ALL


def test_the_difference_to_a_revision_stands_behind_the_replay(kept):
    git(kept, "init", "-q")
    git(kept, "add", "controller.py", "tracerisk.lock")
    git(kept, "commit", "-qm", "before")
    source = kept.read("controller.py").decode()
    old = next(line for line in source.splitlines() if "probability = " in line)
    figure = old.rpartition(" ")[2]
    pinned = old.replace(f"= {figure}", f":= 0.5  ! computed {figure}; <b>it broke</b>")
    kept.write("controller.py", source.replace(old, pinned, 1))
    assert main(["report", "controller.py", "-o", "out.html", "--against", "HEAD", "-q"]) == 0
    document = parsed(kept)
    assert sections(document)[:2] == ["timeline", "difference"]
    assert "mission failure rises from" in reported(document, "difference")
    assert "<b>it broke</b>" in reported(document, "difference")
    assert "<b>it broke</b>" in reported(document, "pins")


def test_against_takes_one_revision(kept, capsys):
    assert main(["report", "controller.py", "-o", "out.html", "--against", "A..B"]) == 2
    assert "--against takes one revision" in capsys.readouterr().err


def test_against_takes_the_merge_base_of_a_branch(kept, capsys):
    git(kept, "init", "-q", "-b", "main")
    git(kept, "add", "controller.py", "tracerisk.lock")
    git(kept, "commit", "-qm", "before")
    git(kept, "branch", "branch")
    source = kept.read("controller.py").decode()
    old = next(line for line in source.splitlines() if "probability = " in line)
    figure = old.rpartition(" ")[2]
    pinned = old.replace(f"= {figure}", f":= 0.5  ! computed {figure}; of main alone")
    # Another change comes to main; the branch has nothing of it, and did not take it back.
    kept.write("controller.py", source.replace(old, pinned, 1))
    git(kept, "commit", "-qam", "main moves on")
    git(kept, "checkout", "-q", "branch")
    kept.write("note.txt", "")
    git(kept, "add", "note.txt")
    git(kept, "commit", "-qm", "the branch")
    report = ["report", "controller.py", "-o", "out.html", "-q", "--against"]
    assert main([*report, "main"]) == 0
    assert "no longer: home.power_system.probability := 0.5" in reported(parsed(kept), "difference")
    for revision in ("main...HEAD", "main...branch", "main..."):
        assert main([*report, revision]) == 0
        document = parsed(kept)
        assert "0.5" not in reported(document, "difference")
        title = document.xpath("//section[@id='difference']/h2")[0].text_content()
        assert title == "Since main (merge base)"
        assert "main has moved on since" in reported(document, "difference")
    assert main([*report, "branch...main"]) == 2
    assert "write branch...HEAD" in capsys.readouterr().err


def test_a_runs_report_says_the_difference_to_a_revision(annotated):
    git(annotated, "init", "-q")
    git(annotated, "add", "controller.py", "tracerisk.lock")
    git(annotated, "commit", "-qm", "before")
    source = annotated.read("controller.py").decode()
    annotated.write(
        "controller.py", source.replace("    act(arm)\n", "    act(arm)\n    act(arm)\n")
    )
    outcome = annotated.run(
        "run", "controller.py", "--report", "out.html", "--against", "HEAD", "--quiet"
    )
    assert outcome.code == 0, outcome.err
    document = parsed(annotated)
    assert sections(document) == [ALL[0], "difference", *ALL[1:]]
    assert document.xpath("//section[@id='difference']/h2")[0].text_content() == "Since HEAD"
    assert "mission failure rises from" in reported(document, "difference")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--against", "HEAD"], "--against goes with --report; add it, or ask `tracerisk diff`"),
        (["--report", "o.html", "--against", "HEAD", "--check"], "and --check writes none"),
        (["--report", "o.html", "--against", "HEAD", "--diff"], "and --diff writes none"),
        (["--report", "o.html", "--against", "A..B"], "--against takes one revision"),
        (["--report", "o.html", "--against", "nowhere"], "nowhere"),
        (["--report", "o.html", "--against", "controller.py"], "'controller.py' is a file"),
    ],
)
def test_what_a_run_cannot_compare_is_reported_before_it(kept, capsys, words, message):
    git(kept, "init", "-q")
    git(kept, "add", "controller.py")
    git(kept, "commit", "-qm", "before")
    before = kept.files()
    assert main(["run", "controller.py", *words]) == 2
    out, err = capsys.readouterr()
    assert (out, message in err) == ("", True), err
    assert kept.files() == before


def test_sources_of_other_languages_have_a_report(example, monkeypatch):
    monkeypatch.chdir(example.folder)
    block = (
        "int x = '<';\n/***\n * RiskAnnotation\n * @Function {\n *   name = place\n"
        " *   callSequence = 1\n * }\n * @Component {\n *   name = gripper\n"
        " *   probability = 7.344e-08\n *   quantity = 1\n *   redundancy = false\n * }\n ***/\n"
        "void place() {}\n"
    )
    example.write("place.cpp", block)
    assert main(["report", "place.cpp", "-o", "out.html", "-q"]) == 0
    document = parsed(example)
    lines = document.xpath("//*[contains(@class, 'line block')]/@data-n")
    assert lines == [str(number) for number in range(3, 15)]
    assert "No run is known of these sources." in reported(document, "coverage")


def test_plain_blocks_are_marked_while_their_comment_lasts(example, monkeypatch):
    monkeypatch.chdir(example.folder)
    example.write(
        "place.py",
        "# @Function {\n#   name = place\n#   callSequence = 1\n# }\n# @Component {\n"
        "#   name = gripper\n#   probability = 7e-08\n#   quantity = 1\n#   redundancy = false\n"
        "# }\ndef place():\n    pass\n",
    )
    assert main(["report", "place.py", "-o", "out.html", "-q"]) == 0
    lines = parsed(example).xpath("//*[contains(@class, 'line block')]/@data-n")
    assert lines == [str(number) for number in range(1, 11)]


def test_a_source_in_its_own_encoding_is_readable(example, annotated_source, monkeypatch):
    monkeypatch.chdir(example.folder)
    text = annotated_source(place=("done 1", "gripper = 1e-7"))
    source = f"# -*- coding: latin-1 -*-\n# gr\xf6\xdfer\n{text}"
    example.write("place.py", source.encode("latin-1"))
    assert main(["report", "place.py", "-o", "out.html", "-q"]) == 0
    assert "gr\xf6\xdfer" in reported(parsed(example), "source")


def test_json_names_the_page_and_has_the_figures(kept, capsys):
    assert main(["report", "controller.py", "-o", "out.html", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["report"], data["exit_code"]) == ("out.html", 0)
    assert 0.0 < data["assessment"]["mission"]["failure_probability"] < 1e-6


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["none.py", "-o", "out.html"], "none.py"),
        (["plain.py", "-o", "out.html"], "no risk block in plain.py"),
        (["controller.py", "-o", "no/folder/out.html"], "cannot be written"),
        (["controller.py", "-o", "out.html", "--trace", "bytes"], "is not UTF-8 text"),
        (["controller.py"], "-o/--output"),
    ],
)
def test_what_cannot_be_done_is_reported(kept, words, message, capsys):
    kept.write("plain.py", "x = 1\n")
    kept.write("bytes", b"\xff\xfe")
    try:
        code = main(["report", *words])
    except SystemExit as error:
        code = error.code
    assert code == 2
    assert message in capsys.readouterr().err
    assert not (kept.folder / "out.html").exists()


def test_a_report_without_a_run_needs_no_simulator(annotated):
    script = (
        "import sys; from tracerisk.cli import main; "
        "code = main(['report', 'controller.py', '-o', 'out.html', '-q']); "
        "print(code, sorted({'mujoco', 'dm_control', 'libcst', 'scipy'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=annotated.folder, capture_output=True, check=True
    )
    assert done.stdout.decode().split("\n")[0] == "0 []"
