"""`report --all`: a page over every controller; `report --history`: how one went."""

import json
import re
import subprocess

import pytest

from tracerisk.cli import main


def git(*words: str) -> None:
    identity = ("-c", "user.name=t", "-c", "user.email=t@t")
    subprocess.run(["git", *identity, *words], check=True, capture_output=True)


@pytest.fixture(scope="module")
def repository(tmp_path_factory, example_in, quick):
    """A repository of two controllers, one of them with a lock of its own, and two commits."""
    example = example_in(tmp_path_factory.mktemp("fleet"))
    own = "cells/welding/pyproject.toml"
    example.write(own, b"[tool.tracerisk]\n")
    example.write("pick.py", quick())
    example.write("cells/welding/weld.py", quick())
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(example.folder)
        git("init", "--quiet")
        for name in ("pick.py", "cells/welding/weld.py"):
            outcome = example.run("run", name, "--quiet")
            assert outcome.code == 0, outcome.err
        git("add", "-A")
        git("commit", "--quiet", "-m", "Assess <both>")
        for name in ("cells/welding/weld.py",):
            text = example.read(name).decode()
            changed = re.sub(r"( *# \|   probability) = .*", r"\1 := 1e-3", text, count=1)
            assert changed != text
            example.write(name, changed.encode())
        git("add", "-A")
        git("commit", "--quiet", "-m", "Set a figure")
    return example


@pytest.fixture
def here(repository, monkeypatch):
    monkeypatch.chdir(repository.folder)
    return repository


def rows(page, parsed):
    return [
        [" ".join(" ".join(cell.itertext()).split()) for cell in row.xpath("./*")]
        for row in parsed(page).xpath("//*[@id='controllers-table']/tbody/tr")
    ]


@pytest.fixture
def parsed():
    html = pytest.importorskip("lxml.html")
    return lambda text: html.document_fromstring(text.encode())


def test_every_controller_of_every_lock_has_a_row_the_riskiest_first(here, parsed, capsys):
    assert main(["report", "--all", "-o", "all.html"]) == 0
    assert "all.html: 2 controllers" in capsys.readouterr().err
    page = here.read("all.html").decode()
    weld, pick = rows(page, parsed)
    assert weld[0].replace("/ ", "/") == "weld.py cells/welding"
    assert pick[0] == "pick.py"
    assert float(weld[2]) > 1e-7 > float(pick[2]) > 0.0
    assert [each[1] for each in (weld, pick)] == ["partial", "partial"]
    assert re.fullmatch(r"\d of \d", pick[3])
    assert re.fullmatch(r"\w+, [>\d. \xa0]+%", pick[4])
    assert main(["report", "--all", "-o", "all.html", "--quiet"]) == 0
    assert here.read("all.html").decode() == page


def test_a_report_that_is_there_is_linked_and_another_page_is_not(here, parsed):
    assert main(["report", "pick.py", "-o", "pick.html", "--quiet"]) == 0
    here.write("cells/welding/weld.html", b"<title>something else</title>")
    try:
        assert main(["report", "--all", "-o", "all.html", "--quiet"]) == 0
        page = parsed(here.read("all.html").decode())
        assert page.xpath("//*[@id='controllers-table']//a/@href") == ["pick.html"]
    finally:
        (here.folder / "pick.html").unlink()
        (here.folder / "cells/welding/weld.html").unlink()


def test_a_broken_or_deleted_controller_is_reported_and_keeps_no_other_from_being_reported(
    here, parsed
):
    text = here.read("pick.py")
    path = here.folder / "pick.py"
    for broken, reported in (
        (text.replace(b"quantity = ", b"quantity = x", 1), "quantity"),
        (None, "cannot be read: No such file or directory; restore it"),
    ):
        try:
            if broken is None:
                path.unlink()
            else:
                path.write_bytes(broken)
            assert main(["report", "--all", "-o", "all.html", "--quiet"]) == 0
            first, second = rows(here.read("all.html").decode(), parsed)
            assert first[0].startswith("pick.py")
            assert reported in first[0]
            assert first[2] == "\N{EN DASH}"
            assert second[0].startswith("weld.py")
        finally:
            path.write_bytes(text)


def test_the_json_has_the_figures_and_what_could_not_be_read(here, capsys):
    assert main(["report", "--all", "-o", "all.html", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert [each["controller"] for each in data["controllers"]] == [
        "cells/welding/weld.py",
        "pick.py",
    ]
    assert data["controllers"][1]["verdict"]["kind"] == "partial"
    assert data["controllers"][1]["error"] is None


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--all"], "--all writes one page; give -o/--output OUT.html"),
        (["--all", "x.py", "-o", "y"], "--all takes every controller that a lock knows"),
        (["--all", "--history", "-o", "y"], "--history is for the report of one controller"),
        (["-o", "y"], "name a source, or give --all"),
        (["pick.py", "--history", "--png", "p"], "--history is a part of the page"),
    ],
)
def test_what_does_not_fit_is_refused(here, capsys, words, message):
    assert main(["report", *words]) == 2
    assert message in capsys.readouterr().err


def test_without_a_controller_it_says_what_writes_one(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["report", "--all", "-o", "x.html"]) == 2
    assert "knows a controller; `tracerisk run FILE` writes one" in capsys.readouterr().err


def test_the_history_is_in_the_report_only_where_it_is_asked_for(here, parsed):
    words = ["report", "cells/welding/weld.py", "-o", "weld.html", "--quiet"]
    assert main(words) == 0
    plain = here.read("weld.html")
    assert b'id="history"' not in plain
    assert main([*words, "--history"]) == 0
    page = parsed(here.read("weld.html").decode())
    reported = [
        [" ".join(" ".join(cell.itertext()).split()) for cell in row.xpath("./*")]
        for row in page.xpath("//*[@id='history-table']/tbody/tr")
    ]
    assert [row[4].split(" cells")[0] for row in reported] == ["Assess <both>", "Set a figure"]
    assert float(reported[0][1]) < 1e-7 < float(reported[1][1])
    assert reported[1][2].startswith("x")
    assert len(page.xpath("//*[@id='history']//svg//circle")) == 2
    assert not page.xpath("//*[@id='history']//svg//*[@style]")
    (here.folder / "weld.html").unlink()
