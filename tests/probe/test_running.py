"""A controller under the probe behaves as without it, and nothing that it commanded is lost."""

import ast
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tracerisk_probe import importing

from tests.probe.conftest import PROBE, Probed
from tests.slow import slow_but

SOURCES = sorted((PROBE / "tracerisk_probe").glob("*.py"))
ACT = """
import tracerisk_probe
act = tracerisk_probe.watch(lambda *_: None, "act")
"""


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.name)
def test_the_sources_are_those_of_python_3_8(path):
    text = path.read_text(encoding="utf-8")
    ast.parse(text, feature_version=(3, 8))
    # What is newer than 3.8 and parses: generics of builtins that are evaluated.
    assert text.startswith('"""')
    assert "from __future__ import annotations" in text or path.name == "__init__.py"


def test_an_old_python_runs_it(probed):
    found = [
        path
        for path in (Path.home() / ".pyenv/versions").glob("3.[89].*/bin/python")
        if subprocess.run([path, "-c", ""], check=False).returncode == 0
    ]
    if not found:
        pytest.skip("no Python 3.8 or 3.9 is here")
    probed.write("act.py", ACT)
    probed.write("pick.py", "from act import act\ndef pick():\n    act()\npick()\n")
    done = probed.python(*probed.command("pick.py", python=str(found[0])))
    assert (done.returncode, done.stderr) == (0, "")
    assert probed.names == [["<module>", "pick"]]


def test_what_comes_too_fast_is_counted_in_the_file(probed):
    probed.write("act.py", ACT + "from tracerisk_probe import writing\nwriting.MOST_WAITING = 20\n")
    body = "    for _ in range(3000):\n        act()\n"
    probed.write("pick.py", f"from act import act\ndef pick():\n{body}pick()\n")
    done = probed.python(*probed.command("pick.py"))
    written = [found for found in probed.objects if found["kind"] in ("method", "end")]
    counts = [found["count"] for found in probed.objects if found["kind"] == "dropped"]
    assert counts, "nothing was dropped"
    assert len(written) + sum(counts) == 2 * 3000  # each with its end
    assert f"{counts[0]} objects were dropped" in done.stderr


def test_the_format_is_what_its_page_says(probed):
    probed.write("act.py", ACT)
    probed.write("pick.py", "from act import act\ndef pick():\n    act()\npick()\n")
    before = time.time()
    assert probed.run("pick.py").returncode == 0
    begin, command, end = probed.objects
    assert before <= begin.pop("t") <= command.pop("t") <= end.pop("t") <= time.time()
    pid = begin["pid"]
    assert begin == {
        "kind": "begin",
        "format": "tracerisk-probe/1",
        "controller": "pick.py",
        "pid": pid,
    }
    (first, *_), (second, *_) = command["at"]
    columns = [1, 5] if sys.version_info >= (3, 11) else [0, 0]
    assert command == {
        "kind": "method",
        "name": "act",
        "type": "<lambda>",
        "id": 1,
        "pid": pid,
        "root": "main",
        "stack": ["pick.py:<module>", "pick.py:pick"],
        "at": [[first, 1, 4, columns[0]], [second, 2, 3, columns[1]]],
    }
    assert end == {"kind": "end", "id": 1, "pid": pid, "outcome": "succeeded"}


def test_the_controller_starts_it_by_itself_with_its_own_arguments(probed):
    probed.write("act.py", ACT)
    probed.write(
        "pick.py",
        """
        import tracerisk_probe
        tracerisk_probe.start(out="out.jsonl", publish=False)
        import sys
        from act import act
        def pick():
            act()
        pick()
        print(sys.argv[1:], __name__, __file__.endswith("pick.py"))
        sys.exit(3)
        """,
    )
    done = probed.python(sys.executable, "pick.py", "a", "--out", "b")
    assert (done.returncode, done.stderr) == (3, "")
    assert done.stdout == "['a', '--out', 'b'] __main__ True\n"
    assert probed.names == [["<module>", "pick"]]


def test_an_installed_command_and_a_module_are_traced(probed):
    probed.write("libraries/pick_cell/__init__.py", "")
    probed.write(
        "libraries/pick_cell/node.py",
        ACT + "\ndef main():\n    act()\nif __name__ == '__main__':\n    main()\n",
    )
    probed.write("lib/pick_cell/node", "from pick_cell.node import main\nmain()\n")
    assert probed.run("lib/pick_cell/node").returncode == 0
    assert [each["stack"] for each in probed.commands] == [["pick_cell/node.py:main"]]
    done = probed.run("-m", "pick_cell.node")
    assert (done.returncode, done.stderr) == (0, "")
    assert probed.names[-1][-1] == "main"


