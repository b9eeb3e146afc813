"""What the elements of a SysML v2 file mean as hardware."""

import os
from pathlib import Path

import pytest

from tracerisk.common.hardware.model import Basis, FailureFigure, FailureMode, LoadLaw, TwinBinding
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.common.hardware.sysml.language.parsing import parse
from tracerisk.common.hardware.sysml.language.standard_names import ENUMERATIONS, FEATURES
from tracerisk.common.hardware.sysml.language.syntax import Element, Package, SourceText
from tracerisk.common.hardware.sysml.sysml_reader import read_sysml
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.errors import HardwareError

HERE = Path(__file__).parent
LIBRARY = Path(read_sysml.__code__.co_filename).parent / "library" / "TraceriskHardware.sysml"
IMPORTS = (
    "private import SI::*; private import TraceriskHardware::*; private import RiskMetadata::*;"
)


def read(folder: Path, text: str):
    path = folder / "model.sysml"
    path.write_text(f"package M {{ {IMPORTS}\n{text}\n}}", encoding="utf-8")
    return read_sysml(path, shown="model.sysml")


def names(hardware) -> dict[str, int | None]:
    return {each.name: each.quantity for each in hardware.components}


def test_the_published_arm_is_the_same_in_yaml_and_in_sysml():
    shipped = Path(read_hardware.__code__.co_filename).parents[1] / "robots" / "panda.yaml"
    assert read_sysml(HERE / "panda.sysml") == read_hardware(shipped)


def test_each_kind_of_element_has_its_meaning():
    hardware = read_sysml(HERE / "everything.sysml", shown="e.sysml")
    assert names(hardware) == {"arm.motor": 7, "arm.brake": 2, "psu": 2, "cam": None}
    motor, brake, psu, cam = hardware.components
    wears = FailureFigure("weibull", 20000, Basis.HOUR, shape=2, error_factor=3, value_is="mean")
    assert motor.figures == (wears,)
    assert motor.age_s == 240 * 3600.0
    assert motor.load_law == LoadLaw(0.3, 0.6, 10 / 3)
    assert motor.modes == (FailureMode("jam", 0.4, ("moving", "holding")),)
    assert motor.twin == TwinBinding(joints="*")
    assert brake.figures == (FailureFigure("probability", 1e-7, Basis.DEMAND, demand="start"),)
    assert brake.redundancy == Redundancy(True, common_cause=0.1)
    assert brake.twin == TwinBinding(actuators=("a", "b"))
    assert psu.figures == (FailureFigure("probability", 0.1, Basis.VISIT),)
    assert psu.always_active
    assert psu.test_interval_s == 8 * 3600.0
    assert cam.figures == (FailureFigure("failure_rate", 5.7e-7, Basis.HOUR),)
    assert cam.twin == TwinBinding(sensors="camera", optional=True)
    assert hardware.robot == "x"
    assert str(motor.location) == "e.sysml:42:13"
    assert [each.split(" is skipped")[0] for each in hardware.warnings] == [
        "e.sysml:56:9: 'action': an element",
        "e.sysml:57:9: 'port': an element",
    ]


def test_multiplicities_of_nested_parts_multiply(tmp_path):
    hardware = read(
        tmp_path,
        "part def Axis { part bearing [2] { @FailureData { rate = 1e-6 [1/h]; } } }"
        "part robot [2] { part arm { part axis : Axis [3]; } }",
    )
    assert names(hardware) == {"arm.axis.bearing": 12}


def test_a_redefined_part_keeps_its_multiplicity_until_one_is_given(tmp_path):
    hardware = read(
        tmp_path,
        "part def A { part m [6] { @FailureData { rate = 1e-6 [h^-1]; } } }"
        "part def B :> A { part :>> m; } part def C :> B { part wheel :>> m; }"
        "part r { part a : C; part b : C { part :>> wheel [4]; } part c : B; }",
    )
    assert names(hardware) == {"a.wheel": 6, "b.wheel": 4, "c.m": 6}


