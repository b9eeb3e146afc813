import ast
import types
from collections import OrderedDict

import pytest

from tracerisk.ros.imports.exported import defined, exported
from tracerisk.ros.imports.finder import STAND_INS, StandInFinder


def test_a_module_of_imports_gives_them_without_the_modules_that_came_along():
    names = {"__name__": "arm", "_own": 1, "LIMIT": 2, "Dict": OrderedDict, "ast": ast}
    assert exported(names) == ["Dict", "LIMIT"]
    assert exported(names, "ast") == ["Dict", "LIMIT", "ast"]


def test_a_module_that_defines_what_it_gives_leaves_out_what_it_uses():
    module = types.ModuleType("arm")
    source = """
from collections import OrderedDict

LIMIT = 2

class Arm: pass

def move(): pass

def _check(): pass

shift = lambda: None
"""
    exec(source, vars(module))
    assert defined(vars(module)) == ["Arm", "move", "shift"]
    assert defined(vars(module), "LIMIT") == ["Arm", "LIMIT", "move", "shift"]


@pytest.mark.parametrize(
    "name",
    sorted(
        ".".join(path.relative_to(STAND_INS).with_suffix("").parts).removesuffix(".__init__")
        for path in STAND_INS.rglob("*.py")
        if "exported import" in path.read_text(encoding="utf-8")
        if path.relative_to(STAND_INS).parts[0] in ("genpy", "rospkg", "roslib", "tf2_py", "PyKDL")
    ),
)
def test_each_name_of_such_a_list_is_there(name):
    with StandInFinder():
        names: dict[str, object] = {}
        exec(f"import {name} as module", names)
        module = names["module"]
        assert module.__all__
        assert all(hasattr(module, each) for each in module.__all__)
        assert not {"Any", "annotations", "exported", "defined"} & set(module.__all__)
