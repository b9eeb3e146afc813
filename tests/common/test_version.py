"""The version is that of the installed distribution, found without the import that is slow."""

import os
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from tracerisk import __version__
from tracerisk.common.version import UNKNOWN, installed_version

ROOT = Path(__file__).parents[2]


@pytest.fixture
def checkout(tmp_path):
    """A folder with the package, and nothing installed beside it."""
    folder = tmp_path / "checkout"
    (folder / "tracerisk").mkdir(parents=True)
    return folder


def test_it_is_what_the_installer_says():
    assert __version__ == version("tracerisk")


def test_the_version_is_found_beside_the_code(checkout):
    (checkout / "tracerisk-1.2.3.dev4.dist-info").mkdir()
    assert installed_version(str(checkout), [str(checkout)]) == "1.2.3.dev4"


def test_an_editable_installation_has_its_version_where_no_code_is(checkout, tmp_path):
    site = tmp_path / "site-packages"
    (site / "tracerisk-2.0.dist-info").mkdir(parents=True)
    (site / "tracerisk_probe-9.9.dist-info").mkdir()
    assert installed_version(str(checkout), [str(tmp_path / "absent"), str(site)]) == "2.0"


def test_another_installation_does_not_lend_a_checkout_its_version(checkout, tmp_path):
    site = tmp_path / "site-packages"
    (site / "tracerisk-2.0.dist-info").mkdir(parents=True)
    (site / "tracerisk").mkdir()
    assert installed_version(str(checkout), [str(site)]) == UNKNOWN


def test_a_plain_checkout_says_that_it_has_no_version(tmp_path):
    for name in ("__init__.py", "__main__.py", "api.py", "errors.py"):
        (tmp_path / "tracerisk").mkdir(exist_ok=True)
        shutil.copy(ROOT / "tracerisk" / name, tmp_path / "tracerisk")
    for name in ("cli", "common"):
        shutil.copytree(ROOT / "tracerisk" / name, tmp_path / "tracerisk" / name)
    done = subprocess.run(
        [sys.executable, "-S", "-m", "tracerisk", "--version"],
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == f"tracerisk {UNKNOWN}\n"
