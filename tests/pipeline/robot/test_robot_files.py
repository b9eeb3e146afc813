"""`--robot` with a file, and `robot` of the settings: what runs, and what is refused."""

import json
import resource
import time

import pytest

from tracerisk import cli

ARM = """<mujoco model="{name}">
  <worldbody><body name="stand"><geom type="cylinder" size="0.05 0.05"/>
    <body name="upper" pos="0 0 0.1"><joint name="joint_a" axis="0 0 1" range="-150 150"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.03" mass="1"/>
      <body name="fore" pos="0 0 0.25"><joint name="joint_b" axis="0 1 0" range="-100 100"/>
        <geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.03" mass="0.5"/>
      </body>
    </body>
  </body></worldbody>
  <actuator>{actuators}</actuator>
  <keyframe><key name="home" qpos="0.3 0.5"/></keyframe>
</mujoco>
"""
MOTORS = (
    '<position joint="joint_a" kp="500" kv="40" forcerange="-60 60"/>'
    '<position joint="joint_b" kp="500" kv="40" forcerange="-60 60"/>'
)
URDF = """<robot name="bent"{xmlns}>
  <link name="base"/>
  <link name="arm"><inertial><mass value="1"/></inertial>
    <visual><geometry><mesh filename="{mesh}"/></geometry></visual></link>
  <joint name="turn" type="{type}"><parent link="{parent}"/><child link="arm"/>
    <axis xyz="0 1 0"/><limit lower="{lower}" upper="2" effort="20" velocity="1"/></joint>
  {more}
</robot>
"""
CONTROLLER = """\
import sys
import moveit_commander, rospy

def reach(arm):
    arm.set_named_target("home")
    arm.go(wait=True)
    arm.go([0.1] * len(arm.get_active_joints()), wait=True)

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("reacher")
arm = moveit_commander.MoveGroupCommander("arm")
arm.set_max_velocity_scaling_factor(1.0)
arm.set_max_acceleration_scaling_factor(1.0)
reach(arm)
"""


def mjcf(name="reacher", actuators=MOTORS):
    return ARM.format(name=name, actuators=actuators)


def urdf(**changes):
    fields = {
        "mesh": "a.stl",
        "type": "revolute",
        "parent": "base",
        "lower": "-2",
        "more": "",
        "xmlns": "",
    }
    return URDF.format(**{**fields, **changes})


def refused(example, monkeypatch, capsys, robot, *, verb="run"):
    """Run the command in this process and return the message; the source must stay as it was."""
    example.write("pyproject.toml", "")
    source = example.write("controller.py", CONTROLLER)
    monkeypatch.chdir(example.folder)
    code = cli.main([verb, "controller.py", "--robot", robot])
    out, err = capsys.readouterr()
    assert (code, out) == (2, ""), err
    assert source.read_text() == CONTROLLER
    assert not (example.folder / "tracerisk.lock").exists()
    assert len(err.strip().splitlines()) == 1
    assert "Traceback" not in err
    return err


def test_a_controller_drives_an_mjcf_without_actuators(example):
    example.write("pyproject.toml", "")
    example.write("controller.py", CONTROLLER)
    example.write("robots/reacher.xml", mjcf(actuators=""))
    outcome = example.run("run", "controller.py", "--robot", "robots/reacher.xml", "--json")
    assert outcome.code == 0, outcome.err
    assert b"electric_motor" in example.read("controller.py")


@pytest.mark.slow
def test_hardware_names_the_motors_as_the_model_does(example):
    example.write("pyproject.toml", "")
    example.write("controller.py", CONTROLLER)
    named = MOTORS.replace("<position", '<position name="{}"').format("harmonic_1", "harmonic_2")
    example.write("reacher.xml", mjcf(actuators=named))
    shown = example.run("robots", "reacher.xml").out
    assert "actuators:\n  harmonic_1  joint_a\n  harmonic_2  joint_b\n" in shown
    hardware = "components:\n  drive:\n    failure_rate: {value: 570, unit: FIT}\n"
    example.write("own.yaml", hardware + "    twin: {actuators: [harmonic_2]}\n")
    run = ("run", "controller.py", "--robot", "reacher.xml", "--hardware", "own.yaml")
    outcome = example.run(*run, "--trace", "trace.json")
    assert outcome.code == 0, outcome.err
    assert b"name = drive" in example.read("controller.py")
    trace = json.loads(example.read("trace.json"))
    driven = {each["name"]: each["actuators"] for each in trace["elements"] if each["actuators"]}
    assert driven == {"joint_a": ["harmonic_1"], "joint_b": ["harmonic_2"]}
    example.write("own.yaml", hardware + "    twin: {actuators: [joint_b]}\n")
    outcome = example.run(*run)
    assert outcome.code == 2
    assert "own.yaml:2" in outcome.err
    assert "allowed: harmonic_1, harmonic_2" in outcome.err


