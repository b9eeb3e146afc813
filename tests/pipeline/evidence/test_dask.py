"""Dask's workers try failures, and the evidence has the same bytes."""

import pytest

distributed = pytest.importorskip("distributed")

HARDWARE = """\
robot: panda
components:
  motor:
    failure_rate: {value: 1.0e-5, per: hour}
    twin: {joints: [panda_joint1]}
    quantity: 1
"""


@pytest.mark.slow
def test_two_workers_of_dask_give_the_same_bytes_as_one_process(tmp_path, example_in, quick):
    from tracerisk.api import gather_evidence
    from tracerisk.common.campaign import CampaignOptions

    found = []
    for name in ("here", "there"):
        folder = example_in(tmp_path / name)
        folder.write("controller.py", quick())
        folder.write("one.yaml", HARDWARE)
        folder.write("pyproject.toml", '[tool.tracerisk]\nhardware = "one.yaml"\n')
        found.append(folder)
    here, there = found
    gather_evidence(here.folder / "controller.py", options=CampaignOptions(jobs=1), cells=6)
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        gather_evidence(
            there.folder / "controller.py",
            options=CampaignOptions(executor=client.get_executor(pure=False)),
            cells=6,
        )
    assert there.read("tracerisk.evidence") == here.read("tracerisk.evidence")