def test_threads_futures_and_tasks_inherit_the_stack(probed):
    probed.write("act.py", ACT)
    probed.write(
        "pick.py",
        """
        import asyncio, threading
        from concurrent.futures import ThreadPoolExecutor
        from act import act

        def step():
            act()

        async def awaited():
            await asyncio.sleep(0)
            act()

        def by_thread():
            threads = [threading.Thread(target=step) for _ in range(8)]
            for each in threads:
                each.start()
            for each in threads:
                each.join()

        def by_pool():
            with ThreadPoolExecutor() as pool:
                future = pool.submit(step)
                future.add_done_callback(lambda _: step())

        async def by_task():
            await asyncio.gather(*(asyncio.ensure_future(awaited()) for _ in range(4)))

        by_thread(); by_pool(); asyncio.run(by_task())
        """,
    )
    assert probed.run("pick.py").returncode == 0
    assert probed.names == [
        *[["<module>", "by_thread", "step"]] * 8,
        ["<module>", "by_pool", "step"],
        ["step"],
        *[["<module>", "by_task", "awaited"]] * 4,
    ]
    assert probed.commands[9]["root"] == "done_callback"
    assert len({each["at"][2][0] for each in probed.commands[:8]}) == 8


def test_a_deep_recursion_has_room(probed):
    deep = "def down(n):\n    return n and down(n - 1)\nprint(down(900))\n"
    probed.write("pick.py", deep)
    done = probed.run("pick.py")
    assert (done.returncode, done.stdout) == (0, "0\n")


ENDS = {
    "raise ValueError('no')": (1, "ValueError: no"),
    "os._exit(5)": (5, ""),
    "os.kill(os.getpid(), signal.SIGTERM)": (-signal.SIGTERM, ""),
    "os.kill(os.getpid(), signal.SIGINT)": (-signal.SIGINT, "KeyboardInterrupt"),
    "os.kill(os.getpid(), signal.SIGHUP)": (-signal.SIGHUP, ""),
}


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("end", slow_but([*ENDS][:3], [*ENDS]))
def test_nothing_is_lost_however_it_ends(probed, end):
    probed.write("act.py", ACT)
    probed.write(
        "pick.py",
        f"import os, signal\nfrom act import act\nfor _ in range(2000):\n    act()\n{end}\n",
    )
    done = probed.run("pick.py")
    code, reported = ENDS[end]
    assert done.returncode == code
    assert reported in done.stderr
    assert len(probed.commands) == 2000


def test_the_handler_of_the_controller_is_left_to_it(probed):
    probed.write("act.py", ACT)
    probed.write(
        "pick.py",
        """
        import os, signal, sys
        from act import act
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(7))
        act()
        os.kill(os.getpid(), signal.SIGTERM)
        """,
    )
    assert probed.run("pick.py").returncode == 7
    assert len(probed.commands) == 1


def test_a_forked_process_writes_too(probed):
    probed.write("act.py", ACT)
    probed.write(
        "pick.py",
        """
        import os
        from act import act
        act()
        child = os.fork()
        act()
        if child:
            os.waitpid(child, 0)
        else:
            os._exit(0)
        """,
    )
    assert probed.run("pick.py").returncode == 0
    assert sorted(len([c for c in probed.commands if c["pid"] == pid]) for pid in pids(probed)) == [
        1,
        2,
    ]


def pids(probed: Probed) -> set[int]:
    return {each["pid"] for each in probed.commands}


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((), "FILE is missing: name the controller's Python file"),
        (("none.py",), "none.py: there is no such file"),
        (("--out", "no/out.jsonl", "pick.py"), "no/out.jsonl: cannot be written: No such file"),
    ],
)
def test_what_cannot_be_run_is_reported(probed, words, expected):
    probed.write("pick.py", "")
    done = probed.python(sys.executable, "-m", "tracerisk_probe", *words)
    assert done.returncode == 2
    assert expected in done.stderr


def test_commands_that_go_nowhere_are_reported(probed):
    probed.write("pick.py", "")
    done = probed.python(sys.executable, "-m", "tracerisk_probe", "pick.py")
    assert done.returncode == 0
    assert "the commands went nowhere: no node of ROS was started; give --out" in done.stderr


def test_it_starts_no_program_that_is_no_file(probed):
    done = probed.python(sys.executable, "-c", "import tracerisk_probe; tracerisk_probe.start()")
    assert done.returncode == 1
    assert "start it by `python -m tracerisk_probe FILE`" in done.stderr


def test_a_file_that_is_no_python_fails_as_without_it(probed):
    probed.write("pick.py", "def (:\n")
    done = probed.run("pick.py")
    assert done.returncode == 1
    assert "SyntaxError" in done.stderr


def test_a_full_disk_ends_no_controller(probed):
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full")
    probed.write("act.py", ACT)
    probed.write("pick.py", "from act import act\nact()\nprint('went on')\n")
    words = ("-m", "tracerisk_probe", "--out", "/dev/full", "pick.py")
    done = probed.python(sys.executable, *words)
    assert (done.returncode, done.stdout) == (0, "went on\n")
    assert "/dev/full: nothing more is written: No space left on device" in done.stderr


def test_an_environment_in_the_repository_is_not_its_own_code(tmp_path):
    own = importing.Own(tmp_path)
    assert own.name_of(tmp_path / "scripts/pick.py") == "scripts/pick.py"
    assert own.name_of(tmp_path / ".venv/lib/python3.11/site-packages/numpy/a.py") is None
    assert own.name_of(tmp_path.parent / "elsewhere.py") is None
