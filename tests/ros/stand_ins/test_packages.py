"""Packages of the workspace: rospkg, roslib, ament_index_python, catkin."""

import os

PACKAGE = """\
<package format="2"><name>{name}</name><version>1.2.3</version><description>d</description>
<license>MIT</license><author>A</author><author>B</author><depend>{depend}</depend></package>
"""
PROGRAM = """\
import os, roslib, rospkg
roslib.load_manifest("arm")
pack = rospkg.RosPack()
assert pack.list() == ["arm", "parts"], pack.list()
assert os.path.isfile(pack.get_path("parts") + "/config/tools.yaml")
manifest = pack.get_manifest("arm")
assert (manifest.version, manifest.license, manifest.author) == ("1.2.3", "MIT", "A, B")
assert pack.get_depends("arm") == ["parts"] and pack.get_depends_on("parts") == ["arm"]
assert rospkg.get_package_name(__file__) == "arm"
assert roslib.packages.get_pkg_dir("parts").endswith("parts")
assert roslib.packages.find_resource("parts", "tools.yaml")[0].endswith("config/tools.yaml")
assert roslib.message.get_message_class("std_msgs/String")(data="x").data == "x"
assert roslib.message.get_message_class("nope_msgs/String") is None
try:
    pack.get_path("nope"); raise SystemExit("found")
except rospkg.ResourceNotFound as error:
    assert "nope" in str(error) and "ROS path [0]=" in str(error)

from roslaunch.substitution_args import ArgException, SubstitutionException, resolve_args
assert resolve_args("a $(find parts)/config b") == f"a {pack.get_path('parts')}/config b"
assert resolve_args("$(optenv NOPE a b)/$(arg x)", {"arg": {"x": "1"}}) == "a b/1"
assert (resolve_args(None), resolve_args("$5 (x)")) == (None, "$5 (x)")
for text, kind in (
    ("$(arg x)", ArgException), ("$(env NOPE)", SubstitutionException),
    ("$(nope x)", SubstitutionException), ("$(find nope)", rospkg.ResourceNotFound),
):
    try:
        resolve_args(text); raise SystemExit(text)
    except kind:
        pass

from ament_index_python.packages import *
from ament_index_python import PackageNotFoundError, get_package_share_directory, get_package_share_path
assert get_package_share_directory("parts") == pack.get_path("parts")
assert (get_package_share_path("parts") / "config").is_dir()
for name, kind, told in (("nope", PackageNotFoundError, "arm, parts"), ("no pe", ValueError, "valid")):
    try:
        get_package_share_directory(name); raise SystemExit("found")
    except kind as error:
        assert told in str(error), error
"""


def test_packages_of_the_workspace_are_found_where_they_stand(example):
    example.write("ws/.git/HEAD", "")
    example.write("ws/arm/package.xml", PACKAGE.format(name="arm", depend="parts"))
    example.write("ws/parts/package.xml", PACKAGE.format(name="parts", depend="roscpp"))
    example.write("ws/parts/config/tools.yaml", "a: 1\n")
    example.write("ws/arm/scripts/run.py", PROGRAM)
    outcome = example.run("trace", "ws/arm/scripts/run.py", "--robot", "panda")
    assert outcome.code == 0, outcome.err


HOSTILE = """\
import rospkg
for name in ("bomb", "large", "pipe"):
    try:
        rospkg.RosPack().get_manifest(name); raise SystemExit(f"read {name}")
    except rospkg.InvalidManifest as error:
        assert "package.xml" in str(error), error
"""


def test_a_manifest_that_would_fill_memory_or_block_is_invalid(example):
    entities = "".join(f'<!ENTITY a{n + 1} "{f"&a{n};" * 10}">' for n in range(20))
    bomb = f'<!DOCTYPE a [<!ENTITY a0 "b">{entities}]><package><name>bomb</name>&a20;</package>'
    example.write("ws/src/bomb/package.xml", bomb)
    for name in ("large", "pipe"):
        (example.folder / "ws/src" / name).mkdir()
    with (example.folder / "ws/src/large/package.xml").open("wb") as stream:
        stream.truncate(500 * 1024**2)
    os.mkfifo(example.folder / "ws/src/pipe/package.xml")
    example.write("ws/src/go.py", HOSTILE)
    outcome = example.run("trace", "ws/src/go.py", "--robot", "panda")
    assert outcome.code == 0, outcome.err


def test_catkin_finds_the_files_of_a_package(example):
    example.write("package.xml", "<package><name>cell</name></package>\n")
    example.write("config/poses.yaml", "a: 1\n")
    example.write(
        "scripts/c.py",
        "import rospy\nfrom catkin.find_in_workspaces import find_in_workspaces as find\n"
        "rospy.init_node('c')\n"
        "print([path[-17:] for path in find(['share'], 'cell', 'config/poses.yaml')])\n"
        "print(find(['share'], 'cell', 'config/none.yaml'), find(project='none'))\n",
    )
    outcome = example.run("run", "scripts/c.py")
    assert "['config/poses.yaml']\n[] []" in outcome.out + outcome.err
