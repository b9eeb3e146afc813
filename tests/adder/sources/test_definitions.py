"""Where functions stand in a source, and that a search for them can be ended."""

import ast

import pytest
from libcst.metadata.position_provider import WhitespaceInclusivePositionProvidingCodegenState

from tracerisk.adder.sources.positions import function_sites
from tracerisk.instrument.source.function_definitions import MODULE, function_at

SOURCE = """\
import arm
@arm.named(
    "outer"
)
def outer(x):
    if x:
        class Cell:
            def pick(self): pass
            y = [
                lambda: 1,
            ]
    else:
        try:
            async def inner():
                return 1
        except ValueError:
            def handler(): return 2
        finally:
            with x:
                pass
    match x:
        case 1:
            def first():
                pass
        case _:
            def other():
                return [
                    1,
                ]
    return x
"""
AT = {
    "<module>": (1, 2, 4, 31),
    "outer": (5, 7, 10, 16, 20, 22, 25, 30),
    "outer.<locals>.Cell.pick": (8,),
    "outer.<locals>.inner": (14, 15),
    "outer.<locals>.handler": (17,),
    "outer.<locals>.first": (23, 24),
    "outer.<locals>.other": (26, 28, 29),
}


def test_a_line_is_in_the_innermost_function_around_it():
    tree = ast.parse(SOURCE)
    for name, lines in AT.items():
        assert {str(function_at(tree, line)) for line in lines} == {name}
    assert function_at(ast.parse(""), 1) == MODULE


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit(143)])
def test_who_ends_a_search_for_functions_ends_it(monkeypatch, error):
    """Libcst hides behind a KeyError of its own what is raised while it looks for positions."""

    def ended(*_):
        raise error

    monkeypatch.setattr(WhitespaceInclusivePositionProvidingCodegenState, "add_token", ended)
    with pytest.raises(BaseException) as raised:  # noqa: PT011 - what it is follows
        function_sites(b"def to_be_ended():\n    return 1\n")
    assert raised.type in (KeyboardInterrupt, SystemExit)