def test_a_model_of_the_settings_stands_at_the_root_and_its_bytes_are_in_the_lock(example):
    example.write("pyproject.toml", '[tool.tracerisk]\nrobot = "robots/reacher.xml"\n')
    example.write("steps/controller.py", CONTROLLER)
    included = f"<mujocoinclude>{MOTORS}</mujocoinclude>"
    example.write("robots/motors.xml", included)
    example.write("robots/reacher.xml", mjcf(actuators='<include file="motors.xml"/>'))
    assert example.run("run", "steps/controller.py").code == 0
    lock, source = example.read("tracerisk.lock"), example.read("steps/controller.py")
    # Only a word in the file that is included changes, and nothing of the motion.
    example.write("robots/motors.xml", included.replace("><position", "> <position"))
    assert example.run("run", "steps/controller.py").code == 0
    assert example.read("steps/controller.py") == source
    changed = set(lock.splitlines()) ^ set(example.read("tracerisk.lock").splitlines())
    named = sorted(line.split(b'"')[1] for line in changed)
    assert named == [
        *(b"digest", b"digest"),
        *(b"fingerprint", b"fingerprint"),
        *(b"robots/motors.xml", b"robots/motors.xml"),
        *(b"run", b"run"),  # of what is behind the values
    ]


def test_doctor_says_what_was_read(example):
    example.write("pyproject.toml", "")
    example.write("controller.py", CONTROLLER)
    example.write("reacher.xml", mjcf())
    found = example.run("doctor", "controller.py", "--robot", "reacher.xml", "--json").json["found"]
    assert found["robot"].startswith("reacher (")
    assert found["joints"].startswith("joint_a -2.618 to 2.618")
    assert found["groups"] == "arm: joint_a, joint_b"
    assert found["named states"] == "arm: home"
    assert found["robot files read"].endswith("reacher.xml")


