"""Whatever a file holds, the reader answers with a description or a HardwareError, and soon."""

import random
import re
import time
from pathlib import Path

import pytest

from tracerisk.common.hardware.sysml.sysml_reader import read_sysml
from tracerisk.errors import HardwareError

EVERYTHING = Path(__file__).with_name("everything.sysml")
INSERTED = [
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    ";",
    ":",
    ":>",
    ":>>",
    "::",
    "*",
    "**",
    "=",
    "part",
    "def",
    "metadata",
    "about",
    "@",
    "#",
    "abstract",
    "ref",
    "import",
    "1",
    "1e400",
    "-1",
    "0",
    "'a'",
    '"s"',
    "//",
    "/*",
    "*/",
    "Motor",
    "Arm",
    "robot",
    "+",
    "^",
    "/",
    "new",
    "alias",
    "for",
    "0..1",
    "..",
    "variation",
    "default",
    "if",
    "not",
]


def mutated(draws: random.Random, pieces: list[str]) -> str:
    words = list(pieces)
    for _ in range(draws.choice([1, 1, 2, 5])):
        at = draws.randrange(len(words))
        kind = draws.randrange(4)
        if kind == 0:
            del words[at : at + draws.choice([1, 1, 3, 20])]
        elif kind == 1:
            words.insert(at, draws.choice(INSERTED) + " ")
        elif kind == 2:
            words[at] = draws.choice(INSERTED)
        else:
            other = draws.randrange(len(words))
            words[at], words[other] = words[other], words[at]
    return "".join(words)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("seed", range(4))
def test_a_mutated_file_is_read_or_refused_with_its_place(tmp_path, seed):
    draws = random.Random(seed)
    pieces = re.findall(r"\w+|\s+|.", EVERYTHING.read_text(encoding="utf-8"))
    path = tmp_path / "mutated.sysml"
    errors: list[HardwareError] = []
    for _ in range(30):
        path.write_text(mutated(draws, pieces), encoding="utf-8")
        try:
            assert read_sysml(path).components
        except HardwareError as error:
            errors.append(error)
    assert len(errors) > 15
    assert all(each.location is not None and each.location.line for each in errors)


def chain(count: int, line: str) -> str:
    return "\n".join(line.format(n=n, next=n + 1) for n in range(count))


DATA = "@TraceriskHardware::FailureData { probability = 0.1; }"
HOSTILE = {
    "braces": "part a {" * 20_000 + "}" * 20_000,
    "round brackets": "part a { @TraceriskHardware::FailureData { probability = "
    + "(" * 20_000 + "1" + ")" * 20_000 + "; } }",
    "signs": "part a { @TraceriskHardware::FailureData { probability = " + "- " * 20_001 + "1; } }",
    "a long sum": "part a { @TraceriskHardware::FailureData { probability = 2" + "+1" * 20_000 + "; } }",
    "powers": "part a { @TraceriskHardware::FailureData { probability = 9" + "^9" * 2_000 + "; } }",
    "a long number": "part a { @TraceriskHardware::FailureData { probability = " + "9" * 20_000 + "; } }",
    "a long name": "part a : " + "a::" * 20_000 + "b;",
    "long steps": "part a :> " + "a." * 20_000 + "b;",
    "definitions of one another": chain(3_000, "part def D{n} :> D{next};") + f"part a : D0 {{ {DATA} }}",
    "a circle of definitions": f"part def A :> B {{ {DATA} }} part def B :> A; part a : A;",
    "a part in itself": f"part def A {{ part a : A; {DATA} }} part b : A;",
    "doubled parts": chain(40, "part def D{n} {{ part a : D{next}; part b : D{next}; }}")
    + f"part def D40 {{ {DATA} }} part c : D0;",
    "imports of imports": chain(3_000, "package P{n} {{ public import P{next}::*; }}")
    + f"package Q {{ import P0::*; part a : Nothing {{ {DATA} }} }}",
    "a circle of imports": "package P { public import Q::*; } package Q { public import P::*; "
    f"part a : Nothing {{ {DATA} }} }}",
    "a circle of aliases": f"alias A for B; alias B for A; part a : A {{ {DATA} }}",
    "an alias in itself": f"alias A for A::B; part a : A {{ {DATA} }}",
    "a circle of values": "part a { attribute x = y; attribute y = x; "
    "@TraceriskHardware::FailureData { probability = x; } }",
    "multiplicities": "part a [999999999] { part b [999999999] { part c [999999999] {"
    f"{DATA} @TraceriskHardware::TwinBinding {{ joints = (\"a\", \"b\"); }} }} }} }}",
    "a swallowed file": "action a {" + "{" * 50_000,
    "nothing": "",
    "no text": "\x00\x01",
}  # fmt: skip


@pytest.mark.slow(but=7)
@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_refused_in_time(tmp_path, name):
    path = tmp_path / "hostile.sysml"
    path.write_text(HOSTILE[name], encoding="utf-8")
    begin = time.process_time()
    with pytest.raises(HardwareError) as caught:
        read_sysml(path)
    assert time.process_time() - begin < 10.0
    assert caught.value.location is not None
    assert len(str(caught.value)) < 600


def test_the_time_of_reading_grows_with_the_number_of_parts(tmp_path):
    def seconds(parts: int) -> float:
        path = tmp_path / f"{parts}.sysml"
        lines = "\n".join(f"part p{n} {{ {DATA} }}" for n in range(parts))
        path.write_text(f"part plant {{ {lines} }}", encoding="utf-8")
        taken = []
        for _ in range(3):
            began = time.process_time()
            assert len(read_sysml(path).components) == parts
            taken.append(time.process_time() - began)
        return min(taken)

    seconds(10)
    assert seconds(1_000) < 12 * seconds(200)


def test_of_thousands_of_names_a_message_lists_the_nearest_and_some(tmp_path):
    path = tmp_path / "many.sysml"
    path.write_text("\n".join(f"part def P{i};" for i in range(3_000)) + "\npart a : P2999x;\n")
    with pytest.raises(HardwareError, match=r"did you mean 'P2999'.* and 2,95[0-9] more") as caught:
        read_sysml(path)
    assert len(str(caught.value)) < 600
