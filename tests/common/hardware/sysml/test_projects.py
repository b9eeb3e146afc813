"""Models of several files and folders, of several systems, and with words of others."""

import os

import pytest

from tracerisk.common.hardware.source_files import source_files
from tracerisk.common.hardware.sysml.sysml_reader import read_sysml
from tracerisk.config import Settings
from tracerisk.errors import HardwareError
from tracerisk.pipeline.freshness.run_inputs import hardware_digest

DATA = "@TraceriskHardware::FailureData { probability = 1e-6; }"
PROJECT = {
    "parts/motors.sysml": f"package Motors {{ part def Motor {{ {DATA} }} }}",
    "parts/deep/base.sysml": "package Arms { private import Motors::*; part def Arm { part m : Motor [7]; } }",
    "cell.sysml": "package Cell { private import Arms::*; part cell { part arm : Arm; } }",
    "views.sysml": "package Views2 { view v; }",
    ".old/cell.sysml": "package Cell { part broken",
    "library/Items.sysml": "standard library package Items { calc def outside the subset { } }",
    "notes.txt": "package Motors { }",
}


@pytest.fixture
def project(tmp_path):
    def make(files):
        for name, text in files.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return tmp_path

    return make


def named(hardware):
    return {each.name: each.quantity for each in hardware.components}


def one_file(tmp_path, text, **more):
    path = tmp_path / "m.sysml"
    path.write_text(text)
    return read_sysml(path, shown="m.sysml", **more)


def test_a_folder_is_read_with_all_folders_below_it(project):
    folder = project(PROJECT)
    assert named(read_sysml(folder)) == {"arm.m": 7}
    with pytest.raises(HardwareError, match="or read the folder of all files"):
        read_sysml(folder / "cell.sysml")


def test_what_is_hidden_or_no_file_is_passed_over_in_a_folder(project):
    folder = project(PROJECT)
    (folder / ".#cell.sysml").symlink_to("user@machine.1234")  # the lock of an editor
    (folder / "lost.sysml").symlink_to("nowhere")
    os.mkfifo(folder / "pipe.sysml")
    assert named(read_sysml(folder)) == {"arm.m": 7}
    assert not any(name in str(source_files(folder)) for name in ("#", "lost", "pipe"))
    with pytest.raises(HardwareError, match=r"pipe\.sysml: cannot be read"):
        read_sysml(folder / "pipe.sysml")


def test_the_files_of_a_folder_make_its_digest(project):
    folder = project(PROJECT)
    settings = Settings(hardware=str(folder))
    assert [path.relative_to(folder).as_posix() for path in source_files(folder)] == [
        "cell.sysml",
        "library/Items.sysml",
        "parts/deep/base.sysml",
        "parts/motors.sysml",
        "views.sysml",
    ]
    before = hardware_digest(settings)
    (folder / "notes.txt").write_text("")
    assert hardware_digest(settings) == before
    (folder / "parts/deep/base.sysml").rename(folder / "parts/base.sysml")
    assert hardware_digest(settings) != before


def test_of_two_packages_the_nearer_file_counts(project):
    folder = project(
        {
            **PROJECT,
            "parts/deep/motors.sysml": f"package Motors {{ part def Motor {{ part two [2] {{ {DATA} }} }} }}",
        }
    )
    assert named(read_sysml(folder)) == {"arm.m.two": 14}
    (folder / "parts/deep/more.sysml").write_text("package Motors { }")
    with pytest.raises(HardwareError) as caught:
        read_sysml(folder)
    assert "package 'Motors' is declared by parts/deep/more.sysml and parts/deep/motors" in str(
        caught.value
    )


def test_a_folder_without_a_model_is_refused(tmp_path):
    with pytest.raises(HardwareError, match=r"is a folder without a \.sysml file"):
        read_sysml(tmp_path)


def test_a_folder_of_many_models_is_refused(project, monkeypatch):
    folder = project(PROJECT)
    monkeypatch.setattr("tracerisk.common.hardware.sysml.project.MAX_BYTES", 200)
    with pytest.raises(HardwareError, match="more than 200 bytes; give the folder of one model"):
        read_sysml(folder)
    monkeypatch.setattr("tracerisk.common.hardware.source_files.MAX_FILES", 3)
    with pytest.raises(HardwareError, match=r"holds more than 3 \.sysml files"):
        read_sysml(folder)


