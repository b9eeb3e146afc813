"""Files, numbers and JSON of others, within bounds."""

import ast
import errno
import os
import re
from pathlib import Path

import pytest

import tracerisk
from tracerisk.common.text.bounded import (
    MOST_BYTES,
    MOST_DIGITS,
    file_bytes,
    file_text,
    files_below,
    finite_number,
    in_folder,
    loads_json,
    whole_number,
)
from tracerisk.errors import InputError


@pytest.mark.parametrize("text", ["9" * (MOST_DIGITS + 1), "x", "1e3"])
def test_a_whole_number_that_is_none_or_too_long_is_refused(text):
    with pytest.raises(ValueError, match=r"."):
        whole_number(text)


@pytest.mark.parametrize("text", ["1e999", "-1e999", "nan", "inf", "0" * 500])
def test_a_number_that_is_not_finite_or_too_long_is_refused(text):
    with pytest.raises(ValueError, match="a number"):
        finite_number(text)


@pytest.mark.parametrize("text", ["[" * 200_000, '{"a": 1e999}', "[NaN]", "[" + "9" * 5000 + "]"])
def test_json_past_a_bound_is_a_value_error(text):
    with pytest.raises(ValueError, match=r"deeply|a number"):
        loads_json(text)


def test_json_within_bounds_is_as_python_reads_it():
    assert loads_json(b'{"a": [1, 2.5, -3e-5, true, null]}') == {"a": [1, 2.5, -3e-5, True, None]}


def test_a_file_is_read_as_it_is(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"a\r\nb\xff")
    assert file_bytes(path) == b"a\r\nb\xff"
    assert file_text(path, errors="replace") == "a\nb\ufffd"
    (tmp_path / "link").symlink_to(path)
    assert file_bytes(tmp_path / "link") == path.read_bytes()
    with pytest.raises(OSError, match="symbolic links"):
        file_bytes(tmp_path / "link", through_links=False)


@pytest.mark.skipif(os.name != "posix", reason="needs pipes and devices")
def test_what_is_no_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "endless").symlink_to("/dev/zero")
    with pytest.raises(OSError, match="pipe: cannot be read: it is a pipe; put a regular file"):
        file_bytes(tmp_path / "pipe")
    with pytest.raises(InputError, match="endless: cannot be read: it is a device; put a regular"):
        file_text(tmp_path / "endless")
    with pytest.raises(IsADirectoryError):
        file_bytes(tmp_path)
    with pytest.raises(FileNotFoundError):
        file_bytes(tmp_path / "absent")


def test_a_file_that_is_too_large_is_refused(tmp_path):
    path = tmp_path / "large"
    with path.open("wb") as stream:
        stream.truncate(MOST_BYTES + 1)
    with pytest.raises(OSError, match=f"it holds more than {MOST_BYTES} bytes") as error:
        file_bytes(path)
    assert (error.value.errno, error.value.filename) == (errno.EFBIG, str(path))
    assert len(file_bytes(path, MOST_BYTES + 1)) == MOST_BYTES + 1


def test_no_file_of_a_checkout_is_read_past_the_bounds():
    """What is opened otherwise is ours, or a program's, or read in a process with limits."""
    package = Path(tracerisk.__file__).parent
    found = set()
    for path in package.rglob("*.py"):
        name, source = path.relative_to(package).as_posix(), path.read_bytes()
        # To take a file apart that has none of the words takes longest.
        if "/stand_ins/" in name or not re.search(rb"read_text|read_bytes|\brb\b", source):
            continue
        if any(isinstance(node, ast.Call) and _reads(node) for node in ast.walk(ast.parse(source))):
            found.add(name)
    assert found == READERS_OF_OURS


def test_files_below_a_folder_are_sorted_and_hidden_folders_left_out(tmp_path):
    for name in ("b.yaml", "a/c.yaml", "a/b/d.yml", "a/e.txt", ".git/f.yaml", "build/g.yaml"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    os.mkfifo(tmp_path / "pipe.yaml")

    def below(*endings, **more):
        files = files_below(tmp_path, *endings, **more)
        return [path.relative_to(tmp_path).as_posix() for path in files]

    assert below(".yaml", ".yml", left_out={"build"}) == ["a/b/d.yml", "a/c.yaml", "b.yaml"]
    assert below(".yaml") == ["a/c.yaml", "b.yaml", "build/g.yaml"]
    assert below(left_out={"build"}) == ["a/b/d.yml", "a/c.yaml", "a/e.txt", "b.yaml"]
    assert files_below(tmp_path / "none") == []
    assert in_folder(tmp_path / "a") == [tmp_path / "a" / name for name in ("b", "c.yaml", "e.txt")]
    assert in_folder(tmp_path / "a", ".txt") == [tmp_path / "a" / "e.txt"]
    assert in_folder(tmp_path / "none") == []


def test_no_folder_of_a_checkout_is_looked_through_by_what_fails_where_one_is_deleted():
    """`rglob` raises for a folder that vanishes, but for those of Python 3.13 and later."""
    package = Path(tracerisk.__file__).parent
    found = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if re.search(r"\.rglob\(|glob\([^)]*\*/", path.read_text(encoding="utf-8"))
    }
    assert found == LOOKED_THROUGH_OF_OURS


def test_a_ctrl_c_as_a_file_is_opened_is_no_failed_close(tmp_path, monkeypatch):
    (tmp_path / "a.py").write_bytes(b"x")

    def interrupted(descriptor, _):
        os.close(descriptor)  # the stream that was made goes, and closes it
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fdopen", interrupted)
    with pytest.raises(KeyboardInterrupt):
        file_bytes(tmp_path / "a.py")


LOOKED_THROUGH_OF_OURS = {
    # What is installed: stand-ins, drivers, ROS, a collection of models.
    *("ros/imports/finder.py", "ros/vendors/driver_search.py", "twin/looks/menagerie.py"),
    "ros/live/messages/headers.py",
}


READERS_OF_OURS = {
    "pipeline/dossier/environment.py",
    *("cli/set_up/docs.py", "common/hardware/shipped.py", "report/html/page.py"),
    *("common/hardware/sysml/language/parsing.py", "pipeline/start/ci_files.py"),
    *("pipeline/start/schemas.py", "prm/formats/json_parts.py", "ros/messages/interface_texts.py"),
    *("twin/robots/index.py", "report/png/drawn.py", "pipeline/run/child.py"),
    # Files of /proc and /sys, and of a campaign that is under way.
    *("common/sandbox/kernel/features.py", "common/sandbox/kernel/control_groups.py"),
    *("common/sandbox/fork_server.py", "common/sandbox/limited_process.py"),
    "pipeline/evidence/cell_runs.py",
    "common/text/bounded.py",
}


def _reads(call):
    if isinstance(call.func, ast.Name):
        texts = [each.value for each in call.args if isinstance(each, ast.Constant)]
        return call.func.id == "open" and "rb" in texts
    name = getattr(call.func, "attr", "")
    texts = [each.value for each in call.args if isinstance(each, ast.Constant)]
    return name in ("read_text", "read_bytes") or (name == "open" and "rb" in texts)
