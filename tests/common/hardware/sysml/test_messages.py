"""Each mistake in a SysML v2 file is told with its place and with what was expected."""

import pytest

from tracerisk.common.hardware.sysml.sysml_reader import read_sysml
from tracerisk.errors import HardwareError

HEAD = (
    "private import SI::*; private import TraceriskHardware::*; private import RiskMetadata::*;\n"
)
DATA = "@FailureData { probability = 0.1; }"

NOTATION = {
    "no semicolon": ("part a\npart b;", "1:7: expected ';' or '{' at the end of this line, before 'part'"),
    "no value": ("part a { attribute x = ; }", "1:24: expected a value: a number, a text in double quotes, true, false or a name, found ';'"),
    "open brace": ("part a {\n  part b {\n}", "1:8: unclosed '{'; expected '}' before the end of the file"),
    "closed twice": ("part a { } }", "1:12: unmatched '}'; remove it"),
    "open text": ('part a {\n  doc "x', "2:7: this text is never closed; expected '\"' at its end"),
    "open name": ("part 'a b {}", "1:6: this quoted name is not closed; expected \"'\" on the same line"),
    "open comment": ("part a;\n/* to do", "2:1: unclosed comment; expected '*/'"),
    "a word as a name": ("part port;", "1:6: 'port' is a word of SysML v2; expected a name; as a name it has to stand in single quotes"),
    "a misspelt word": ("packag A {}", "1:8: expected ';' or '{', found 'A'; did you mean 'package'?"),
    "a strange sign": ("part a;\npart b $;", "2:8: '$' ($) is not allowed here; remove it"),
    "two equals": ("part a { attribute x == 1; }", "1:22: expected ';' or '{', found '=='; a value is given with one '='"),
    "a decimal comma": ("part a { attribute x = 0,5; }", "1:25: expected ';' or '{', found ','; a number has a decimal point, not a comma"),
    "a comment within": ("part a /* left */ : B;", "1:8: expected ';' or '{', found a comment; '/* ... */' is an element of its own in SysML v2: use '// ...' within one"),
    "an open multiplicity": ("part a [2;", "1:10: expected ']', found ';'"),
    "no type": ("part a : ;", "1:10: expected a name, found ';'"),
    "open brackets": ("part a { attribute x = (1, 2; }", "1:29: expected ')' or ',', found ';'"),
    "no name after scope": ("import A::;", "1:11: expected a name, found ';'"),
    "the end too early": ("package A", "1:10: the file ends too early; expected ';' or '{'"),
    "an action without end": ("part a;\naction b", "2:1: this 'action' has no end; expected ';' or '{ ... }'"),
    "metadata without body": ("part a { @Risk probability = 1; }", "1:16: expected ';' or '{', found 'probability'"),
}  # fmt: skip

