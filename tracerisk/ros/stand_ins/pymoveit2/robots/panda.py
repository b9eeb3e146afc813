"""The Panda."""

MOVE_GROUP_ARM = "arm"
MOVE_GROUP_GRIPPER = "gripper"
OPEN_GRIPPER_JOINT_POSITIONS = [0.04, 0.04]
CLOSED_GRIPPER_JOINT_POSITIONS = [0.0, 0.0]


def joint_names(prefix: str = "panda_") -> list[str]:
    """Return the joints of the arm."""
    return [f"{prefix}joint{number}" for number in range(1, 8)]


def base_link_name(prefix: str = "panda_") -> str:
    """Return the base link."""
    return prefix + "link0"


def end_effector_name(prefix: str = "panda_") -> str:
    """Return the link of the end effector."""
    return prefix + "hand_tcp"


def gripper_joint_names(prefix: str = "panda_") -> list[str]:
    """Return the joints of the fingers."""
    return [f"{prefix}finger_joint{number}" for number in (1, 2)]
