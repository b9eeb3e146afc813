"""The readers of what lies in a workspace beside texts of ours: sources in an editor, launch files,
robots, recordings. Each takes bytes and a folder, and returns or raises as `readers.py` says.
"""

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from lsprotocol import types as lsp

from tracerisk.common.text.printable import printable_json
from tracerisk.editor import server
from tracerisk.editor.session import Session, analyse, controllers_with
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.launch_files.roslaunch_xml import read_roslaunch
from tracerisk.pipeline.launch_files.visit import visit
from tracerisk.pipeline.recordings.declared import Declared
from tracerisk.pipeline.recordings.measured import measured_trace
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.urdf.urdf import read_urdf
from tracerisk.twin.urdf.xacro_files import expand_xacro

EDITED = b"""\
import rospy

def turn(arm):
    # | RiskAnnotation
    # | @Function {
    # |   name = turn
    # |   callSequence := 2  ! computed 1; why
    # |   next = done 1
    # | }
    # | @Component {
    # |   name = motor
    # |   probability = 9.5e-08
    # |   quantity = 7
    # |   redundancy = required 2, spare warm 0.1, common_cause 0.1
    # | }
    arm.go([0.0, 0.5], wait=True)

class Cell:
    def place(self):
        # | RiskAnnotation #1234
        # | place: 1, next done 1
        # | gripper 2e-07
        turn(self.arm)
"""
LAUNCH_1 = b"""\
<launch>
  <arg name="speed" default="0.5"/> <arg name="arm" value="$(arg speed)"/>
  <group ns="cell" if="$(eval 1 + 1 == 2)"><param name="a" value="$(arg speed)" type="double"/>
  <node pkg="cell" type="pick.py" name="pick" args="--x $(find cell)" output="screen">
    <remap from="/a" to="/b"/><rosparam>{a: [1, 2], b: {c: yes}}</rosparam>
    <rosparam param="p">3</rosparam></node></group>
  <include file="$(dirname)/other.launch" unless="false"><arg name="x" value="1"/></include>
  <env name="A" value="b"/><!-- of the cell -->
</launch>
"""
LAUNCH_2 = b"""\
<launch>
  <arg name="speed" default="0.5"/> <let name="a" value="$(var speed)"/>
  <group><push_ros_namespace namespace="cell"/>
  <node pkg="cell" exec="pick" name="pick" args="--x $(find-pkg-share cell)" if="$(eval '1 < 2')">
    <param name="a" value="$(env HOME x)"/><param name="b"><param name="c" value="1"/></param>
    <remap from="a" to="b"/></node></group>
  <include file="$(dirname)/other.launch.xml"><arg name="x" value="1"/></include>
  <executable cmd="ls -l" output="screen"/>
</launch>
"""
LAUNCH_YAML = b"""\
launch:
- arg: {name: speed, default: "0.5"}
- group:
  - push_ros_namespace: {namespace: cell}
  - node: {pkg: cell, exec: pick, name: pick, param: [{name: a, value: $(var speed)}, {from: p.yaml}]}
- include: {file: "$(dirname)/other.launch.py", arg: [{name: x, value: "1"}]}
- set_parameter: {name: use_sim_time, value: true}
"""
URDF = b"""\
<robot name="arm">
  <link name="base"><inertial><mass value="1"/><origin xyz="0 0 0.1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="upper"><inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
    <collision><geometry><cylinder radius="0.05" length="0.3"/></geometry></collision></link>
  <link name="tool"><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>
  <joint name="j1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/><dynamics damping="0.1"/></joint>
  <joint name="j2" type="continuous"><parent link="upper"/><child link="tool"/>
    <origin xyz="0 0 0.3" rpy="0 1.57 0"/><limit effort="10" velocity="2"/></joint>
  <joint name="m" type="prismatic"><parent link="tool"/><child link="finger"/>
    <mimic joint="j2" multiplier="2"/><limit lower="0" upper="0.04" effort="10" velocity="2"/></joint>
  <link name="finger"/>
</robot>
"""
XACRO = b"""\
<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="size" default="0.1"/><xacro:property name="r" value="${0.1 * 2 ** 2}"/>
  <xacro:macro name="part" params="name parent:=base *origin"><link name="${name}"/>
    <joint name="${name}_joint" type="fixed"><parent link="${parent}"/><child link="${name}"/>
      <xacro:insert_block name="origin"/></joint></xacro:macro>
  <link name="base"/><xacro:part name="a"><origin xyz="${r} 0 $(arg size)"/></xacro:part>
  <xacro:if value="${r &gt; 1}"><link name="never"/></xacro:if>
</robot>
"""


