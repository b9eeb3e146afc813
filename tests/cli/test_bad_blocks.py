"""A bad block is told with its place and what is allowed, by every verb, and nothing is written."""

from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.cli import main

STEPS = "def home(arm):\n    arm.go()\n\n\ndef place(arm):\n    arm.go()\n"
LOG = """\
Function:home()
ActiveComponents:motor
Function:place()
ActiveComponents:motor

CallSequence:home(),place()
"""
HARDWARE = """\
components:
  motor: {probability: {value: 9.5e-08, per: visit}, quantity: 7, twin: {joints: "*"}}
"""
MOTOR = """\
    # | @Component {
    # |   name = motor
    # |   probability = 9.5e-08
    # |   quantity = 7
    # |   redundancy = false
    # | }
"""
NEXT = "next = place 1\n"

# What is changed in the block of `home`, the line that is told, and what the message says.
BAD = {
    "a missing brace": (
        "    # | }\n",
        "",
        7,
        "begins before the section of line 3 is closed; write",
    ),
    "a missing last brace": (MOTOR, MOTOR[: -len("    # | }\n")], 8, "of this line has no `}`"),
    "two names": (
        "name = home\n",
        "name = home\n    # |   name = place\n",
        5,
        "duplicate name, first at line 4; delete one",
    ),
    "no name": ("    # |   name = home\n", "", 3, "this `@Function` has no `name = ` line"),
    "a probability above 1": (
        "probability = 9.5e-08",
        "probability = 1e3",
        10,
        "probability = 1e3 is not allowed; allowed: a probability from 0 to 1, such as 7.344e-08",
    ),
    "a probability set by hand above 1": (
        "probability = 9.5e-08",
        "probability := 1e3  ! FMEA-112",
        10,
        "probability = 1e3 is not allowed; allowed: a probability from 0 to 1",
    ),
    "a quantity of 0": (
        "quantity = 7",
        "quantity = 0",
        11,
        "quantity = 0 is not allowed; allowed: a whole number from 1 up",
    ),
    "a redundancy that is none": (
        "redundancy = false",
        "redundancy = maybe",
        12,
        "redundancy = maybe is not allowed; allowed: true, false",
    ),
    "an unknown key": (
        "quantity = 7",
        "quantty = 7",
        11,
        "unknown key quantty in `@Component`; did you mean 'quantity'? allowed: name, probability,",
    ),
    "an unknown section": (
        "@Component {",
        "@Part {",
        8,
        "cannot read `@Part {`; allowed: @Function {, @Function := {, @Component {",
    ),
    "a component twice": (
        MOTOR,
        MOTOR * 2,
        14,
        "duplicate component motor in this block, first",
    ),
    "a next to no function": (
        NEXT,
        "next = plaec 1\n",
        6,
        "leads to 'plaec', ",
        "did you mean 'place'? allowed: done, home, place",
    ),
    "a next set by hand to no function": (
        NEXT,
        "next := plaec 1  ! the plan\n",
        6,
        "leads to 'plaec', ",
        "did you mean 'place'? allowed: done, home, place",
    ),
    "a next that does not sum to one": (
        NEXT,
        "next = place 1/2\n",
        6,
        "next = place 1/2 is not allowed; allowed: shares that sum to 1, and not to 1/2",
    ),
    "a target twice": (
        NEXT,
        "next = place 1/2\n    # |   next = place 1/2\n",
        6,
        "allowed: one `next` line for each target, and not two for place",
    ),
    "conflict markers": (
        "    # |   quantity = 7\n",
        "<<<<<<< HEAD\n    # |   quantity = 7\n=======\n    # |   quantity = 6\n>>>>>>> theirs\n",
        11,
        "`<<<<<<< HEAD` is a conflict marker; resolve the merge (keep either side of a risk block: "
        "`tracerisk refresh ",
    ),
    "conflict markers behind the gutter": (
        "    # |   quantity = 7\n",
        "    # | <<<<<<< HEAD\n    # |   quantity = 7\n    # | =======\n    # | >>>>>>> theirs\n",
        11,
        "`<<<<<<< HEAD` is a conflict marker in a risk block; resolve the merge",
    ),
    "a block under another function": (
        "name = home\n",
        "name = place\n",
        2,
        "the risk block of `place` stands at `home`; write `name = home`, there and in what",
    ),
    "a block in the middle of a function": (
        "    # | RiskAnnotation ",
        "    arm.stop()\n    # | RiskAnnotation ",
        3,
        "a risk block stands where no function begins; allowed: the first lines of a function's",
    ),
    "a block in two parts": (
        "    # | @Component {\n",
        "\n    # | @Component {\n",
        9,
        "is outside a risk block; a block begins with `# | RiskAnnotation`",
    ),
    "a reason for a computed value": (
        "quantity = 7",
        "quantity = 7  ! six of them are in use",
        11,
        "a reason is allowed only for a value set by hand; write `quantity := `",
    ),
}

