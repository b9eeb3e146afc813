"""What files of a workspace say is started, as a contained run reads them."""

import os

import pytest

from tracerisk.common.sandbox.files.overlay import Overlay
from tracerisk.ros.robot.bring_up.launched import LaunchedControllers


@pytest.fixture
def package(tmp_path):
    """A package below `src`, beside which a README starts a controller."""
    folder = tmp_path / "src" / "cell"
    folder.mkdir(parents=True)
    (folder / "run.sh").write_text("spawner arm_controller\n")
    (tmp_path / "README.md").write_text("spawner hand_controller\n")
    return folder


def test_a_readme_beside_the_sources_is_read(package):
    found = LaunchedControllers([package])
    assert found.starts("arm_controller")
    assert found.starts("hand_controller")


@pytest.mark.parametrize("refused", ["listdir", "scandir"])
def test_a_workspace_folder_that_may_not_be_listed_is_no_finding(
    package, tmp_path, monkeypatch, refused
):
    listed = getattr(os, refused)

    def contained(path="."):
        if os.fspath(path) == str(tmp_path):
            raise PermissionError(13, "Permission denied", str(path))
        return listed(path)

    monkeypatch.setattr(os, refused, contained)
    denied: list[tuple[str, str]] = []
    written = tmp_path / "written"
    written.mkdir()
    with Overlay(str(written), (), lambda *what: denied.append(what)).active():
        found = LaunchedControllers([package])
    assert found.starts("arm_controller")
    assert not denied
