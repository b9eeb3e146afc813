"""Limits of the processes that read models: no robot is chosen for want of time."""

import os
from dataclasses import replace

import pytest

from tracerisk import api
from tracerisk.common.limits import DEFAULT_LIMITS, Limit
from tracerisk.config import Settings
from tracerisk.errors import LimitError, RobotError
from tracerisk.pipeline.robot.choice import choose_robot
from tracerisk.twin.model_files.mjcf_model import mesh_shapes
from tracerisk.twin.urdf.xacro_files import expand_xacro

SHORT = replace(DEFAULT_LIMITS, own=Limit("stall_limit_s", 0.3))
# Each macro expands into two of the next: 2^40 in all.
ENDLESS = """<robot name="bent" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="twice" params="n">
    <xacro:if value="${n > 0}"><xacro:twice n="${n - 1}"/><xacro:twice n="${n - 1}"/></xacro:if>
  </xacro:macro>
  <link name="bent_base"/><xacro:twice n="40"/>
</robot>
"""
TOLD = r"took more than 0\.3 s of CPU time or sleep; raise it with --stall-limit"


def test_a_xacro_that_expands_for_ever_ends_with_its_limit(tmp_path):
    path = tmp_path / "bent.urdf.xacro"
    path.write_text(ENDLESS)
    with pytest.raises(LimitError, match=rf"bent\.urdf\.xacro: expanding the xacro file {TOLD}"):
        expand_xacro(path, {}, limits=SHORT)


def test_a_controller_gets_no_generic_arm_where_the_xacro_of_its_workspace_takes_too_long(tmp_path):
    (tmp_path / "package.xml").write_text("<package><name>bent</name></package>")
    (tmp_path / "bent.urdf.xacro").write_text(ENDLESS)
    script = tmp_path / "reach.py"
    script.write_text('LINK = "bent_base"\n')
    with pytest.raises(LimitError, match=TOLD):
        choose_robot(api.load_controller(script), Settings(stall_limit_s=0.3))


def test_a_mesh_that_has_no_end_is_not_left_out(tmp_path):
    os.mkfifo(tmp_path / "arm.stl")
    with pytest.raises(RobotError, match=r"be compiled: \S+arm\.stl: cannot be read: it is a pipe"):
        mesh_shapes({"mesh0.stl": (tmp_path / "arm.stl", (1.0, 1.0, 1.0))}, "arm.urdf", SHORT)