def test_a_number_that_is_left_open_is_the_robot_s(tmp_path):
    motor = '@FailureData { rate = 1e-6 [h^-1]; } @TwinBinding { joints = "*"; }'
    assert names(read(tmp_path, f"part r {{ part m [*] {{ {motor} }} }}")) == {"m": None}
    assert names(read(tmp_path, f"part r {{ part m {{ {motor} }} }}")) == {"m": None}
    assert names(read(tmp_path, f"part r {{ part m [6] {{ {motor} }} }}")) == {"m": 6}


def test_a_definition_is_the_system_where_no_part_is(tmp_path):
    hardware = read(
        tmp_path,
        "part def Motor { @FailureData { rate = 1e-6 [h^-1]; } } part def Arm { part m : Motor; }",
    )
    assert names(hardware) == {"m": 1}


def test_own_failure_data_take_the_place_of_inherited_ones(tmp_path):
    hardware = read(
        tmp_path,
        "part def Motor { @FailureData { rate = 1e-6 [h^-1]; } @FailureData { probability = 0.5; } }"
        "part r { part a : Motor; part b : Motor { @FailureData { rate = 2e-6 [min^-1]; } } }",
    )
    a, b = hardware.components
    assert [each.value for each in a.figures] == [0.5, 1e-6]
    assert [(each.value, each.per) for each in b.figures] == [(2e-6, Basis.MINUTE)]


def test_the_parts_that_are_subsets_of_another_count_once(tmp_path):
    motor = "part def Motor { @FailureData { rate = 1e-6 [h^-1]; } }"
    hardware = read(
        tmp_path,
        f"{motor} part r {{ part both : Motor [2]; part a :> both; part b subsets both; }}",
    )
    assert names(hardware) == {"a": 1, "b": 1}
    with pytest.raises(HardwareError, match="name every unit, or none"):
        read(
            tmp_path, f"{motor} part r {{ part both : Motor [3]; part a :> both; part b :> both; }}"
        )


def test_references_and_abstract_parts_are_no_units(tmp_path):
    hardware = read(
        tmp_path,
        "part def Motor { @FailureData { rate = 1e-6 [h^-1]; } }"
        "part r { part a : Motor; ref part b : Motor; abstract part c : Motor; d : Motor; }",
    )
    assert names(hardware) == {"a": 1}


@pytest.mark.parametrize("word", ["", "new "])
def test_a_risk_level_is_given_with_and_without_new(tmp_path, word):
    hardware = read(
        tmp_path, f"part r {{ @Risk {{ totalRisk = {word}RiskLevel(probability = 0.25); }} }}"
    )
    assert hardware.components[0].figures == (FailureFigure("probability", 0.25, Basis.VISIT),)


def test_a_level_is_reported_and_left_out(tmp_path):
    hardware = read(
        tmp_path,
        "part r { part a { @Risk { totalRisk = RiskLevelEnum::high; } } part b {"
        "@Risk { totalRisk { probability = LevelEnum::low; } } } "
        "part c { @Risk { totalRisk.probability = 0.1; } } }",
    )
    assert names(hardware) == {"c": 1}
    assert [each.split(": ")[1].split(" has")[0] for each in hardware.warnings] == ["'a'", "'b'"]


def test_failure_data_stand_before_a_risk(tmp_path):
    hardware = read(
        tmp_path,
        "part r { @Risk { totalRisk { probability = 0.1; } } @FailureData { probability = 0.2; } }",
    )
    assert hardware.components[0].figures[0].value == 0.2
    assert "is ignored" in hardware.warnings[0]


def test_packages_are_found_in_the_files_beside(tmp_path):
    (tmp_path / "drives.sysml").write_text(
        "package Drives { public import Gears::*; private import TraceriskHardware::*;"
        "part def Motor { @FailureData { probability = 0.1; } part gear : Gear; } }"
    )
    (tmp_path / "gears.sysml").write_text(
        "package Gears { private import TraceriskHardware::*;"
        "part def Gear { @FailureData { probability = 0.2; } } }"
    )
    (tmp_path / "broken.sysml").write_text("package Unused {")
    hardware = read(tmp_path, "private import Drives::*; part r { part m : Motor; part g : Gear; }")
    assert names(hardware) == {"m": 1, "m.gear": 1, "g": 1}
    assert hardware.components[1].location.file == "drives.sysml"


