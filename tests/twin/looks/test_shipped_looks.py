"""Looks as they are shipped, and what is said of one that is malformed."""

import pytest

from tracerisk.errors import RobotError
from tracerisk.twin.looks.shipped_looks import SHIPPED_LOOKS, read_look, shipped_looks
from tracerisk.twin.robots.robot import robot_names

LOOK = """\
made_for: panda
source: own
paints: {shell: "#f3f4f5"}
links:
  link0:
    - {tube: [0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.2, 0.1], flat: true}
"""


def test_every_look_is_made_for_a_shipped_robot_and_gives_its_source():
    looks = shipped_looks()
    assert [look.name for look in looks] == sorted(path.stem for path in SHIPPED_LOOKS.iterdir())
    for look in looks:
        assert look.made_for in robot_names()
        assert len(look.source) > 20
        assert all(look.links.values())


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.2, 0.1]", "0.2]", r"bad\.yaml:6:.*each point has four numbers"),
        ("0.2, 0.1]", "0.2, 0.0]", r"a radius above 0"),
        ('"#f3f4f5"', "white", r"bad\.yaml:3:.*a colour is # and six"),
        ("flat: true", "paint: rust", r"unknown paint 'rust'; .*shell"),
        ("flat: true", "box: [1, 1, 1]", r"either a tube or a box"),
        ("flat: true", "flatt: true", r"flatt"),
        ("made_for: panda\n", "", r"made_for"),
    ],
)
def test_a_malformed_look_names_the_place_and_what_is_allowed(tmp_path, old, new, message):
    path = tmp_path / "bad.yaml"
    path.write_text(LOOK.replace(old, new), encoding="utf-8")
    with pytest.raises(RobotError, match=message):
        read_look(path)
