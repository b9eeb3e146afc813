"""A held file is opened by each of its names, and by no name of another file."""

import os

import pytest

from tests.forked import in_child
from tracerisk.common.sandbox.files import held_files
from tracerisk.common.sandbox.kernel.features import restrict, support

pytestmark = pytest.mark.skipif(bool(support().missing), reason="needs Landlock and seccomp")

WAYS = {
    "a folder": "os.read(os.open('poses.yaml', os.O_RDONLY, dir_fd=there), 99).decode()",
    "no folder": "os.read(os.open('poses.yaml', os.O_RDONLY, dir_fd=None), 99).decode()",
    "an opener": "open('poses.yaml', opener=lambda p, f: os.open(p, f, dir_fd=there)).read()",
    "its full path": "os.read(os.open(os.path.abspath('poses.yaml'), 0, dir_fd=there), 99).decode()",
}


def read(folder, held_of, code: str) -> str:
    """Return what is read in `here` of files that were saved anew since they were held."""
    paths = [folder / name / "poses.yaml" for name in ("here", "there")]
    for path in paths:
        path.parent.mkdir()
        path.write_text(path.parent.name)

    def contained() -> str:
        os.chdir(paths[0].parent)
        there = os.open(paths[1].parent, os.O_RDONLY)
        held = held_files.hold([str(path) for path in paths if path.parent.name in held_of])
        for path in paths:
            path.rename(path.with_name("old"))
            path.write_text("saved anew")
        restrict(["/usr", *held.values()], [str(path.parent) for path in paths], [])
        held_files.serve(held)
        try:
            return eval(code, {"os": os, "there": there})
        except PermissionError:
            return "refused"

    return in_child(contained)


@pytest.mark.parametrize(
    ("way", "expected"),
    [
        ("a folder", "there"),
        ("no folder", "here"),
        ("an opener", "there"),
        ("its full path", "here"),
    ],
)
def test_a_name_is_looked_up_in_the_folder_that_is_given_with_it(tmp_path, way, expected):
    assert read(tmp_path, ["here", "there"], WAYS[way]) == expected


@pytest.mark.parametrize("way", ["a folder", "an opener"])
def test_a_name_that_is_refused_in_another_folder_is_not_taken_from_the_current_one(tmp_path, way):
    assert read(tmp_path, ["here"], WAYS[way]) == "refused"
