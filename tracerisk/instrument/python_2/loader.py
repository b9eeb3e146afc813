"""Load a module that is not traced, and convert it where it is Python 2."""

from __future__ import annotations

from importlib.machinery import SourceFileLoader
from types import CodeType, ModuleType
from typing import Any, NoReturn

from tracerisk.instrument.hidden_frames import hide
from tracerisk.instrument.python_2.meaning import give_meaning, is_of_python_2
from tracerisk.instrument.source.python_source import decoded, read_python


class ConvertingLoader(SourceFileLoader):
    """Loads a source of either Python, whatever is compiled of it beside it."""

    def path_stats(self, path: str) -> NoReturn:
        """Raise OSError: Python takes no bytecode of a source whose age it does not know."""
        raise OSError(f"{path} is always read")

    def source_to_code(  # type: ignore[override]
        self, data: Any, path: Any, *, _optimization: int = -1
    ) -> CodeType:
        """Return the code of a source."""
        try:
            read = read_python(decoded(bytes(data)))
        except (SyntaxError, ValueError, RecursionError):
            return super().source_to_code(data, path)  # it says what is wrong
        if not read.is_python_2:
            return super().source_to_code(data, path)
        give_meaning(read.tree)
        return compile(read.tree, path, "exec", dont_inherit=True)

    @hide
    def exec_module(self, module: ModuleType) -> None:
        """Execute the code of a module in its namespace."""
        code = self.get_code(module.__name__)
        assert code is not None
        serve_names(code, module.__dict__)
        exec(code, module.__dict__)


def serve_names(code: CodeType, namespace: dict[str, Any]) -> None:
    """Serve code of Python 2 the built-in names that it has there."""
    if is_of_python_2(code):
        from tracerisk.instrument.python_2.built_ins import built_ins

        namespace["__builtins__"] = built_ins()
