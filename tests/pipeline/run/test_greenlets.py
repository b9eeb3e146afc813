"""A controller whose threads are greenlets leaves the same recording as on real threads."""

from pathlib import Path

import pytest

from tracerisk.api import load_settings
from tracerisk.common import trace_json
from tracerisk.pipeline.robot.scenario_settings import with_scenario
from tracerisk.pipeline.run.controller_run import run_again
from tracerisk.pipeline.run.ended_run import RunOptions
from tracerisk.pipeline.run.fault_run import nominal_run
from tracerisk.pipeline.workspace.controller import load_controller

SAMPLES = Path(__file__).parents[3] / "sample_controllers"
SLOW = pytest.mark.slow
OF_THE_RUN = ("request.json", "wall_time.json")
"""The files of a recording that name its folder, or the time that it took."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("glue_bead.py", marks=SLOW),
        pytest.param("surface_scan.py", marks=SLOW),
        pytest.param("careful_pick.py", marks=SLOW),
        pytest.param("machine_tending.py", marks=SLOW),
        pytest.param("part_sorting/src/part_sorting/scripts/sort_parts.py", marks=SLOW),
        pytest.param("pick_and_place.py", marks=SLOW),
        pytest.param("shelf_stocking.py", marks=SLOW),
    ],
)
def test_every_byte_is_the_same_on_threads_and_on_greenlets(name, tmp_path):
    """Slow: the branches in `test_branches.py` are refused where a byte differs."""
    controller = load_controller(str(SAMPLES / name))
    settings = load_settings(controller)
    on_threads, on_greenlets = tmp_path / "threads", tmp_path / "greenlets"
    nominal = nominal_run(controller, settings)
    runs = [
        run_again(
            controller,
            nominal,
            with_scenario(settings),
            (),
            RunOptions(folder, quiet=True),
            greenlets=folder is on_greenlets,
        )
        for folder in (on_threads, on_greenlets)
    ]
    one, other = (trace_json.dumps(each.trace) for each in runs)
    assert one == other
    kept = [
        {each.name: each.read_bytes() for each in folder.iterdir() if each.name not in OF_THE_RUN}
        for folder in (on_threads, on_greenlets)
    ]
    assert kept[0].keys() == kept[1].keys()
    assert [name for name in kept[0] if kept[0][name] != kept[1][name]] == []


def test_every_sample_is_compared():
    marks = test_every_byte_is_the_same_on_threads_and_on_greenlets.pytestmark[0]
    named = {getattr(each, "values", (each,))[0] for each in marks.args[1]}
    scripts = {each.name for each in SAMPLES.glob("*.py")}
    assert named == scripts | {"part_sorting/src/part_sorting/scripts/sort_parts.py"}