def test_a_xacro_finds_its_packages_and_an_srdf_beside_names_its_groups(example):
    example.write("pyproject.toml", "")
    example.write("controller.py", CONTROLLER.replace('"arm"', '"bender"').replace("home", "low"))
    example.write("parts/package.xml", "<package><name>bent_parts</name></package>")
    example.write(
        "parts/urdf/arm.xacro",
        urdf(
            mesh="package://bent_parts/gone.stl",
            more='<joint name="on" type="fixed"><parent link="arm"/><child link="tool"/></joint>',
        ),
    )
    example.write(
        "parts/urdf/bent.urdf.xacro",
        '<robot name="bent" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:include filename="$(find bent_parts)/urdf/arm.xacro"/>'
        '<xacro:include filename="tool.xacro"/></robot>',
    )
    example.write("parts/urdf/tool.xacro", '<robot><link name="tool"/></robot>')
    example.write(
        "parts/config/bent.srdf",
        '<robot name="bent"><group name="bender"><joint name="turn"/></group>'
        '<group_state name="low" group="bender"><joint name="turn" value="1"/></group_state></robot>',
    )
    robot = "parts/urdf/bent.urdf.xacro"
    found = example.run("doctor", "controller.py", "--robot", robot, "--json").json["found"]
    assert found["groups"] == "bender: turn"
    assert all(
        name in found["robot files read"] for name in ("arm.xacro", "tool.xacro", "bent.srdf")
    )
    outcome = example.run("run", "controller.py", "--robot", robot)
    assert outcome.code == 0, outcome.err


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("gone.xml", None, "gone.xml: there is no such file"),
        ("pandda", None, "unknown robot 'pandda'; did you mean 'panda'?"),
        (".", None, "unknown robot '.'; allowed:"),
        ("empty.xml", "\n", "empty.xml: is empty"),
        ("page.xml", "<!DOCTYPE html><html></html>", "page.xml: is an HTML page; download the file"),
        ("lfs.urdf", "version https://git-lfs.github.com/spec/v1\n", "is a pointer of Git LFS"),
        ("binary.xml", b"\x00\x01\x02", "binary.xml:1:1: is not XML"),
        ("half.xml", "<mujoco><worldbody>", "half.xml:1:20: is not XML"),
        ("other.xml", "<launch/>", "other.xml:1: <launch>: describes no robot; allowed: mujoco (MJCF), robot"),
        ("world.xml", "<sdf/>", "world.xml:1: <sdf>: is an SDF, which is not read"),
        ("arm.urdf", urdf(type="hinge"), "arm.urdf:5: <joint>: unknown joint type 'hinge'; allowed: continuous"),
        ("arm.urdf", urdf(lower="nan"), "arm.urdf:6: <limit>: attribute 'lower' is 'nan'"),
        ("arm.urdf", urdf(parent="floor"), "arm.urdf:5: <parent>: there is no link 'floor'"),
        ("arm.urdf", urdf(parent="arm"), "arm.urdf: is not a tree"),
        ("arm.urdf", urdf(more='<link name="b"/><joint name="x" type="fixed"><parent link="b"/><child link="arm"/></joint>'), "hangs on 'turn' and on 'x'"),
        ("arm.urdf", urdf(more='<link name="alone"/>'), "arm.urdf: is not a tree: 2 links have no parent (base, alone)"),
        ("arm.urdf", urdf(mesh="../../a.stl"), "arm.urdf:4: <mesh>: '../../a.stl' lies outside"),
        ("arm.urdf", urdf(mesh="file:///etc/a.stl"), "arm.urdf:4: <mesh>: 'file:///etc/a.stl' lies outside"),
        ("arm.urdf", urdf(mesh="http://there/a.stl"), "arm.urdf:4: <mesh>: 'http://there/a.stl' is not read"),
        ("bomb.urdf", '<!DOCTYPE r [<!ENTITY a "aa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>', "bomb.urdf:1: declares a document type"),
        ("arm.xacro", urdf(xmlns=' xmlns:xacro="x"', more='<xacro:include filename="/etc/hosts"/>'), "arm.xacro:7: '/etc/hosts' lies outside"),
        ("arm.xacro", urdf(xmlns=' xmlns:xacro="x"', more='${1/0}'), "arm.xacro: xacro cannot expand it"),
        ("arm.xml", mjcf(actuators='<include file="../m.xml"/>'), "arm.xml:10: <include>: '../m.xml' lies outside"),
        ("arm.xml", mjcf(actuators='<position joint="wrist"/>'), "arm.xml:10: MuJoCo refuses the model"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_reported_in_one_line(
    example, monkeypatch, capsys, name, text, message
):
    if text is not None:
        example.write(name, text)
    assert message in refused(example, monkeypatch, capsys, name)


def test_a_huge_file_is_not_read(example, monkeypatch, capsys):
    with (example.folder / "huge.xml").open("wb") as stream:
        stream.truncate(2**34)
    assert "at most 16777216 are read" in refused(example, monkeypatch, capsys, "huge.xml")


def test_what_is_no_file_is_not_read(example, monkeypatch, capsys):
    (example.folder / "folder.xml").mkdir()
    assert "folder.xml: is not a file" in refused(example, monkeypatch, capsys, "folder.xml")
    assert "null" in refused(example, monkeypatch, capsys, "/dev/null")


REPLICATE = '<replicate count="900" offset="1 0 0">{}</replicate>'
FEWER = REPLICATE.replace("900", "120")


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("text", "message"),
    [
        (REPLICATE.format(REPLICATE.format("<body/>")), "<replicate>: makes 810000 copies"),
        (REPLICATE.format('<geom size="1"/>' * 1000), "copies counted, at most 50000 elements"),
        (FEWER.format('<body><joint/><geom size="1"/></body>' * 5), "has 601 bodies; at most 500"),
    ],
)  # fmt: skip
def test_bombs_are_refused_in_time_and_memory(example, monkeypatch, capsys, text, message):
    example.write("bomb.xml", f"<mujoco><worldbody>{text}</worldbody></mujoco>")
    began = time.monotonic()
    assert message in refused(example, monkeypatch, capsys, "bomb.xml")
    assert time.monotonic() - began < 10.0
    # The largest of all processes that these tests have started [KiB].
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < 2.5 * 1024**2
