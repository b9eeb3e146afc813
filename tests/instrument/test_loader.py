"""The controller runs as a program of its own would, and sees no tracerisk."""

import inspect
import re
import sys
import threading
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tracerisk.errors import InputError, Location, SourceError
from tracerisk.instrument.hidden_frames import hidden_frames
from tracerisk.instrument.loader import (
    Sources,
    prepared_controller,
    run_controller,
    source_key,
)
from tracerisk.instrument.marks.decorators import instrument_source
from tracerisk.instrument.tracer import Tracer

Run = Callable[[str], Any]


def test_controller_runs_as_main_with_its_arguments(tmp_path: Path) -> None:
    path = tmp_path / "c.py"
    path.write_text(
        "import sys, json\n"
        "assert __name__ == '__main__' and sys.modules['__main__'].__dict__ is globals()\n"
        "import beside\n"
        "open(sys.argv[1], 'w').write(json.dumps([sys.argv, __file__, sys.path[0], beside.x]))\n"
    )
    (tmp_path / "beside.py").write_text("x = 5\n")
    before = (sys.argv, sys.path[:], sys.modules["__main__"], sys.getrecursionlimit())
    run_controller(path, Tracer(), [str(tmp_path / "out"), "_x:=1"])
    sys.modules.pop("beside")
    assert before == (sys.argv, sys.path, sys.modules["__main__"], sys.getrecursionlimit())
    assert "__tracerisk__" not in sys.modules
    import json

    argv, file, first, x = json.loads((tmp_path / "out").read_text())
    assert [str(path), str(tmp_path / "out"), "_x:=1"] == argv
    assert (str(path), str(tmp_path), 5) == (file, first, x)


def test_exit_passes_through_and_all_is_put_back(tmp_path: Path) -> None:
    path = tmp_path / "c.py"
    path.write_text("import sys\ndef main(): sys.exit(3)\nmain()\n")
    patched = (traceback.extract_tb, inspect.stack, sys._getframe, threading.excepthook)
    with pytest.raises(SystemExit) as caught:
        run_controller(path, Tracer())
    assert caught.value.code == 3
    assert patched == (traceback.extract_tb, inspect.stack, sys._getframe, threading.excepthook)


def test_nothing_runs_of_a_source_that_is_not_python(tmp_path: Path) -> None:
    path = tmp_path / "c.py"
    path.write_text("open('ran', 'w')\nprint 'x'\nprint(1, file=x)\n")
    with pytest.raises(
        SourceError, match=r"c.py:2:1: this is Python 2.* at line 3: Python 2 cannot"
    ):
        run_controller(path, Tracer(), root=tmp_path)
    with pytest.raises(InputError, match="No such file"):
        run_controller(tmp_path / "none.py", Tracer())


def test_where_it_failed_is_the_innermost_controller_line(tmp_path: Path) -> None:
    path = tmp_path / "c.py"
    path.write_text("import json\ndef load():\n    json.loads('{')\nload()\n")
    tracer = Tracer()
    with pytest.raises(ValueError, match="Expecting") as caught:
        run_controller(path, tracer, root=tmp_path)
    assert tracer.where_failed(caught.value) == Location("c.py", 3)


def test_traceback_reads_as_that_of_the_plain_program(tmp_path: Path) -> None:
    path = tmp_path / "c.py"
    path.write_text(
        "def fail(x):\n    return 1 / x\n\ndef main():\n    try:\n        fail(0)\n"
        "    except ZeroDivisionError as e:\n        raise ValueError('bad') from e\n\nmain()\n"
    )
    import subprocess

    plain = subprocess.run([sys.executable, str(path)], capture_output=True, text=True)
    with pytest.raises(ValueError, match="bad") as caught:
        run_controller(path, Tracer())
    with hidden_frames():
        shown = "".join(traceback.format_exception(caught.value))
    # The frames of this test come first; the program's own end the text, line for line.
    causes, _, own = shown.rpartition("Traceback (most recent call last):\n")
    plain_causes, _, plain_own = plain.stderr.rpartition("Traceback (most recent call last):\n")
    assert plain_causes == causes
    assert own.endswith(plain_own)