MEANING = {
    "nothing": ("part a;", "1:1: no part has failure data"),
    "two systems": (f"part a {{ {DATA} }}\npart b {{ {DATA} }}", "3:6: several parts could be the system as a whole: 'a' (line 2), 'b' (line 3)"),
    "not imported": ("package M { part a {\n @FailureData; } }", "2:3: 'FailureData' is not imported; add 'private import TraceriskHardware::*;'"),
    "unknown metadata": ("part a {\n @FailurData; }", "3:3: unknown name 'FailurData'; declare or import"),
    "unknown import": (f"private import Motors::*; part a : Motor {{ {DATA} }}", "2:16: unknown name 'Motors'; declare it in this file or"),
    "unknown type": (f"part def Motor; part a {{ {DATA} part b : Moter; }}", "2:71: unknown name 'Moter'; declare or import it; did you mean 'Motor'?"),
    "unknown feature": ("part a {\n @FailureData { probabilty = 0.1; } }", "3:17: FailureData has no feature 'probabilty'; did you mean 'probability'?"),
    "no figure": ("part a {\n @FailureData; }", "3:3: FailureData gives no figure; give one of: probability, rate, weibull"),
    "two figures": ("part a {\n @FailureData { probability = 0.1; rate = 1 [FIT]; } }", "3:43: FailureData gives 'probability' and 'rate'"),
    "too large": ("part a { @FailureData {\n probability = 1.5; } }", "3:16: FailureData.probability: 1.5 is outside [0, 1]"),
    "a text for a number": ('part a { @FailureData {\n probability = "1e-7"; } }', '3:16: FailureData.probability: expected a number, found the string "1e-7"'),
    "a rate without unit": ("part a { @FailureData {\n rate = 1e-7; } }", "3:9: FailureData.rate: expected a rate with its unit, such as 5.7e-6 [h^-1] or 570 [FIT], found the number 1e-07 without a unit"),
    "a time for a rate": ("part a { @FailureData {\n rate = 1e-7 [h]; } }", "3:9: FailureData.rate: expected a rate with its unit"),
    "another unit": ("part a { @FailureData {\n rate = 1e-7 [kg]; } }", "3:15: not a supported unit; allowed: h, min, s, d"),
    "another word": ("part a { @FailureData { probability = 0.1;\n per = Basis::year; } }", "3:8: 'Basis' has no 'year'; allowed: demand, hour, minute, visit"),
    "a word of another kind": ("part a { @FailureData { probability = 0.1;\n per = Use::start; } }", "3:8: FailureData.per: expected a Basis, found TraceriskHardware::Use::start; allowed: Basis::demand"),
    "a demand per hour": ("part a { @FailureData { probability = 0.1; per = Basis::hour;\n demand = Use::start; } }", "3:11: FailureData.demand: applies to demands, but the figure is per hour"),
    "redundant units in several": (f"part r {{ part arm [2] {{ part psu [2] {{ {DATA}\n @Redundancy {{ redundant = true; }} }} }} }}", "3:3: 'psu' is a redundant group in several parts 'arm'; declare each of these"),
    "repair without redundancy": (f"part a {{ {DATA}\n @Redundancy {{ repairTime = 8 [h]; }} }}", "3:29: Redundancy.repairTime: units that are all needed have no hidden failures; remove it"),
    "a repair of two kinds": (f"part a [2] {{ {DATA}\n @Redundancy {{ redundant = true; repairTime = 8 [h]; repairRate = 1 [h^-1]; }} }}", "3:67: Redundancy.repairRate: conflicts with 'repairTime'; remove one of the two"),
    "a repair without a time": (f"part a [2] {{ {DATA}\n @Redundancy {{ redundant = true; repairInMission = true; }} }}", "3:52: Redundancy.repairInMission: needs the time of a repair; write 'repairTime = 8 [h]' too"),
    "a repair of rate 0": (f"part a [2] {{ {DATA}\n @Redundancy {{ redundant = true; repairRate = 0 [h^-1]; }} }}", "3:47: Redundancy.repairRate: is 0; give a rate above 0"),
    "a repair in FIT": (f"part a [2] {{ {DATA}\n @Redundancy {{ redundant = true; repairRate = 1 [FIT]; }} }}", "3:47: Redundancy.repairRate: FIT is a unit of failures"),
    "a repair and a test": (f"part a [2] {{ {DATA} @TwinBinding {{ always = true; }}\n @Redundancy {{ redundant = true; repairTime = 1 [h]; testInterval = 8 [h]; }} }}", "3:3: a.repair: 'detected' says already when failed units are replaced"),
    "a lot of a system": (f"part a {{ part b {{ {DATA} }}\n @HardwareData {{ lot = \"A\"; }} }}", "3:24: HardwareData.lot: is of a part, not of the system as a whole"),
    "a lot of what is certain": (f"part a {{ part b {{ {DATA}\n @HardwareData {{ lot = \"A\"; }} }} }}", "3:3: b.lot: has no effect, because no figure"),
    "a second redundancy": (f"part a [2] {{ {DATA} @Redundancy {{ redundant = true; }}\n @Redundancy {{ redundant = true; }} }}", "3:3: duplicate Redundancy on 'a'; keep one"),
    "binding without figure": ("part r { part b { @FailureData { probability = 0.1; } } part a {\n @TwinBinding { gripper = true; } } }", "3:3: 'a' has TwinBinding but no failure data"),
    "an open range": (f"part r {{ part a [1..3] {{ {DATA} }} }}", "2:15: 'a' has 1 to 3 units; give one number"),
    "two second names": (f"part r {{ part a {{ {DATA} }}\n part a; }}", "3:7: 'a' is declared in line 2 already; write a multiplicity for several of it, or give it another name"),
    "redefines nothing": (f"part def A {{ part m; }} part r : A {{\n part :>> n {{ {DATA} }} }}", "3:11: redefines 'n', which its owner does not inherit; allowed: m"),
    "hides an inherited one": (f"part def A {{ part m {{ {DATA} }} }} part def B {{ part m; }} part r : A, B {{\n }}", "2:19: 'm' is inherited from line 2 already; write 'part :>> m' to redefine it"),
    "redefined twice": (f"part def A {{ part m {{ {DATA} }} }} part def B :> A {{ part w :>> m; }}\npart r : B {{ part :>> m; }}", "3:14: redefines the same part as 'w'; write 'part :>> w'"),
    "two sources": (f"part def A {{ {DATA} }} part def B {{ {DATA} }}\npart r : A, B;", "3:6: 'r' inherits FailureData from 'M::A' and 'M::B'; annotate it directly"),
    "a circle": (f"part def A :> B {{ {DATA} }} part def B :> A;\npart r : A;", "specialises itself"),
    "a part in itself": (f"part def A {{\n part a : A; {DATA} }} part r : A;", "3:7: a part contains itself,"),
    "a variation": (f"part r {{ {DATA}\n variation part m {{ {DATA} }} }}", "3:17: 'm' is a variation, so the parts are not fixed;"),
    "data on a reference": (f"part r {{ {DATA}\n ref part m {{ {DATA} }} }}", "3:11: 'm' is a reference, not a part; put the data where"),
    "data in what is skipped": (f"part r {{ {DATA}\n port p {{ part m {{ {DATA} }} }} }}", "3:21: 'FailureData' is inside 'port ...', which is not read;"),
    "data about an inherited part": (f"part def A {{ part m; }} part r : A {{ {DATA} }}\nmetadata FailureData about r::m {{ probability = 0.1; }}", "3:28: 'm' is inherited by 'r', and the data would apply to every part that inherits it;"),
    "a named multiplicity": (f"part r {{ {DATA} attribute n = 2;\n part m [n] {{ {DATA} }} }}", "3:9: 'n' is not a number of units; write the whole number itself"),
    "no bounds": (f"part r {{ {DATA}\n part m [2..1] {{ {DATA} }} }}", "3:9: a multiplicity of 2..1 allows no units;"),
    "an occurrence": (f"occurrence def o {{ part a {{ {DATA} }} }}", "FailureData' is inside 'occurrence ...', which is not read"),
    "a nested reference": (f"part def D {{ attribute def I {{ part a {{ {DATA} }} }} }}", "is of no part of a system; describe hardware by parts"),
    "a computed value": ("part r { @FailureData {\n probability = max(1, 2); } }", "3:16: unknown name 'max'; declare or import"),
    "a value without one": ("part r { attribute p; @FailureData {\n probability = p; } }", "3:16: 'p' has no value; give it one"),
    "a mode without a name": ("part r { @FailureData { rate = 1 [FIT]; }\n @FailureMode { fraction = 0.1; uses = Use::moving; } }", "3:3: a failure mode without a name; write 'metadata jam : FailureMode { ... }'"),
    "seen and always active": (f"part r {{ {DATA}\n @TwinBinding {{ always = true; gripper = true; }} }}", "3:42: TwinBinding.gripper: a component is either always active or bound to the twin;"),
    "sees nothing": (f"part r {{ {DATA}\n @TwinBinding {{ gripper = false; }} }}", "3:3: TwinBinding is empty; give joints, actuators, gripper, sensors,"),
    "required of too few": (f"part r [2] {{ {DATA}\n @Redundancy {{ required = 3; }} }}", "3:3: r.required: 3 must work, but the quantity is 2"),
    "not redundant": (f"part r [2] {{ {DATA}\n @Redundancy {{ commonCause = 0.1; }} }}", "3:30: Redundancy.commonCause: applies to redundant units;"),
    "no dormancy": (f"part r [2] {{ {DATA}\n @Redundancy {{ spare = Spare::warm; }} }}", "3:24: Redundancy.spare: a warm spare needs 'dormancy'"),
    "another exponent": ('part r { @TwinBinding { joints = "*"; } @FailureData { rate = 1 [FIT];\n loadLaw { referenceLoad = 1; wearingShare = 1; exponent = 5; } } }', "3:60: FailureData.loadLaw.exponent: 5 is not an exponent whose wear a run measures;"),
    "two risks": ("part r { @Risk { totalRisk { probability = 0.1; } }\n @Risk { totalRisk { probability = 0.1; } } }", "3:3: duplicate @Risk with a probability on 'r'"),
    "the same name twice": (f"part def A {{ }} part def A; part r {{ {DATA} part a : A; }}", "duplicate 'A', first in line 2"),
}  # fmt: skip


