"""No edit of a controller, its blocks or its lock ends a comparison in an internal error."""

import random
import re
import shutil

import pytest

from tests.conftest import SAMPLES
from tests.pipeline.review.random_edits import EditedController
from tests.pipeline.review.test_causes import TURN
from tests.slow import slow_but

EDITS = 10
SCRIPTS = (
    "shelf_stocking.py",
    "surface_scan.py",
    "careful_pick.py",
    "machine_tending.py",
    "glue_bead.py",
    "pick_and_place.py",
)


@pytest.fixture(scope="module")
def annotated(tmp_path_factory, example_in):
    """Return a folder with a sample that was run once, its blocks and its lock."""
    made = {}

    def make(script: str):
        if script not in made:
            example = example_in(tmp_path_factory.mktemp("sample"))
            example.write("pyproject.toml", "")
            example.write(script, (SAMPLES / script).read_bytes())
            assert example.run("run", script).code in (0, 1)
            made[script] = example.folder
        return made[script]

    return make


@pytest.fixture
def edited(annotated, repository, monkeypatch):
    def make(seed: int) -> EditedController:
        script = SCRIPTS[seed % len(SCRIPTS)]
        ignored = shutil.ignore_patterns(".tracerisk_cache")
        shutil.copytree(annotated(script), repository.folder, dirs_exist_ok=True, ignore=ignored)
        repository.write(".gitignore", ".tracerisk_cache\n*.html\n*.svg\n*.sarif\n")
        repository.commit()
        monkeypatch.chdir(repository.folder)
        return EditedController(repository, script, random.Random(seed))

    return make


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(30))
def test_ten_edits(edited, seed) -> None:
    controller = edited(seed)
    for _ in range(EDITS):
        controller.step()
        controller.compare()
    controller.look_back()
    # Many of the edits are such that there are two models to compare.
    assert controller.codes.count(2) < 3 / 4 * len(controller.codes)


@pytest.mark.parametrize("seed", slow_but((0,), range(5)))
def test_edits_that_are_run(repository, monkeypatch, seed) -> None:
    chance = random.Random(seed)
    calls = ["go(0.2)", "left()", "right()", "go(-0.1)"]
    repository.write("pyproject.toml", "")
    repository.write(".gitignore", ".tracerisk_cache\n*.html\n*.svg\n*.sarif\n")
    repository.write("turn.py", TURN)
    monkeypatch.chdir(repository.folder)
    for number in range(3):
        text = repository.read("turn.py").decode()
        if number:
            body = "".join(f"    {call}\n" for call in chance.choices(calls, k=number + 1))
            text = re.sub(r"(?<=both\(\):\n)((?:    # .*\n)*)(?:    .*\n)+", rf"\1{body}", text)
            renamed = chance.choice(("left", "right"))
            text = re.sub(rf"(?<=[ ]){renamed}(?=\()", f"{renamed}_{number}", text)
            calls = [call.replace(renamed, f"{renamed}_{number}") for call in calls]
        repository.write("turn.py", text)
        assert repository.run("run", "turn.py").code == 0
        repository.commit()
    controller = EditedController(repository, "turn.py", chance)
    controller.compare()
    controller.look_back()
    assert set(controller.codes) <= {0, 1}
