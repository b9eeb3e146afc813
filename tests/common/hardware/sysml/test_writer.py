"""What the writer writes reads back as the same description."""

from hypothesis import given, settings

from tests.common.hardware.strategies import hardware_descriptions
from tracerisk.common.hardware.sysml.sysml_reader import read_sysml
from tracerisk.common.hardware.sysml.writer import write_sysml


@given(hardware_descriptions())
@settings(max_examples=20, deadline=None)
def test_what_is_written_reads_back_as_the_same(tmp_path_factory, hardware):
    path = tmp_path_factory.getbasetemp() / "written.sysml"
    path.write_text(write_sysml(hardware), encoding="utf-8", newline="")
    assert read_sysml(path) == hardware