TWO = f"""package X {{
    part robot {{ part m {{ {DATA} }} }}
    package Benches {{ part bench {{ part m [2] {{ {DATA} }} }} part <b> 'test bench' {{ {DATA} }} }}
    part def Old {{ part m [3] {{ {DATA} }} }}
    part empty;
}}
"""


@pytest.mark.parametrize(
    ("system", "components"),
    [
        ("robot", {"m": 1}),
        ("X::Benches::bench", {"m": 2}),
        ("bench", {"m": 2}),
        ("b", {"b": 1}),
        ("test bench", {"b": 1}),
        ("Old", {"m": 3}),
    ],
)
def test_the_system_is_the_part_that_is_named(tmp_path, system, components):
    assert named(one_file(tmp_path, TWO, system=system)) == components


@pytest.mark.parametrize(
    ("system", "message"),
    [
        (
            None,
            "several parts could be the system as a whole: 'robot' (line 2), 'bench' (line 3), ",
        ),
        (None, "name one by --system or the setting system, or keep one"),
        ("robots", "m.sysml:1:1: the system 'robots' is no part in a package of it; "),
        ("empty", "m.sysml:5:10: 'empty' has no part with failure data"),
    ],
)
def test_a_system_that_is_not_clear_is_reported(tmp_path, system, message):
    with pytest.raises(HardwareError) as caught:
        one_file(tmp_path, TWO, system=system)
    assert message in str(caught.value)


def test_of_parts_of_one_name_the_system_is_named_with_its_packages(tmp_path):
    text = "".join(f"package {p} {{ part r {{ part {p} {{ {DATA} }} }} }}\n" for p in "ab")
    with pytest.raises(HardwareError, match=r"'a::r' \(line 1\), 'b::r' \(line 2\)"):
        one_file(tmp_path, text)
    with pytest.raises(HardwareError, match=r"'r' could be 'a::r' \(m\.sysml:1:18\), 'b::r'"):
        one_file(tmp_path, text, system="r")
    assert named(one_file(tmp_path, text, system="b::r")) == {"b": 1}


def test_a_part_that_cannot_be_read_is_no_system_but_where_it_is_named(tmp_path):
    text = f"package X {{ part r {{ part a {{ {DATA} }} }} part s {{ variation part b {{ {DATA} }} }} }}"
    assert named(one_file(tmp_path, text, system="r")) == {"a": 1}
    for system, message in ((None, "several parts could be"), ("s", "'b' is a variation")):
        with pytest.raises(HardwareError, match=message):
            one_file(tmp_path, text, system=system)


@pytest.mark.parametrize(
    "text",
    [
        # Packages that import each other.
        f"""package X {{
            package P1 {{ public import P2::*; part def A {{ {DATA} }} }}
            package P2 {{ public import P1::*; part def B {{ {DATA} }} }}
            package T {{ public import P1::*; part s {{ part x : A; part y : B; }} }}
        }}""",
        # What every part has, and what a library may give.
        f"""package X {{
            private import SpatialItems::*; private import ShapeItems::*;
            part def Arm :> SpatialItem {{ item :>> shape : Cuboid; item :>> faces; }}
            part s {{ item :>> shape : Cuboid; item e : Box [1] :> boundingShapes;
                part x : Arm {{ {DATA} }} part y {{ {DATA} }} }}
        }}""",
        # `import all` takes private names, too.
        f"""package X {{
            package P1 {{ part def A {{ {DATA} }} }}
            package P2 {{ private import P1::*; }}
            package T {{ public import all P2::*; part s {{ part x : A; part y : A; }} }}
        }}""",
        # An import of behaviour, which is not read.
        f"""package X {{
            package P {{ action 'give power' {{ action go; }} action def Run {{ }} part def A {{ {DATA} }} }}
            private import P::'give power'::*; private import P::Run::go; private import P::A;
            part s {{ part x : A; part y : A; }}
        }}""",
        # Names that a package imports for others may be of a library.
        f"""package X {{
            package P {{ public import ModelingMetadata::*; }}
            public import P::**;
            part s {{ @Rationale {{ text = "x"; }} part x {{ {DATA} }} part y {{ {DATA} }} }}
        }}""",
        # A package of the model goes before one of a library that is known by name alone.
        f"""package Base {{ part def A {{ {DATA} }} }}
        package X {{ private import Base::*; part s {{ part x : A; part y : A; }} }}""",
    ],
)
def test_what_models_of_others_say_is_read(tmp_path, text):
    assert named(one_file(tmp_path, text)) == {"x": 1, "y": 1}


