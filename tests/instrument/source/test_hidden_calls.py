"""Calls that may command by a name that nobody can read."""

import ast
import textwrap

import pytest

from tracerisk.instrument.source.hidden_calls import hidden_calls

MOTION = {"go", "execute"}


def hidden(source: str) -> list[str]:
    return [ast.unparse(call) for call in hidden_calls(ast.parse(textwrap.dedent(source)), MOTION)]


@pytest.mark.parametrize(
    "source",
    [
        "getattr(arm, name)()",
        "getattr(arm, 'g' + 'o')(wait=True)",
        "getattr(arm, f'{verb}')()",
        "move = getattr(arm, name)\nmove()",
        "move = arm.go\nmove()",
        "self.move = arm.go if fast else arm.execute\nself.move()",
        "(move := arm.go)\nmove()",
        "table = {'a': arm.go}\ntable[key]()",
        "table = {'a': arm.go}\ntable.get(key)()",
        "[arm.go, arm.stop][0]()",
        "operator.methodcaller(name)(arm)",
        "arm.__getattribute__(name)()",
        "Thread(target=getattr(arm, name)).start()",
        "exec(text)",
        "eval('arm.go()')",
        "importlib.import_module(name)",
    ],
)
def test_what_may_command_by_another_name_is_found(source):
    assert len(hidden(source)) == 1


@pytest.mark.parametrize(
    "source",
    [
        "arm.go()",
        "getattr(arm, 'get_' + 'name')()",
        "value = getattr(message, field)",
        "float(getattr(message, field))",
        "getattr(self, 'on_' + state)()",
        "import tasks\ngetattr(tasks, name)()",
        "stop = arm.stop\nstop()",
        "eval('1 + 2')",
        "model.eval()",
        "importlib.import_module('numpy')",
        "target = arm.go",
    ],
)
def test_what_is_read_or_cannot_command_is_not(source):
    assert hidden(source) == []
