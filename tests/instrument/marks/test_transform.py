import ast
import dis
import inspect
import os
import sys
import textwrap
from pathlib import Path
from types import CodeType

import pytest

from tests.slow import slow_but_every
from tracerisk.errors import SourceError
from tracerisk.instrument.marks.calls import MARK
from tracerisk.instrument.marks.caught_exceptions import CAUGHT
from tracerisk.instrument.marks.decorators import instrument_source
from tracerisk.instrument.marks.endless_loops import MARKER
from tracerisk.instrument.marks.instrumented import DECORATOR
from tracerisk.instrument.transform import compile_instrumented

IMPORT = "from __tracerisk__ import traced as __tracerisk_traced__"


def assert_instrumented(before: str, after: str) -> None:
    source = textwrap.dedent(before).lstrip("\n").encode()
    expected = textwrap.dedent(after).lstrip("\n").replace("@IMPORT", IMPORT)
    expected = expected.replace("@(", "@__tracerisk_traced__('c.py', ")
    instrumented = instrument_source(source, "c.py")
    assert expected == instrumented.text
    compile_instrumented(instrumented, "c.py")


def test_function_gets_the_decorator_and_the_module_its_import() -> None:
    assert_instrumented(
        """
        def pick():
            pass
        """,
        """
        @IMPORT
        @('pick', 1)
        def pick():
            pass
        """,
    )


def test_import_follows_docstring_and_future_imports() -> None:
    assert_instrumented(
        """
        #!/usr/bin/env python3
        '''A ''' 'controller.'
        from __future__ import annotations
        from __future__ import division; import os
        import sys

        async def pick(): ...
        """,
        """
        #!/usr/bin/env python3
        '''A ''' 'controller.'
        from __future__ import annotations
        from __future__ import division; import os
        @IMPORT
        import sys

        @('pick', 7)
        async def pick(): ...
        """,
    )


def test_decorator_stands_closest_to_the_def() -> None:
    assert_instrumented(
        """
        class Node:
            @property
            # the goal
            def goal(self):
                def inner(): return 1
                return inner()

            class Arm:
                @staticmethod
                def go(): pass
        """,
        """
        @IMPORT
        class Node:
            @property
            @('Node.goal', 4)
            # the goal
            def goal(self):
                @('Node.goal.<locals>.inner', 5)
                def inner(): return 1
                return inner()

            class Arm:
                @staticmethod
                @('Node.Arm.go', 10)
                def go(): pass
        """,
    )


def test_source_without_functions_stays_as_it_is() -> None:
    assert_instrumented("import os\nprint(lambda: 1)\n", "import os\nprint(lambda: 1)\n")


def test_function_compiled_by_another_tool_is_left_alone() -> None:
    assert_instrumented(
        """
        @numba.njit(cache=True)
        def kernel(x): return x
        """,
        """
        @numba.njit(cache=True)
        def kernel(x): return x
        """,
    )


def test_names_the_sources_encoding_lacks_are_escaped() -> None:
    source = "# -*- coding: latin-1 -*-\ndef gr\xfcn(): return '\xe9'\n".encode("latin-1")
    instrumented = instrument_source(source, "\u03c0.py")
    assert "@__tracerisk_traced__('\\u03c0.py', 'gr\\xfcn', 2)" in instrumented.text
    namespace = {"__builtins__": {"__import__": _served}}
    exec(compile_instrumented(instrumented, "x"), namespace)
    assert namespace["gr\xfcn"]() == "\xe9"  # type: ignore[operator]


@pytest.mark.parametrize(
    "source",
    [
        "def f():\n        with a:\n    \t    b = 1\n        return 2\n",
        "class A:\n        def f(self):  # one\n    \t    return f'{3!r:>{4}}'\n        g = 1\n",
        "def f():\n        if a:\n      \t  b = 1\n        else: c = (1,\n 2)\n",
    ],
)
def test_indents_that_libcst_does_not_read_are_traced_on_their_lines(source: str) -> None:
    instrumented = instrument_source(source.encode(), "c.py")
    code = compile_instrumented(instrumented, "c.py")
    plain = compile(source, "c.py", "exec")
    assert instrumented.text.count(f"@{DECORATOR}(") == 1
    assert [line for _, line in _lines(code)] == [line for _, line in _lines(plain)]


def _lines(code: CodeType) -> list[tuple[str, int]]:
    inner = [each for each in code.co_consts if isinstance(each, CodeType)]
    return [(code.co_name, code.co_firstlineno), *(pair for one in inner for pair in _lines(one))]


def _served(*args: object) -> object:
    class Module:
        @staticmethod
        def traced(*args: object) -> object:
            return lambda function: function

    return Module


def name_of(code: CodeType) -> str:
    return getattr(code, "co_qualname", code.co_name)  # Python 3.10 keeps the bare name


def places(code: CodeType) -> list[tuple[object, ...]]:
    return list(code.co_positions() if hasattr(code, "co_positions") else code.co_lines())


@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r"])
def test_positions_are_those_of_the_original(line_end: str) -> None:
    text = "'''Doc.'''\n\n@d1\n@d2(1)\ndef f(a,\n      b=2):\n\tx = [\n a for a in b]\n\treturn x\n"
    source = ("\ufeff" + text.replace("\n", line_end)).encode()
    code = compile_instrumented(instrument_source(source, "c.py"), "/x/c.py")
    original = compile(text, "/x/c.py", "exec")
    assert code.co_filename == "/x/c.py"
    (ours,) = [c for c in code.co_consts if inspect.iscode(c)]
    (theirs,) = [c for c in original.co_consts if inspect.iscode(c)]
    assert theirs.co_firstlineno == ours.co_firstlineno == 3
    assert places(ours) == places(theirs)