def test_an_import_of_nothing_is_told_and_refused_where_a_part_needs_it(tmp_path):
    text = f"package X {{ private import Nowhere::*; part s {{ {DATA} }} }}"
    hardware = one_file(tmp_path, text)
    assert named(hardware) == {"s": 1}
    (warning,) = hardware.warnings
    assert warning.startswith("m.sysml:1:28: unknown name 'Nowhere'; declare it in this file or")
    assert warning.endswith("this import leads to nothing, and no part of the system needs it")
    for needy in ("part s : Motor {", "part s { part motor : Motor;", "part s { @Critical;"):
        with pytest.raises(HardwareError, match="1:28: unknown name 'Nowhere'"):
            one_file(tmp_path, text.replace("part s {", needy))
    with pytest.raises(HardwareError, match="1:28: unknown name 'Motor'"):
        one_file(
            tmp_path, text.replace("Nowhere::*", "Motor").replace("part s {", "part s : Motor {")
        )


def test_a_file_of_a_folder_that_cannot_be_read_stops_only_what_needs_it(project):
    folder = project(
        {
            "cell.sysml": f"package Cell {{ part cell {{ part arm {{ {DATA} }} }} }}",
            "broken.sysml": "package Grippers { part def Gripper { part jaw",
        }
    )
    hardware = read_sysml(folder, shown="f")
    assert named(hardware) == {"arm": 1}
    assert hardware.warnings == (
        "f/broken.sysml:1:37: unclosed '{'; expected '}' before the end of the file; "
        "this file is left out",
    )
    project(
        {
            "cell.sysml": f"""package Cell {{
        private import Grippers::*; part cell {{ part arm : Gripper {{ {DATA} }} }} }}"""
        }
    )
    with pytest.raises(HardwareError, match=r"broken\.sysml:1:37: unclosed '{'"):
        read_sysml(folder)


def test_a_file_with_failure_data_that_cannot_be_read_is_an_error(project):
    folder = project(
        {
            "cell.sysml": f"package Cell {{ part cell {{ part arm {{ {DATA} }} }} }}",
            "broken.sysml": f"package Grippers {{ part gripper {{ {DATA} }} ) }}",
        }
    )
    with pytest.raises(HardwareError, match=r"broken\.sysml:1:"):
        read_sysml(folder)


def test_a_package_in_several_files_is_one_package(project):
    folder = project(
        {
            "arm.sysml": f"package Cell {{ package Arms {{ part def Arm {{ {DATA} }} }} }}",
            "cell.sysml": """package Cell {
                package Arms { part def Hand; }
                part cell { part left : Arms::Arm; part tool : Tool; } }""",
            "tool.sysml": f"package Cell {{ part def Tool {{ {DATA} }} }}",
        }
    )
    assert named(read_sysml(folder)) == {"left": 1, "tool": 1}
    assert named(read_sysml(folder / "cell.sysml")) == {"left": 1, "tool": 1}
    project({"again.sysml": "package Cell { part def Tool; }"})
    with pytest.raises(HardwareError, match="unknown name 'Tool'"):
        read_sysml(folder)


def test_a_part_declared_again_is_the_inherited_one(tmp_path):
    text = f"""package X {{
        part def Arm {{ part motor [3] {{ {DATA} }} part brake {{ {DATA} }} }}
        part arm : Arm {{
            part motor {{ attribute mass = 2; }}
            part brake [2];
            part fan {{ {DATA} }} }} }}"""
    hardware = one_file(tmp_path, text)
    assert named(hardware) == {"motor": 3, "brake": 2, "fan": 1}
    assert hardware.warnings[0] == (
        "m.sysml:4:18: 'motor' is inherited from m.sysml:2:29 already, and is read as "
        "'part :>> motor'; write this, or give it another name"
    )
    marked = text.replace("part motor {", "part :>> motor {").replace("brake [2]", ":>> brake [2]")
    assert one_file(tmp_path, marked).components[0].figures == hardware.components[0].figures


