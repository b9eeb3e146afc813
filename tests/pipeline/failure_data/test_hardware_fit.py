import pytest

from tracerisk.api import load_hardware
from tracerisk.config import Settings
from tracerisk.errors import HardwareError


def test_the_description_of_another_robot_is_refused_by_name(tmp_path):
    path = tmp_path / "arm.yaml"
    path.write_text("robot: ur5e\ncomponents: {brain: {probability: 1e-9, active: always}}\n")
    settings = Settings(hardware=str(path))
    with pytest.raises(HardwareError, match="describes robot 'ur5e', but the controller drives"):
        load_hardware(settings, "panda")
    assert load_hardware(settings, "ur5e").robot == "ur5e"
    assert load_hardware(settings, "").robot == "ur5e", "a log tells no robot"
