"""The arms of Universal Robots."""

MOVE_GROUP_ARM = "ur_manipulator"
MOVE_GROUP_GRIPPER = "gripper"
OPEN_GRIPPER_JOINT_POSITIONS = [0.04, 0.04]
CLOSED_GRIPPER_JOINT_POSITIONS = [0.0, 0.0]
prefix = ""


def joint_names(prefix: str = prefix) -> list[str]:
    """Return the joints of the arm."""
    parts = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    return [f"{prefix}{part}_joint" for part in parts]


def base_link_name(prefix: str = prefix) -> str:
    """Return the base link."""
    return prefix + "base_link"


def end_effector_name(prefix: str = prefix) -> str:
    """Return the link of the end effector."""
    return prefix + "tool0"


def gripper_joint_names(prefix: str = prefix) -> list[str]:
    """Return the joints of the fingers: none."""
    return []