def test_a_definition_within_one_may_be_the_system(tmp_path):
    text = f"package X {{ part def Yard {{ part def Drone {{ part battery {{ {DATA} }} }} }} }}"
    assert named(one_file(tmp_path, text)) == {"battery": 1}
    assert named(one_file(tmp_path, text, system="X::Yard::Drone")) == {"battery": 1}
    used = text.replace("Yard {", "Yard { part drone : Drone;")
    assert named(one_file(tmp_path, used)) == {"drone.battery": 1}


def test_a_quoted_name_of_words_makes_a_name(tmp_path):
    text = f"package X {{ part s {{ part 'glucose meter' {{ {DATA} }} part 'a b' {{ part 'c/d' {{ {DATA} }} }} }} }}"
    assert named(one_file(tmp_path, text)) == {"glucose_meter": 1, "a_b.c_d": 1}
    with pytest.raises(HardwareError, match="duplicate component 'a_b'"):
        one_file(
            tmp_path, f"package X {{ part s {{ part 'a b' {{ {DATA} }} part a_b {{ {DATA} }} }} }}"
        )


def test_values_may_stand_in_the_order_of_their_features(tmp_path):
    text = """package X {
        private import RiskMetadata::*; private import TraceriskHardware::*; private import SI::*;
        part s {
            part a { @Risk { totalRisk = new RiskLevel(0.3, 0.7); } }
            part b { @FailureData { weibull = new Weibull(2, 3000 [h]); } }
        }
    }"""
    a, b = one_file(tmp_path, text).components
    assert a.figures[0].value == 0.3
    assert b.figures[0].shape == 2.0
    for bad, message in (
        ("(0.3, impact = 0.7)", "or all of them in their order: probability, impact"),
        ("(0.3, 0.7, 0.1)", "a value without its name"),
    ):
        with pytest.raises(HardwareError, match=message):
            one_file(tmp_path, text.replace("(0.3, 0.7)", bad))


RISK = "@Risk { totalRisk { probability = 1e-6; } }"


@pytest.mark.parametrize(
    ("definition", "metadata", "required"),
    [
        ("metadata def Redundancy { attribute redundant : Boolean; }", "@Redundancy { redundant = true; } " + RISK, 1),
        ("metadata def Redundancy { attribute required : Integer; attribute redundant = true; }", "@Redundancy { required = 2; } " + RISK, 2),
        ("metadata def RedundantRisk :> Risk { attribute redundancy : Boolean; }", RISK.replace("@Risk", "@RedundantRisk").replace("} }", "} redundancy = true; }"), 1),
        ("metadata def Twin { attribute isRedundant : Boolean default true; }", "@Twin; " + RISK, 1),
    ],
)  # fmt: skip
@pytest.mark.parametrize("is_inherited", [False, True])
def test_redundancy_of_others_that_says_the_same_is_read(
    tmp_path, definition, metadata, required, is_inherited
):
    own, of = ("", metadata) if is_inherited else (metadata, "")
    text = f"""package X {{
        private import RiskMetadata::*; private import ScalarValues::*;
        {definition}
        part def D {{ {of} }}
        part s {{ part p : D [3] {{ {own} }} }}
    }}"""
    hardware = one_file(tmp_path, text)
    (component,) = hardware.components
    assert component.redundancy.is_redundant
    assert component.redundancy.required == required
    (warning,) = hardware.warnings
    assert warning.endswith("' on 'p' is read as Redundancy of TraceriskHardware")
    assert warning.startswith(f"m.sysml:{4 if is_inherited else 5}:")


@pytest.mark.parametrize(
    ("definition", "metadata"),
    [
        ("metadata def Redundancy { attribute scheme : String; }", '@Redundancy { scheme = "2oo3"; }'),
        ("metadata def Redundancy { attribute redundant : Integer; }", "@Redundancy { redundant = 2; }"),
        ("metadata def Safe { attribute redundancyDegree : Integer; }", "@Safe { redundancyDegree = 2; }"),
        ("metadata def Redundancy;", "@Redundancy;"),
    ],
)  # fmt: skip
def test_redundancy_of_others_that_says_something_else_is_reported(tmp_path, definition, metadata):
    text = f"""package X {{
        private import RiskMetadata::*; private import ScalarValues::*;
        {definition}
        part s {{ part p [3] {{ {RISK} {metadata} }} }}
    }}"""
    hardware = one_file(tmp_path, text)
    (component,) = hardware.components
    assert not component.redundancy.is_redundant
    (warning,) = hardware.warnings
    assert warning.startswith("m.sysml:4:")
    assert "' on 'p' is not read, so that every unit of it is needed; state its" in warning