def test_a_package_in_two_files_beside_is_refused(tmp_path):
    for name in ("one", "two"):
        (tmp_path / f"{name}.sysml").write_text("package Drives { part def Motor; }")
    with pytest.raises(HardwareError, match=r"declared by one\.sysml and two\.sysml"):
        read(tmp_path, "private import Drives::*; part r : Motor;")


def test_what_is_not_re_exported_is_not_seen(tmp_path):
    (tmp_path / "drives.sysml").write_text(
        "package Drives { private import Gears::*; } package Gears { part def Gear; }"
    )
    with pytest.raises(HardwareError, match="unknown name 'Gear'"):
        read(
            tmp_path,
            "private import Drives::*; part r : Gear { @FailureData { probability = 0.1; } }",
        )


def test_a_short_name_serves_where_the_name_cannot(tmp_path):
    part = "part r { part <psu> 'Power supply' { @FailureData { probability = 0.1; } } }"
    assert names(read(tmp_path, part)) == {"psu": 1}
    with pytest.raises(HardwareError, match="short name"):
        read(tmp_path, part.replace("<psu> 'Power supply'", "'Power supply (5 V)'"))


def test_line_ends_and_byte_order_marks_are_taken(tmp_path):
    path = tmp_path / "windows.sysml"
    text = "package M {\r\n  part r {\r\n    @TraceriskHardware::FailureData { probability = 2; }\r\n  }\r\n}\r\n"
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    with pytest.raises(
        HardwareError, match=r"m\.sysml:3:53: FailureData.probability: 2 is outside"
    ):
        read_sysml(path, shown="m.sysml")


def test_the_library_declares_what_the_reader_knows():
    source = SourceText("library", LIBRARY.read_text(encoding="utf-8"))
    (package,) = parse(source).members
    assert isinstance(package, Package)
    declared = {
        each.name: tuple(member.name for member in each.members if isinstance(member, Element))
        for each in package.members
        if isinstance(each, Element) and each.is_definition
    }
    enumerations = {name: tuple(words) for name, words in ENUMERATIONS.items()}
    assert declared == {**FEATURES, **enumerations}
    units = [each.short for each in package.members if isinstance(each, Element)]
    assert "FIT" in units


def test_the_official_risk_example_is_read(tmp_path):
    folder = os.environ.get("SYSML_V2_RELEASE")
    if not folder:
        pytest.skip("SYSML_V2_RELEASE does not name a copy of the SysML v2 release")
    path = next(Path(folder).rglob("RiskMetadataExample.sysml"))
    (engine,) = read_sysml(path).components
    assert engine.name == "engine4cyl"
    assert engine.figures == (FailureFigure("probability", 0.3, Basis.VISIT),)


def test_every_file_of_the_official_release_is_parsed():
    folder = os.environ.get("SYSML_V2_RELEASE")
    if not folder:
        pytest.skip("SYSML_V2_RELEASE does not name a copy of the SysML v2 release")
    files = sorted(Path(folder).rglob("*.sysml"))
    assert len(files) > 100
    for path in files:
        parse(SourceText(path.name, path.read_text(encoding="utf-8-sig")))


def test_letters_of_every_language_words_after_a_dot_and_signs_in_what_is_skipped_are_read(
    tmp_path,
):
    path = tmp_path / "m.sysml"
    path.write_text(
        """package M {
            part größe {
                attribute umfang = 2 * π * r;
                attribute warm = 20 [°C];
                attribute kind = M::größe.metadata;
                :>> left.enabled = true;
                :>> right.enabled = true;
                satisfy $::Reqs::Top by self;
                state s { transition on !ready then off; }
                part <motor> 'Motör' { @TraceriskHardware::FailureData { probability = 0.25; } }
            }
        }""",
        encoding="utf-8",
    )
    assert [each.name for each in read_sysml(path).components] == ["motor"]
