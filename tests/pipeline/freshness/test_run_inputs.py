"""What a live run of a compiled node depended on, and when its blocks are stale."""

from types import SimpleNamespace

import pytest

from tracerisk.config import Settings
from tracerisk.pipeline.freshness.freshness import stale_reasons
from tracerisk.pipeline.freshness.run_inputs import run_inputs
from tracerisk.pipeline.workspace.controller import load_controller

FILES = {
    "pick.cpp": "int main() { return 0; }\n",
    "place.cpp": "void place() {}\n",
    "cell.h": "void place();\n",
    "cell.yaml": "speed: 1\n",
}


@pytest.fixture
def depended(tmp_path):
    """Return how stale the blocks of the run are after a file has got some text more."""
    (tmp_path / "pyproject.toml").write_text("")
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    given = {"inputs": ("place.cpp", "cell.h", "cell.yaml"), "files": ("pick.cpp",)}
    trace = SimpleNamespace(**given, is_measured=True, is_live=True)
    settings = Settings(robot="panda")
    controller = load_controller(tmp_path / "pick.cpp")
    recorded = run_inputs(controller, trace, settings)

    def after(name, more):
        (tmp_path / name).write_text(FILES[name] + more)
        return stale_reasons(recorded, load_controller(tmp_path / "pick.cpp"), settings)

    return after


@pytest.mark.parametrize("name", FILES)
def test_a_change_of_any_file_of_the_run_makes_blocks_stale(depended, name):
    assert depended(name, "") == ()
    reasons = depended(name, "int more;\n")
    assert len(reasons) == 1
    assert name in str(reasons[0])


@pytest.mark.parametrize("name", ["pick.cpp", "place.cpp", "cell.h"])
def test_comments_of_sources_and_headers_change_no_run(depended, name):
    assert depended(name, "/* a block of another node */ // said\n") == ()