def message(folder, text: str) -> str:
    path = folder / "m.sysml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(HardwareError) as caught:
        read_sysml(path, shown="m.sysml")
    return str(caught.value)


@pytest.mark.parametrize("mistake", NOTATION)
def test_a_broken_file_is_reported_with_what_was_expected(tmp_path, mistake):
    text, expected = NOTATION[mistake]
    assert message(tmp_path, text) == f"m.sysml:{expected}"


@pytest.mark.parametrize("mistake", MEANING)
def test_a_description_that_means_nothing_is_reported_with_its_place(tmp_path, mistake):
    text, expected = MEANING[mistake]
    if not text.startswith("package M"):
        text = f"package M {{ {HEAD}{text}\n}}"
    found = message(tmp_path, text)
    if expected[0].isdigit():
        expected = f"m.sysml:{expected}"
    assert expected in found


def test_what_cannot_be_read_is_reported(tmp_path):
    with pytest.raises(HardwareError, match=r"absent\.sysml: cannot be read: No such file"):
        read_sysml(tmp_path / "absent.sysml", shown="absent.sysml")
    latin = tmp_path / "latin.sysml"
    latin.write_bytes(b"package A {\n// gr\xf6\xdfe\n}")
    with pytest.raises(HardwareError, match=r"latin\.sysml:2: is not UTF-8"):
        read_sysml(latin, shown="latin.sysml")
