"""The commands and the code that docs/report.md shows do what it says."""

import re
import shlex
import subprocess
import zipfile
from pathlib import Path

import pytest

from tracerisk.cli import main
from tracerisk.report.png.drawn import drawn, filmed

TEXT = (Path(__file__).parents[1] / "docs" / "report.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)


def test_the_commands_write_pages_with_the_sections_that_are_listed(example, quick, monkeypatch):
    monkeypatch.chdir(example.folder)
    example.write("controller.py", quick())
    commands, dossier, both, _, _ = blocks("sh")
    first, *others = [shlex.split(line)[1:] for line in commands.splitlines()]
    outcome = example.run(*first, "--quiet")
    assert outcome.code == 0, outcome.err
    pages = [example.read("report.html").decode()]
    for words in (
        ("init", "--quiet"), ("add", "controller.py", "tracerisk.lock"), ("commit", "--quiet", "-m", "x"),
    ):  # fmt: skip
        identity = ("-c", "user.name=t", "-c", "user.email=t@t")
        subprocess.run(["git", *identity, *words], check=True, capture_output=True)
    for words in others:
        assert example.run(*words, "--quiet").code == 0
        pages.append(example.read("report.html").decode())
    run, plain, against = (re.findall(r"<h2[^>]*>(.*?)</h2>", page) for page in pages)
    listed = re.findall(r"^\| ([A-Z][^|]*) \|", TEXT, re.MULTILINE)
    reported = [part for each in listed for part in each.split(", ")]
    assert sorted(["Since REV", *run]) == sorted(reported)
    assert plain == run
    assert against == [run[0], "Since HEAD", *run[1:]]
    for words in both.splitlines()[:2]:  # the third names what another machine has left
        assert example.run(*shlex.split(words.replace("v1.2", "HEAD"))[1:], "--quiet").code == 0
        assert "The run is that of HEAD." in example.read("report.html").decode()
    assert example.run(*shlex.split(dossier)[1:], "--quiet").code == 0
    with zipfile.ZipFile(example.folder / "dossier.zip") as archive:
        names = archive.namelist()
    rows = re.findall(r"^\| (`[^|]*`) \|", TEXT.partition("## The dossier")[2], re.MULTILINE)
    listed = [name for row in rows for name in re.findall(r"`([^`]+)`", row)]
    held = {f"{name.partition('/')[0]}/" if name.startswith("files/") else name for name in names}
    assert held == set(listed)


@pytest.mark.parametrize(
    ("film", "at", "mark"),
    [
        ("run.mp4", 4, b"ftyp"),
        # It is drawn and written in the same way, but the run is made again.
        pytest.param("run.gif", 0, b"GIF89a", marks=pytest.mark.slow),
    ],
)
def test_the_commands_draw_the_pictures(example, quick, monkeypatch, capsys, film, at, mark):
    monkeypatch.chdir(example.folder)
    for draw in (drawn, filmed):
        monkeypatch.setitem(draw.__kwdefaults__, "size", (240, 160))
    example.write("controller.py", quick())
    *_, commands, films = blocks("sh")
    again, run, kept = [shlex.split(line)[1:] for line in commands.splitlines()]
    outcome = example.run(*run, "--quiet")
    assert outcome.code == 0, outcome.err
    found = []
    for words in (again, kept):
        code = main([*words, "--quiet"])
        text = capsys.readouterr().err
        if "without a screen" in text:
            pytest.skip(f"nothing can be drawn here: {text}")
        assert code == 0, text
        found.append({path.name: path.read_bytes() for path in Path("pictures").iterdir()})
    assert sorted(found[0]) == ["01-act.png", "legend.json"]
    pytest.importorskip("av", reason="av is not installed")
    (words,) = (each for each in films.splitlines() if film in each)
    assert main([*shlex.split(words)[1:], "--quiet"]) == 0
    assert example.read(film).startswith(mark, at)
    assert found[0] == found[1]


def test_the_code_runs():
    for block in blocks("python"):
        names: dict[str, str] = {}
        exec(compile(block, "docs/report.md", "exec"), names)
        assert names["page"].startswith("<!DOCTYPE html>")
