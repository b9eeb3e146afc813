"""Many commands at once on one repository leave what each of them alone would have left."""

import random
import shutil
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

CONTROLLERS = [f"turn_{number}.py" for number in range(5)]
# A run takes half a gigabyte: that many commands are under way at any time, in a mixed order.
AT_ONCE = 25


def command(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "tracerisk", *words, "--quiet"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=1800,
    )


def files(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not {"__pycache__", ".tracerisk_cache"} & set(path.parts)
    }


def processes_in(folder: Path) -> list[str]:
    """The command lines of what still runs in a folder."""
    found = []
    for each in Path("/proc").glob("[0-9]*"):
        try:
            if (each / "cwd").resolve() == folder.resolve():
                found.append((each / "cmdline").read_text())
        except OSError:
            continue
    return found


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
def test_runs_checks_and_refreshes_at_once_leave_what_one_run_of_each_would(tmp_path, quick):
    alone, together = tmp_path / "alone", tmp_path / "together"
    alone.mkdir()
    (alone / "pyproject.toml").write_text("")
    for number, name in enumerate(CONTROLLERS):
        (alone / name).write_text(quick(f"arm.get_name()  # {number}"))
        assert command(alone, "run", name).returncode == 0
    shutil.copytree(alone, together)
    for folder in (alone, together):
        for name in CONTROLLERS:
            path = folder / name
            source = path.read_text()
            assert "arm.get_name()" in source
            path.write_text(source.replace("arm.get_name()", "arm.get_name(); arm.get_name()"))
    for name in CONTROLLERS:
        assert command(alone, "run", name).returncode == 0
    expected = files(alone)

    jobs = [("run", name) for name in CONTROLLERS * 4]
    jobs += [("refresh",)] * 5
    jobs += [("check",)] * 25 + [("check", name) for name in CONTROLLERS * 5]
    random.Random(7).shuffle(jobs)
    with ThreadPoolExecutor(AT_ONCE) as pool:
        done = list(pool.map(lambda words: command(together, *words), jobs))

    assert Counter(words[0] for words in jobs) == {"run": 20, "refresh": 5, "check": 50}
    for words, each in zip(jobs, done, strict=True):
        # A check finds what is stale until a run has come to it, and never anything else.
        allowed = (0, 1) if words[0] == "check" else (0,)
        assert each.returncode in allowed, (words, each.stdout, each.stderr)
        if each.returncode == 1:
            assert all(": stale: " in line for line in each.stdout.splitlines()), each.stdout
    assert files(together) == expected
    assert command(together, "check").returncode == 0
    assert processes_in(together) == []
