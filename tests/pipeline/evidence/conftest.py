import pytest

from tests.conftest import quick_controller
from tests.pipeline.evidence.test_interrupted import ALONE, settled


@pytest.fixture(scope="package")
def whole(tmp_path_factory, example_in):
    """The bytes of a campaign that nobody interrupts."""
    folder = settled(example_in(tmp_path_factory.mktemp("whole") / "controller"), quick_controller)
    assert folder.run(*ALONE).code == 0
    return folder.read("tracerisk.evidence")
