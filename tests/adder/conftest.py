from collections.abc import Callable, Mapping
from textwrap import dedent

import pytest

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.grammar import parse_block
from tracerisk.adder.blocks.lines import BlockLine
from tracerisk.adder.blocks.values import (
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
)
from tracerisk.common.hardware.redundancy import Redundancy

BlockMaker = Callable[..., RiskBlock]
BlockReader = Callable[[str], RiskBlock]


def _make_block(
    name: str = "place",
    sequence: int = 5,
    following: Mapping[str, int] | None = None,
    **probabilities: float,
) -> RiskBlock:
    components = tuple(
        ComponentEntry(
            component,
            computed_probability(probability),
            computed_count(1),
            computed_redundancy(Redundancy(False)),
        )
        for component, probability in (probabilities or {"gripper": 7.344e-08}).items()
    )
    return RiskBlock(
        name, computed_count(sequence), computed_next(following or {"done": 10}), components
    )


def _read_block(text: str) -> RiskBlock:
    lines = dedent(text).strip("\n").split("\n")
    return parse_block([BlockLine(n, line) for n, line in enumerate(lines, start=1)], "c.py")


@pytest.fixture
def make_block() -> BlockMaker:
    """Return a block as the tool computes it; keyword arguments are components."""
    return _make_block


@pytest.fixture
def read_block() -> BlockReader:
    """Return the block that a text without gutter states, in a file called c.py."""
    return _read_block