def test_first_line_of_a_bare_function_is_its_def() -> None:
    code = compile_instrumented(instrument_source(b"\n\ndef f(): pass\n", "c.py"), "c.py")
    (ours,) = [c for c in code.co_consts if inspect.iscode(c)]
    assert ours.co_firstlineno == 3


STANDARD_LIBRARY = sorted(
    path for path in Path(os.__file__).parent.glob("*.py") if path.stat().st_size < 30_000
)[:100]


def code_objects(code: object) -> list[object]:
    found, pending = [], [code]
    while pending:
        each = pending.pop()
        found.append(each)
        pending += [c for c in each.co_consts if inspect.iscode(c)]  # type: ignore[attr-defined]
    return found


@pytest.mark.slow(but=3)
@pytest.mark.parametrize("path", slow_but_every(10, STANDARD_LIBRARY), ids=lambda path: path.name)
def test_standard_library_keeps_its_tree_and_its_lines(path: Path) -> None:
    source = path.read_bytes()
    instrumented = instrument_source(source, path.name)
    tree = ast.parse(instrumented.text)
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            added = node.decorator_list.pop()
            assert isinstance(added, ast.Call)
    if DECORATOR in instrumented.text:
        tree.body = [node for node in tree.body if "__tracerisk__" not in ast.dump(node)[:40]]
    assert ast.dump(ast.parse(source)) == ast.dump(tree)

    def shape(code: object) -> list[tuple[object, ...]]:
        return sorted(
            (name_of(c), c.co_firstlineno, c.co_code if c.co_name != "<module>" else b"")  # type: ignore[attr-defined]
            for c in code_objects(code)
        )

    ours = compile_instrumented(instrumented, str(path))
    theirs = compile(source, str(path), "exec", dont_inherit=True)
    assert [x[:2] for x in shape(theirs)] == [x[:2] for x in shape(ours)]
    lines = {
        (name_of(c), c.co_firstlineno): lines_without_markers(c)  # type: ignore[attr-defined]
        for c in code_objects(theirs)
        if not _defines_functions(c)
    }
    for c in code_objects(ours):
        key = (name_of(c), c.co_firstlineno)  # type: ignore[attr-defined]
        if key in lines:
            assert lines[key] == lines_without_markers(c)
            # The markers themselves stand on lines that are there already.
            assert set(lines[key]) == {line for *_, line in c.co_lines()}  # type: ignore[attr-defined]


def lines_without_markers(code: object) -> list[int | None]:
    """Return the lines in the order of the code, without all marks."""
    lines: list[int | None] = []
    within_marker = within_mark = False
    line_at = {
        offset: line
        for start, end, line in code.co_lines()  # type: ignore[attr-defined]
        for offset in range(start, end, 2)
    }
    for instruction in dis.get_instructions(code):  # type: ignore[arg-type]
        within_marker = within_marker or instruction.argval in (MARKER, CAUGHT)
        if instruction.opname.startswith("LOAD") and instruction.argval == MARK:
            within_mark = True
        line = line_at[instruction.offset]
        if not within_marker and not within_mark and lines[-1:] != [line]:
            lines.append(line)
        if instruction.opname.startswith("CALL"):
            within_mark = False
        if instruction.opname == "POP_TOP":
            within_marker = False
    return lines


def _defines_functions(code: object) -> bool:
    return any(
        inspect.iscode(c) and not c.co_name.startswith("<")
        for c in code.co_consts  # type: ignore[attr-defined]
    )


@pytest.mark.parametrize(
    ("source", "where", "what"),
    [
        (b"print 'x'\nNone = 3\n", "c.py:1", "at line 2: cannot assign to None"),
        (b"print 'x'\nprint(1, file=y)\n", "c.py:1", "Python 2 cannot read it either"),
        (b"print 'x'\nz = f'{1}'\n", "c.py:1", "not valid Python: Missing parentheses"),
        (b"def f(:\n  pass\n", "c.py:1:7", "not valid Python: invalid syntax in `def f(:`"),
        (b"x = 1\n  y = 2\n", "c.py:2", "unexpected indent"),
        (b"return 3\n", "c.py:1:1", "'return' outside function"),
        (b"# coding: klingon\n", "c.py:1", "unknown encoding"),
        (b"# coding: rot13\n", "c.py:1", "'rot13' is not a text encoding"),
        (b"x = 1\ny = '\xff'\n", "c.py:2:6", "byte 0xff is not utf-8"),
        (b"x = 1\0\n", "c.py", "null byte"),
        pytest.param(
            b"x = f\"{'it\\'s'}\"\n",
            "c.py:1",
            "Python 3.12 accepts it if nothing else is wrong",
            marks=pytest.mark.skipif(sys.version_info >= (3, 12), reason="it is valid"),
        ),
    ],
)
def test_what_is_no_python_is_refused_with_place_and_reason(
    source: bytes, where: str, what: str
) -> None:
    with pytest.raises(SourceError) as caught:
        instrument_source(source, "c.py")
    assert str(caught.value).startswith(where)
    assert what in str(caught.value)


def test_a_plain_mistake_is_not_taken_for_python_2() -> None:
    with pytest.raises(SourceError) as caught:
        instrument_source(b"def f()\n    return 1\n", "c.py")
    assert "Python 2" not in str(caught.value)