VERBS = {
    "run": ("run", "cell.py", "--robot", "panda"),
    "annotate": ("annotate", "cell.py", "--log", "run.log", "--hardware", "arm.yaml"),
    "check": ("check", "cell.py"),
    "refresh": ("refresh", "cell.py"),
    "build": ("build", "cell.py"),
    "overrides": ("overrides", "cell.py"),
}
# These do not follow where blocks lead, and leave it to those that do.
BUT = {("overrides", name) for name in BAD if name.startswith("a next ") and "no function" in name}


@pytest.fixture(scope="module")
def annotated(tmp_path_factory) -> dict[str, bytes]:
    """The files of a controller annotated from a log."""
    folder = tmp_path_factory.mktemp("annotated")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path("cell.py").write_text(STEPS)
        Path("run.log").write_text(LOG)
        Path("arm.yaml").write_text(HARDWARE)
        assert main([*VERBS["annotate"], "--quiet"]) == 0
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def files() -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in Path().iterdir() if path.is_file()}


@pytest.mark.parametrize(
    ("verb", "known"),
    slow_but(
        [*((verb, True) for verb in VERBS), ("check", False)],
        [(verb, known) for verb in VERBS for known in (True, False)],
    ),
    ids={True: "known to the lock", False: "without a lock"}.get,
)
@pytest.mark.parametrize("name", BAD)
def test_a_bad_block(name, verb, known, annotated, tmp_path, monkeypatch, capfd) -> None:
    if (verb, name) in BUT:
        pytest.skip("the list of what was set by hand follows no next")
    before, after, line, *reported = BAD[name]
    monkeypatch.chdir(tmp_path)
    for file, data in annotated.items():
        if known or file != "tracerisk.lock":
            Path(file).write_bytes(data)
    text = Path("cell.py").read_text()
    assert before in text
    Path("cell.py").write_text(text.replace(before, after, 1))
    found = files()
    # A reason for a computed value is an edit by hand, as the value without one would be.
    code = 3 if name == "a reason for a computed value" else 2
    assert main([*VERBS[verb]]) == code
    out, err = capfd.readouterr()
    assert f"cell.py:{line}: " in out + err
    for part in reported:
        assert part in out + err
    assert files() == found


def test_two_blocks_of_one_function_are_reported_with_both_places(
    annotated, tmp_path, monkeypatch, capfd
) -> None:
    monkeypatch.chdir(tmp_path)
    text = annotated["cell.py"].decode()
    block = text[text.index("    # | Risk") : text.index("    arm.go()")]
    Path("cell.py").write_text(text.replace(block, block * 2, 1))
    for verb in ("check", "build"):
        assert main([*VERBS[verb]]) == 2
        out, err = capfd.readouterr()
        assert "cell.py:14: home has two risk blocks, the first at line 2; delete one" in out + err
