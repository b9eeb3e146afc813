"""`tracerisk report --png`: pictures of a run, from its recording or from the run done again."""

import json

import pytest

from tracerisk.cli import main

REASON = "nothing can be drawn here"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory, example_in, two_steps):
    """A controller that was run once, with its recording."""
    example = example_in(tmp_path_factory.mktemp("recorded"))
    example.write("controller.py", two_steps)
    words = ("--keep", "recording", "--trace", "trace.json", "--quiet")
    outcome = example.run("run", "controller.py", *words)
    assert outcome.code == 0, outcome.err
    return example


@pytest.fixture
def here(recorded, monkeypatch):
    monkeypatch.chdir(recorded.folder)
    return recorded


def test_a_picture_is_written_for_each_function_and_a_legend(here, capfd):
    recording = ["--recording", "recording", "--json"]
    code = main(["report", "controller.py", "--png", "pictures", *recording])
    text = capfd.readouterr()
    if code == 2 and "without a screen" in text.err:
        pytest.skip(f"{REASON}: {text.err}")
    assert code == 0, text.err
    data = json.loads(text.out)
    names = ["01-act.png", "02-home.png", "legend.json"]
    assert data["pictures"] == [f"pictures/{name}" for name in names]
    assert "report" not in data
    folder = here.folder / "pictures"
    assert sorted(path.name for path in folder.iterdir()) == names
    assert (folder / names[0]).read_bytes() != (folder / names[1]).read_bytes()
    act, home = json.loads((folder / "legend.json").read_bytes())["pictures"]
    assert (act["function"], home["function"]) == ("act", "home")
    assert act["active"]["electric_motor"]["panda_joint1"] == ["moving"]
    assert "power_system" in act["always"]


def test_a_controller_that_fails_has_no_pictures(example, quick):
    example.write("controller.py", quick("os.kill(os.getpid(), 9)"))
    outcome = example.run("report", "controller.py", "--png", "out")
    assert outcome.code == 4
    assert "ended by SIGKILL" in outcome.err
    assert not (example.folder / "out").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["controller.py"],
            "nothing to write; give -o/--output OUT.html, --dossier OUT.zip, --png DIR, --gif",
        ),
        (["controller.py", "-o", "a.html", "--recording", "."], "holds no recording of a run"),
        (["controller.py", "-o", "a.html", "--recording", "other.py"], "is no packed run"),
        (["controller.py", "--png", "out", "--trace", "trace.json"], "give --recording DIR"),
        (["controller.py", "--png", "out", "--recording", "."], "holds no recording of a run"),
        (["other.py", "--png", "out", "--recording", "recording"], "has no trace to which"),
        (["place.cpp", "--png", "out"], "is not Python controller that can be run"),
        (
            ["controller.py", "--png", "controller.py/out", "--recording", "recording"],
            "controller.py: is not a folder; name another one for the pictures",
        ),
    ],
)
def test_what_cannot_be_done_is_reported(here, words, message, capsys):
    here.write("other.py", "x = 1\n")
    here.write("place.cpp", "int x;\n")
    code = main(["report", *words])
    text = capsys.readouterr().err
    if "without a screen" in text:
        pytest.skip(f"{REASON}: {text}")
    assert code == 2
    assert message in text
    assert not (here.folder / "out").exists()


def test_without_a_way_to_draw_it_is_reported_what_to_install(here, monkeypatch, capsys):
    monkeypatch.setenv("MUJOCO_GL", "nothing")
    assert main(["report", "controller.py", "--png", "out", "--recording", "recording"]) == 2
    text = capsys.readouterr().err
    assert "install libegl1, libgl1 and libgl1-mesa-dri, or libosmesa6" in text
    assert not (here.folder / "out").exists()