def test_printed_tracebacks_show_no_frame_of_ours(run: Run) -> None:
    ran = run(
        """
        import io, logging, sys, threading, traceback
        from robot import show

        def fail(): raise ValueError("no")
        def step():
            try:
                fail()
            except ValueError:
                show(traceback.format_exc())
                out = io.StringIO()
                handler = logging.StreamHandler(out)
                logger = logging.getLogger("controller"); logger.propagate = False
                logger.addHandler(handler)
                logger.exception("failed")
                show(out.getvalue())
                show("".join(traceback.format_tb(sys.exc_info()[2])))
                show("".join(traceback.format_exc(limit=1)))
            show("".join(traceback.format_stack()[-2:]))
            show("".join(traceback.format_stack(limit=2)))
        step()
        """
    )
    exc, logged, entries, limited, stack, limited_stack = ran.shown
    # Which lines have carets depends on the version.
    assert re.sub(r"^ *[~^]+\n", "", exc, flags=re.MULTILINE) == (
        "Traceback (most recent call last):\n"
        f'  File "{ran.path}", line 8, in step\n    fail()\n'
        f'  File "{ran.path}", line 5, in fail\n'
        '    def fail(): raise ValueError("no")\n'
        "ValueError: no\n"
    )
    assert logged == "failed\n" + exc
    assert [line for line in exc.splitlines() if "File" in line] == [
        line for line in entries.splitlines() if "File" in line
    ]
    assert "in step" in limited
    assert "in fail" not in limited
    assert "in <module>" in stack
    assert "in step" in stack
    assert limited_stack.count("File") == 2
    assert "in <module>" in limited_stack
    assert not [text for text in ran.shown if "tracerisk" in text]


def test_callers_that_ask_who_called_see_the_controller(run: Run) -> None:
    ran = run(
        """
        import inspect, sys, warnings, logging
        from robot import show

        def deprecated():
            warnings.warn("old", DeprecationWarning, stacklevel=2)
        def caller_of():
            show(sys._getframe(1).f_code.co_name)
            show(inspect.stack()[1].function)
            show(inspect.currentframe().f_code.co_name)
        def step():
            caller_of()
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                deprecated()
            show((caught[0].filename, caught[0].lineno))
        def log(message):
            logger.warning(message, stacklevel=2)
        def step2():
            log("x")
        logger = logging.getLogger("stacklevel"); logger.propagate = False
        class Keep(logging.Handler):
            def emit(self, record): show((record.funcName, record.lineno))
        logger.addHandler(Keep())
        step(); step2()
        """
    )
    *callers, warned, (function, line) = ran.shown
    assert callers == ["step", "step", "caller_of"]
    assert warned == (str(ran.path), 15)
    if sys.version_info >= (3, 11):
        assert (function, line) == ("step2", 20)
    else:  # its logging counts every frame that is not its own, the wrapper's too
        assert function == "log"


def test_syntax_warnings_are_given_once_with_the_original_line(tmp_path: Path) -> None:
    path = tmp_path / "c.py"
    path.write_text("def f():\n    return 3 is 3\n\nx = '\\d'\n")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run_controller(path, Tracer())
    assert sorted((w.filename, w.lineno) for w in caught) == [(str(path), 2), (str(path), 4)]


def test_callbacks_run_while_the_program_is_open(tmp_path: Path) -> None:
    path = tmp_path / "c.py"
    path.write_text("import __main__\ndef later(): return __main__.x\nx = 4\n")
    with prepared_controller(path, Tracer()) as run:
        run()
        assert sys.modules["__main__"].later() == 4


def test_thread_failure_is_shown_without_frames_of_ours(
    run: Run, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(threading, "excepthook", threading.__excepthook__)
    run(
        """
        import threading
        def fail(): raise ValueError("in a thread")
        def worker(): fail()
        thread = threading.Thread(target=worker); thread.start(); thread.join()
        """
    )
    shown = capsys.readouterr().err
    assert "ValueError: in a thread" in shown
    assert "tracerisk" not in shown


def test_a_text_that_was_instrumented_before_stands_for_that_source_alone() -> None:
    source, other = b"def f():\n    pass\n", b"def g():\n    pass\n"
    text = instrument_source(source, "c.py").text + "\n\n"
    sources = Sources(instrumented={source_key("c.py", source): text})
    assert sources.instrument("c.py", source).text == text
    for file, changed in (("c.py", other), ("d.py", source)):
        anew = sources.instrument(file, changed)
        assert anew == instrument_source(changed, file)
        assert anew.original == changed