def edit(data: bytes, folder: Path) -> object:
    """Open a source in the language server, check it, and ask everything at several places."""
    path = folder / "cell.py"
    path.write_bytes(data)
    uri, text = path.as_uri(), data.decode("utf-8", "surrogateescape")
    risk_server, session = _server(), Session()
    risk_server.session = session
    document = session.put(uri, 1, text)
    try:
        for controller in controllers_with(document, session.projects):
            found = analyse(controller, session.opened, session.projects)
            session.analyses[controller.resolve()] = found
    except TraceRiskError:
        pass  # the server shows it
    session.remember(document, (path,))
    shown: list[Any] = [server.diagnostics_of(session)]
    identifier = lsp.TextDocumentIdentifier(uri)
    plain: Any = SimpleNamespace(text_document=identifier)
    shown += [server._code_lens(risk_server, plain), server._folding(risk_server, plain)]
    count = len(document.lines.texts)
    for number in sorted({0, count // 2, len(data) % max(count, 1)}):
        line = document.lines.text(number)
        for column in {len(line) // 2, len(line)}:
            at = lsp.Position(number, column)
            here: Any = SimpleNamespace(
                text_document=identifier,
                position=at,
                range=lsp.Range(at, at),
                context=lsp.CodeActionContext([]),
            )
            shown += [server._hover(risk_server, here), server._completion(risk_server, here)]
            shown.append(server._code_action(risk_server, here))
    return shown


@cache
def _server() -> server.RiskServer:
    return server.language_server()


def hear(name: str) -> Callable[[bytes, Path], object]:
    """Return what reads a recording of the panda, in a file of this name."""

    def of(data: bytes, folder: Path) -> object:
        path = folder / name
        path.unlink(missing_ok=True)
        path.write_bytes(data)
        return measured_trace(path, _panda(), Declared())

    return of


@cache
def _panda() -> Any:
    return load_robot("panda")


def start(data: bytes, folder: Path) -> object:
    """Read a launch file of ROS 1, which finds no other file."""
    path = folder / "cell.launch"
    path.write_bytes(data)
    return printable_json(repr(read_roslaunch(path, {"cell": folder})))


def expand(data: bytes, folder: Path) -> object:
    """Expand a xacro file, in a process of its own."""
    path = folder / "arm.urdf.xacro"
    path.write_bytes(data)
    return expand_xacro(path, {"cell": folder})


def visited(name: str) -> Callable[[bytes, Path], object]:
    """Return what reads a launch file of ROS 2 of this name, and starts what it says."""

    def read(data: bytes, folder: Path) -> object:
        path = folder / name
        path.write_bytes(data)
        return repr(visit(path, {"cell": folder}, ()))

    return read


WORKSPACE: Mapping[str, tuple[Callable[[bytes, Path], object], tuple[bytes, ...]]] = {
    "editor": (edit, (EDITED,)),
    "launch_ros1": (start, (LAUNCH_1,)),
    "launch_xml": (visited("a.launch.xml"), (LAUNCH_2,)),
    "launch_yaml": (visited("a.launch.yaml"), (LAUNCH_YAML,)),
    "urdf": (lambda data, _: read_urdf(data, "arm.urdf"), (URDF,)),
    "recorded": (hear("mission.recording"), ()),
}
EXPANDED = (expand, (XACRO,))
"""Each input takes a process: it is read a hundredth as often."""
