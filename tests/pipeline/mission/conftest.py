import pytest

from tracerisk.ros.scenario.file.scenario_reader import read_scenario


@pytest.fixture
def read(tmp_path):
    """What `success` of a scenario with such entries asks."""

    def read_entries(*entries):
        path = tmp_path / "cell.yaml"
        path.write_text("success:\n" + "".join(f"  - {entry}\n" for entry in entries))
        return read_scenario(path).success

    return read_entries
