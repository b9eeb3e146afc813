"""Which files a hardware description is read from."""

from tracerisk.common.hardware.source_files import source_files
from tracerisk.config import Settings
from tracerisk.pipeline.freshness.run_inputs import hardware_digest


def test_yaml_is_read_from_its_own_file(tmp_path):
    (tmp_path / "other.sysml").write_text("package Motors {}\n")
    path = tmp_path / "cell.yaml"
    path.write_text("source: Motors\n")
    assert source_files(path) == (path,)


def test_of_sysml_the_files_beside_count_whose_packages_are_named_however_far(tmp_path):
    texts = {
        "cell.sysml": "package Cell { private import Motors::*; }\n",
        "motors.sysml": "package <m> Motors { private import 'Data book'::*; }\n",
        "Book.SYSML": "package 'Data book' { }\n",
        "back.sysml": "package Cell { }\n",
        "other.sysml": "package Other { private import Motors::*; }\n",
        "motors.txt": "package Motors { }\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    found = source_files(tmp_path / "cell.sysml")
    assert [each.name for each in found] == [
        "cell.sysml",
        "Book.SYSML",
        "back.sysml",
        "motors.sysml",
    ]
    assert source_files(tmp_path / "gone.sysml") == (tmp_path / "gone.sysml",)


def test_the_digest_changes_with_a_file_beside_that_is_read_and_with_no_other(tmp_path):
    cell = tmp_path / "cell.sysml"
    cell.write_text("package Cell { private import Motors::*; }\n")
    settings = Settings(hardware=str(cell))
    alone = hardware_digest(settings)
    (tmp_path / "other.sysml").write_text("package Other { }\n")
    assert hardware_digest(settings) == alone
    (tmp_path / "motors.sysml").write_text("package Motors { }\n")
    first = hardware_digest(settings)
    (tmp_path / "motors.sysml").write_text("package Motors { /* 2 */ }\n")
    assert len({alone, first, hardware_digest(settings)}) == 3
    assert hardware_digest(Settings()) == ""
