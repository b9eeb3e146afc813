"""`tracerisk mutate`: how much of a mission is declared, and a gate on it."""

import pytest

MUTATE = ("mutate", "controller.py", "--most", "3", "-j1")
MOVES_MORE = "arm.go(joints, wait=True)\n    arm.set_named_target('ready')\n    arm.go(wait=True)"


@pytest.fixture(scope="module")
def mutated(tmp_path_factory, example_in):
    from tests.conftest import quick_controller

    folder = example_in(tmp_path_factory.mktemp("mutate"))
    folder.write("controller.py", quick_controller(MOVES_MORE))
    folder.write("pyproject.toml", "")
    before = folder.files()
    return folder, before, folder.run(*MUTATE, "--json")


def test_the_changes_are_listed_with_what_their_runs_did(mutated):
    folder, before, outcome = mutated
    assert outcome.code == 0, outcome.err
    found = outcome.json
    assert (found["planned"], found["tried"], len(found["runs"])) == (3, 3, 3)
    assert found["places"] > 20
    assert found["success"] == []
    assert found["altered"] == sum(each["altered"] for each in found["runs"])
    assert {each["file"] for each in found["runs"]} == {"controller.py"}
    assert "no scenario declares `success`" in outcome.err
    assert folder.files() == before


def test_the_table_ends_with_how_much_is_noticed(mutated):
    folder, _, first = mutated
    outcome = folder.run(*MUTATE)
    assert outcome.code == 0
    altered = first.json["altered"]
    assert f"{altered} of 3 changes alter what the run brings about" in outcome.out
    assert f"3 of {first.json['places']} possible changes were drawn" in outcome.err


def test_too_little_that_is_noticed_fails(mutated):
    folder, _, first = mutated
    share = first.json["noticed"]
    assert share < 1.0
    outcome = folder.run(*MUTATE, "--min-noticed", "1")
    assert outcome.code == 1
    assert "below --min-noticed 1" in outcome.err
    assert folder.run(*MUTATE, "--min-noticed", str(share)).code == 0


@pytest.mark.slow
def test_a_shard_tries_its_part(mutated):
    folder, _, first = mutated
    parts = [folder.run(*MUTATE, "--shard", f"{n}/2", "--json").json["runs"] for n in (1, 2)]
    key = lambda each: (each["line"], each["change"])  # noqa: E731
    assert sorted(map(key, [*parts[0], *parts[1]])) == sorted(map(key, first.json["runs"]))


@pytest.mark.slow
def test_of_many_changes_most_alter_what_the_run_brings_about(example, pick_and_place):
    example.write("pick.py", pick_and_place.replace(b"TUBES = 10", b"TUBES = 2"))
    outcome = example.run("mutate", "pick.py", "--most", "24", "--json")
    found = outcome.json
    assert found["tried"] == 24
    assert found["altered"] > 12
    assert len({each["kind"] for each in found["runs"]}) == 12
    whole = [each for each in found["runs"] if each["altered"] and each["is_whole"]]
    assert all(each["differs"] for each in whole)
