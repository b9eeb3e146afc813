"""Blocks as Hypothesis draws them: all that either form can say."""

from hypothesis import strategies as st

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.failures import read_failures
from tracerisk.adder.blocks.values import (
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
    read_redundancy,
)
from tracerisk.common.hardware.redundancy import Redundancy

words = st.text(
    st.characters(codec="utf-8", categories=("L", "N", "P", "S")), min_size=1, max_size=12
)
reasons = st.none() | st.lists(words, min_size=1, max_size=30).map(" ".join)
names = st.from_regex(
    r"[A-Za-z_][A-Za-z_0-9]{0,8}(\.(<locals>\.)?[a-z_]{1,5}){0,2}", fullmatch=True
)
function_names = names | st.sampled_from(
    [
        "<module>",
        "MoveTo (tray 2)",
        "Arm::operator->",
        "operator=",
        "->",
        "@f",
        "quantity",
        '"f"',
    ]
)
component_names = names | st.sampled_from(
    [
        "left gripper",
        "1 of 2",
        ":=",
        "add",
        "probability",
        '"',
        "@arm",
        "->",
        "=======",
        "power:= 1",
    ]
)
probabilities = st.floats(0, 1).map(computed_probability) | st.sampled_from(
    [Field(2e-7, "2.000E-7"), Field(0.5, ".5"), Field(1.0, "1.")]
)
counts = st.integers(1, 10**9).map(computed_count)
flags = st.booleans().map(Redundancy).map(computed_redundancy) | st.sampled_from(
    [
        Field(read_redundancy(text), text)
        for text in (
            "required 2",
            "true, common_cause 0.1",
            "true, spare cold, detected each_visit",
            "required 1",
            "required 3, spare warm 1e-1, switch .001, common_cause .05",
        )
    ]
)


@st.composite
def pinned(draw, plain):
    field = draw(plain)
    if draw(st.booleans()):
        return field
    computed = draw(st.none() | st.just("none") | plain.map(lambda other: other.text))
    return Field(field.value, field.text, True, computed, draw(reasons))


@st.composite
def transitions(draw):
    targets = draw(st.lists(function_names, min_size=1, max_size=4, unique=True))
    return computed_next({target: draw(st.integers(1, 50)) for target in targets})


modes = st.sampled_from(["dead", "no power", "1/2", "stuck(half)"])
kinds = st.sampled_from(["stopped safely", "stopped late", "unaware"])


@st.composite
def failure_modes(draw):
    said = []
    for name in draw(st.lists(modes, min_size=1, max_size=3, unique=True)):
        outcomes = draw(
            st.lists(
                st.tuples(
                    kinds | function_names.map(lambda target: f"back to {target}"),
                    st.just("") | function_names.map(lambda later: f" in {later}"),
                ),
                min_size=1,
                max_size=3,
                unique=True,
            )
        )
        share = f"1/{len(outcomes)}"
        parts = [f"{kind}{later} {share}" for kind, later in outcomes]
        said.append(f"{name} {draw(st.sampled_from(['1/4', '.1', '0.25']))}: {', '.join(parts)}")
    text = " | ".join(said)
    return Field(read_failures(text), text)


@st.composite
def components(draw):
    mark = draw(st.sampled_from(["", "added", "omitted"]))
    stated = mark != "omitted" or draw(st.booleans())
    return ComponentEntry(
        draw(component_names),
        draw(pinned(probabilities)) if stated else Field(0.0, ""),
        draw(pinned(counts)) if stated else Field(1, ""),
        draw(pinned(flags)) if stated else Field(Redundancy(False), ""),
        added=mark == "added",
        omitted=mark == "omitted",
        reason=draw(reasons) if mark else None,
        failures=draw(st.just(Field((), "")) | pinned(failure_modes())),
    )


@st.composite
def blocks(draw):
    added = draw(st.booleans())
    return RiskBlock(
        draw(function_names),
        draw(pinned(counts)),
        draw(st.none() | pinned(transitions())),
        tuple(draw(st.lists(components(), max_size=4, unique_by=lambda entry: entry.name))),
        added=added,
        reason=draw(reasons) if added else None,
    )
