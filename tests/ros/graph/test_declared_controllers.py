"""Which files of a workspace declare controllers, and which only look so."""

from types import SimpleNamespace

from tracerisk.ros.graph.declared_controllers import DeclaredControllers

HARDWARE = """\
robot: ur5e
components:
  electric_motor:
    probability: {value: 1e-8, per: minute}
    twin:
      joints: [shoulder_pan_joint]
"""


def test_failure_data_declare_no_controller(tmp_path):
    (tmp_path / "hardware.yaml").write_text(HARDWARE)
    declared = DeclaredControllers(SimpleNamespace(packages={"cell": tmp_path}))
    assert declared.all == {}
    # A key that a description of hardware has not makes it a file of something else.
    (tmp_path / "hardware.yaml").write_text(HARDWARE + "hand:\n  joints: [left, right]\n")
    declared = DeclaredControllers(SimpleNamespace(packages={"cell": tmp_path}))
    assert declared.all["hand"].joints == ("left", "right")