def test_ours_goes_before_redundancy_of_others(tmp_path):
    text = f"""package X {{
        private import RiskMetadata::*;
        metadata def Spares {{ attribute redundant; }}
        part s {{ part p [3] {{ {RISK} @Spares {{ redundant = true; }}
            @TraceriskHardware::Redundancy {{ required = 2; }} }} }}
    }}"""
    hardware = one_file(tmp_path, text)
    assert hardware.components[0].redundancy.required == 2
    assert hardware.warnings == ()


def test_other_features_of_metadata_definitions_change_nothing(tmp_path):
    text = f"""package X {{
        private import RiskMetadata::*;
        metadata def Reviewed :> Risk {{ attribute auditor; }}
        part s {{ part p {{ {RISK.replace("@Risk", "@Reviewed").replace("} }", '} auditor = "QA"; }')} }} }}
    }}"""
    assert one_file(tmp_path, text).components[0].figures[0].value == 1e-6
    with pytest.raises(HardwareError, match="Risk has no feature 'auditors'"):
        one_file(tmp_path, text.replace("} auditor =", "} auditors ="))


def test_a_part_of_no_units_is_left_out(tmp_path):
    hardware = one_file(
        tmp_path,
        f"package X {{ part r {{ part a {{ {DATA} }} part b [0] {{ {DATA} part c {{ {DATA} }} }} }} }}",
    )
    assert named(hardware) == {"a": 1}
    assert [line.partition(": ")[2] for line in hardware.warnings] == [
        f"'{name}' has the multiplicity 0 here, and is left out" for name in "bc"
    ]


def test_a_name_that_begins_with_a_digit_becomes_one_of_a_component(tmp_path):
    text = f"package X {{ part r {{ part '4cyl engine' {{ {DATA} }} }} }}"
    assert named(one_file(tmp_path, text)) == {"_4cyl_engine": 1}


def test_imports_and_risks_of_behaviour_that_another_package_brings_lead_to_nothing(tmp_path):
    text = f"""package Steps {{
        public import Usages::*;
        package Usages {{ action 'provide power' {{ }} }}
    }}
    package X {{
        private import RiskMetadata::*;
        private import Steps::*;
        private import Steps::'provide power'::*;
        analysis tradeOff {{ }}
        @Risk about tradeOff::engine {{ totalRisk = RiskLevelEnum::medium; }}
        part r {{ part a {{ {DATA} }} }}
    }}"""
    assert named(one_file(tmp_path, text)) == {"a": 1}
    lost = text.replace(
        "@Risk about tradeOff::engine { totalRisk = RiskLevelEnum::medium; }",
        "metadata TraceriskHardware::FailureData about tradeOff { probability = 1e-6; }",
    )
    with pytest.raises(HardwareError, match="unknown name 'tradeOff'"):
        one_file(tmp_path, lost)
    other = one_file(tmp_path, text.replace("Steps::'provide power'", "Steps::'provide powers'"))
    assert "'Steps' has no 'provide powers'" in str(other.warnings)


def test_failure_data_of_no_part_of_the_system_is_reported(tmp_path):
    text = f"""package X {{
        part cell {{ part arm {{ {DATA} }} }}
        part def Cart {{ part wheel {{ {DATA} }} part drive {{ {DATA} }} }} }}"""
    hardware = one_file(tmp_path, text)
    assert named(hardware) == {"arm": 1}
    assert hardware.warnings == (
        "m.sysml:3:30: 'X::Cart::wheel' has failure data, but is no part of the system 'cell', "
        "nor are 1 more with failure data; name the system by --system, or make it a part",
    )
    assert one_file(tmp_path, text, system="cell").warnings == ()


def test_of_several_systems_those_that_can_be_read_are_named_first(project):
    folder = project(
        {
            "cell.sysml": f"package Cell {{ part cell {{ part arm {{ {DATA} }} }} }}",
            "cart.sysml": "package Cart { part cart : Lost; }",
        }
    )
    with pytest.raises(HardwareError, match=r"several parts .*: 'cell' .*, 'cart' "):
        read_sysml(folder)
    assert named(read_sysml(folder, system="cell")) == {"arm": 1}
