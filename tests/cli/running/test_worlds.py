"""`tracerisk run --worlds`, and `check` with `require_worlds`."""

from pathlib import Path

import pytest

RACE = Path(__file__).parents[3] / "benchmarks" / "races" / "publish_at_once.py"
RUN = ("run", "cell.py", "--worlds", "discovery,joints-reversed")


@pytest.fixture(scope="module")
def raced(tmp_path_factory, example_in):
    folder = example_in(tmp_path_factory.mktemp("worlds"))
    folder.write("cell.py", RACE.read_bytes())
    folder.write("pyproject.toml", "[tool.tracerisk]\nrequire_worlds = ['discovery', 'start']\n")
    return folder, folder.run(*RUN, "--json", "--report", "cell.html", "--sarif", "cell.sarif")


def test_a_run_that_depends_on_a_world_fails_and_says_where(raced):
    folder, outcome = raced
    assert outcome.code == 1, outcome.err
    found = {run["world"]: run for run in outcome.json["worlds"]}
    assert {name: run["depends"] for name, run in found.items()} == {
        "discovery": True,
        "joints-reversed": False,
    }
    lines = folder.read("cell.py").decode().splitlines()
    assert "publisher.publish(" in lines[found["discovery"]["location"]["line"] - 1]
    assert outcome.json["verdict"]["kind"] == "complete"
    assert outcome.json["trace"]["worlds"][0]["world"] == "discovery"


def test_report_and_sarif_have_the_worlds(raced):
    folder, _ = raced
    assert b'id="worlds-table"' in folder.read("cell.html")
    assert b'"ruleId": "world-dependence"' in folder.read("cell.sarif")


def test_check_requires_worlds_and_names_a_command(raced):
    folder, _ = raced
    outcome = folder.run("check", "cell.py")
    assert outcome.code == 1
    assert "world: the run depends on world discovery: rest 1 of 2" in outcome.out
    assert (
        "require_worlds names start, and the last run was not repeated there; "
        "`tracerisk run cell.py --worlds start`"
    ) in outcome.out


def test_a_later_run_of_the_same_inputs_keeps_the_worlds(raced):
    folder, _ = raced
    before = folder.read("tracerisk.lock")
    assert folder.run("run", "cell.py").code == 0
    assert folder.read("tracerisk.lock") == before


def test_a_table_lists_the_worlds(raced):
    folder, _ = raced
    outcome = folder.run("run", "cell.py", "--worlds", "joints-reversed")
    assert outcome.code == 0, outcome.err
    assert "Other worlds" in outcome.out
    assert "verdict and outcome are the same in 1 world" in outcome.out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--worlds", "nowhere"), "unknown world 'nowhere'; allowed: all, discovery"),
        (("--worlds", "all", "--watch"), "leave out --watch"),
        (("--worlds=all", "--fault", "panda_joint4:dead@1"), "leave out --fault"),
    ],
)
def test_what_does_not_go_is_an_error(raced, options, message):
    folder, _ = raced
    outcome = folder.run("run", "cell.py", *options)
    assert outcome.code == 2
    assert message in outcome.err


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("['foo']", "require_worlds: unknown world 'foo'; allowed: all, discovery"),
        ("3", "expected true, false or a list of names of worlds, found 3"),
    ],
)
def test_a_wrong_setting_is_an_error(example, value, message):
    example.write("cell.py", "pass\n")
    example.write("pyproject.toml", f"[tool.tracerisk]\nrequire_worlds = {value}\n")
    outcome = example.run("run", "cell.py")
    assert outcome.code == 2
    assert message in outcome.err
