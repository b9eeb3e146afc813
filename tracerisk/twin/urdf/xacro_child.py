"""Expand one xacro file, in a process of its own: `python -m tracerisk.twin.urdf.xacro_child`.

On standard input comes JSON: `path`, `packages` (names and folders), `arguments`, `within`, the
folders whose files may be read (`null`: any), and `lacking`, whether packages and arguments may be
absent. JSON goes to standard output: the expanded `text`, the `files` that were read, and what was
absent: `packages`, the `includes` of their files and `arguments`, and `is_old`, whether it has
forms that xacro no longer takes; or, with the exit code REFUSED, which file was `asked` for outside
the folders, and `by` which file. A macro may never end, may print, and may read what it names: so
the process has limits.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import sys
import sysconfig
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

from tracerisk.common.sandbox.limited_process import end_with, limit_memory, mark_start
from tracerisk.common.text.bounded import file_text

MOST_CHARACTERS = 16 * 1024**2
REFUSED = 7
ABSENT = "/absent-package"
"""The folder in which absent packages would be."""
ABSENT_MACRO = "absent_macro"
"""The element that a call of an absent macro becomes, with its arguments evaluated."""
MACRO_NAME = "of_macro"
"""The attribute with the name of the macro."""
_OLD_TAGS = frozenset({"arg", "if", "include", "insert_block", "macro", "property", "unless"})
"""The tags that xacro took without its prefix up to ROS Melodic: ros/xacro CHANGELOG.rst."""
_OLD_NAME = re.compile(r"(?<![\w.])__(?=[A-Za-z]\w*\b(?!__))")
"""How a property began that xacro refuses today: ros/xacro src/xacro/__init__.py grab_property."""
_OLD = re.compile(rf"<(?:{'|'.join(sorted(_OLD_TAGS - {'arg'}))})\b")


def main() -> int:
    """Expand the file that standard input names."""
    limit_memory()
    asked = json.load(sys.stdin)
    # xacrodoc hands xacro the text: relative includes of the file itself start from here.
    os.chdir(Path(asked["path"]).parent)
    # What xacro says goes to standard error; only the document is the answer.
    with contextlib.redirect_stdout(sys.stderr):
        from xacrodoc import XacroDoc, packages
        from xacrodoc.xacrodoc import xacro

        xacro.replace_node = replace_node
        packages.update_package_cache(asked["packages"])
        lacking = _Lacking()
        if asked["lacking"]:
            lacking.pass_over()
        reading = _Reading(asked["within"])
        mark_start()
        sys.addaudithook(reading.hook)
        is_old = False

        def expanded() -> str:
            document = XacroDoc.from_file(
                asked["path"], walk_up=True, resolve_packages=False, subargs=asked["arguments"]
            )
            return str(document.to_urdf_string())

        try:
            try:
                text = expanded()
                is_old = bool(_OLD.search(text))
            except MemoryError:
                raise
            except Exception:
                is_old = reading.refused is None and any(map(_has_old_forms, reading.files))
                if not is_old:
                    raise
            if is_old:
                _take_old_forms()
                text = expanded()
        except MemoryError:
            raise
        except Exception:
            if reading.refused is None:
                raise
        reading.is_over = True
    if reading.refused is None and len(text) > MOST_CHARACTERS:
        sys.exit(f"it expands to {len(text)} characters; at most {MOST_CHARACTERS} are read")
    if reading.refused is not None:
        json.dump(
            {"asked": reading.refused, "by": reading.by, "within": asked["within"]}, sys.stdout
        )
        return REFUSED
    answer: dict[str, Any] = {"text": text, "files": reading.files}
    answer |= {"packages": [*lacking.packages], "arguments": [*lacking.arguments]}
    answer |= {"includes": [*lacking.includes], "is_old": is_old}
    json.dump(answer, sys.stdout)
    return 0


def replace_node(node: Any, by: Any, content_only: bool = False) -> None:
    """Put nodes, or what is in them, in the place of one, as the function of xacro does.

    That one looks for the place again for each of them, so that a file of as many elements as an
    SRDF has pairs that never collide takes half a minute.
    """
    parent, given = node.parentNode, by if isinstance(by, list) else [by] * (by is not None)
    put: list[Any] = []
    for each in given:
        if content_only:
            put += each.childNodes
            del each.childNodes[:]
        else:
            if each.parentNode is not None:
                each.parentNode.removeChild(each)
            put.append(each)
    at = parent.childNodes.index(node)
    row = [node.previousSibling, *put, node.nextSibling]
    parent.childNodes[at : at + 1] = put
    for each in put:
        each.parentNode = parent
    node.parentNode = node.previousSibling = node.nextSibling = None
    for left, right in pairwise(row):
        if left is not None:
            left.nextSibling = right
        if right is not None:
            right.previousSibling = left


def _has_old_forms(file: str) -> bool:
    try:
        text = file_text(Path(file), errors="replace")
    except OSError:  # what may not be read is the error that is reported
        return False
    return bool(_OLD.search(text) or re.search(r"<xacro:property\s+name=[\"']__", text))


def _take_old_forms() -> None:
    """Make xacro take tags and macros without prefix, and names that begin with underscores."""
    from xacrodoc.xacrodoc import xacro

    evaluate = xacro.eval_all

    def evaluated(node: Any, macros: Any, symbols: Any) -> Any:
        # The tags of each level are looked at when it is, for a macro may stand in the one above.
        for child in (node, *node.childNodes):
            tag = getattr(child, "tagName", "")
            if tag in _OLD_TAGS:
                child.nodeName = child.tagName = f"xacro:{tag}"
            for name, value in list(child.attributes.items()) if tag else ():
                if (renamed := _OLD_NAME.sub("old_", value)) != value:
                    child.setAttribute(name, renamed)
        return evaluate(node, macros, symbols)

    call = xacro.handle_macro_call

    def called(node: Any, macros: Any, symbols: Any) -> Any:
        tag = node.tagName
        if ":" not in tag and tag in macros:
            node.nodeName = node.tagName = f"xacro:{tag}"
        return call(node, macros, symbols)

    xacro.eval_all, xacro.handle_macro_call = evaluated, called


class _Given(dict[str, Any]):
    """Arguments of xacro; what nothing gives is asked of `absent`."""

    def __init__(self, given: dict[str, Any], absent: Callable[[str], Any]) -> None:
        super().__init__(given)
        self._absent = absent

    def __missing__(self, name: str) -> Any:
        return self._absent(name)


class _Lacking:
    """Lets xacro go on where packages, the macros in them, and arguments are absent."""

    def __init__(self) -> None:
        self.packages: dict[str, None] = {}
        self.includes: dict[str, None] = {}
        self.arguments: dict[str, None] = {}

    def pass_over(self) -> None:
        """Leave out includes of absent packages, keep calls of absent macros as elements."""
        from xacrodoc.packages import PackageNotFoundError
        from xacrodoc.xacrodoc import substitution_args, xacro

        find, files = substitution_args._eval_find, xacro.get_include_files
        argument, call = substitution_args._eval_arg, xacro.handle_macro_call
        boolean, evaluate = xacro.get_boolean_value, xacro.safe_eval

        def found(package: str) -> Any:
            try:
                return find(package)
            except PackageNotFoundError:
                self.packages.setdefault(package)
                return f"{ABSENT}/{package}"

        def given(name: str, args: Any) -> Any:
            try:
                return argument(name, args)
            except substitution_args.ArgException:
                self.arguments.setdefault(name)
                return ""

        def included(name: str, symbols: Any) -> Any:
            for file in files(name, symbols):
                if file.startswith(f"{ABSENT}/"):
                    self.includes.setdefault(file.removeprefix(f"{ABSENT}/"))
                else:
                    yield file

        def decided(value: Any, condition: Any) -> Any:
            # What is asked of an argument that nothing gives is answered with no.
            is_empty = bool(self.arguments) and isinstance(value, str) and not value.strip()
            return False if is_empty else boolean(value, condition)

        def called(node: Any, macros: Any, symbols: Any) -> Any:
            if not self.packages or _is_known(node, macros, symbols):
                return call(node, macros, symbols)
            name = node.tagName.removeprefix("xacro:")
            node.nodeName = node.tagName = ABSENT_MACRO
            for key, value in list(node.attributes.items()):
                try:
                    node.setAttribute(key, str(xacro.eval_text(value, symbols)))
                except (xacro.XacroException, NameError):
                    node.setAttribute(key, "")  # a file of the package, say
            node.setAttribute(MACRO_NAME, name)
            xacro.eval_all(node, macros, symbols)
            return True

        def evaluated(expression: str, known: Any, inner: Any = None) -> Any:
            while True:
                try:
                    return evaluate(expression, known, inner)
                except NameError as error:
                    # An absent file may have given it: those of a calibration are near 0.
                    if not self.includes or not error.name:
                        raise
                    self.arguments.setdefault(error.name)
                    inner = {**(inner or {}), error.name: 0.0}

        def absent(name: str) -> str:
            self.arguments.setdefault(name)
            return ""

        class Context(dict[str, Any]):
            """What the substitutions know: `xacro.arg()` reads the arguments of it."""

            def __setitem__(self, key: str, value: Any) -> None:
                super().__setitem__(key, _Given(value, absent) if key == "arg" else value)

        xacro.substitution_args_context = Context(xacro.substitution_args_context)
        substitution_args._eval_find, xacro.get_include_files = found, included
        substitution_args._eval_arg, xacro.handle_macro_call = given, called
        xacro.get_boolean_value, xacro.safe_eval = decided, evaluated


def _is_known(node: Any, macros: Any, symbols: Any) -> bool:
    """Whether an element calls no macro, or one that xacro knows."""
    from xacrodoc.xacrodoc import xacro

    name = node.tagName.removeprefix("xacro:")
    if name in (node.tagName, "call"):
        return True
    try:
        xacro.resolve_macro(name, macros, symbols)
    except KeyError:
        return False
    return True


class _Reading:
    """Notes which files are read, and lets none be read outside the folders."""

    def __init__(self, within: list[str] | None) -> None:
        self._within = None if within is None else [Path(folder) for folder in within]
        # Modules that xacro imports late.
        self._own = [Path(folder).resolve() for folder in (sys.prefix, sys.base_prefix)]
        packages = [Path(folder).resolve() for folder in sys.path if folder.endswith("-packages")]
        self._own += packages
        # Those of an environment that stands within the project are no part of the model.
        self._code = [*packages, Path(sysconfig.get_path("stdlib")).resolve()]
        self._opened: dict[str, None] = {}
        self.refused: str | None = None
        self.by: str | None = None
        self.is_over = False

    @property
    def files(self) -> list[str]:
        """The files that were read, in their order."""
        return list(self._opened)

    def hook(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Look at what is about to be opened or started."""
        if self.is_over:
            return
        if self._within is not None and event in ("subprocess.Popen", "os.system", "os.exec"):
            raise PermissionError("a macro may start no process")
        if event != "open" or not isinstance(arguments[0], (str, bytes)):
            return
        path = Path(os.fsdecode(arguments[0])).resolve()
        if any(map(path.is_relative_to, self._code)):
            return
        is_inside = self._within is None or any(map(path.is_relative_to, self._within))
        if is_inside:
            if path.is_file():
                self._opened.setdefault(str(path))
            return
        if any(map(path.is_relative_to, self._own)):
            return
        if self.refused is None:
            self.refused = os.fsdecode(arguments[0])
            self.by = next(reversed(self._opened), None)
        raise PermissionError(f"{path} lies outside the folders of the model")


if __name__ == "__main__":
    end_with(main)
