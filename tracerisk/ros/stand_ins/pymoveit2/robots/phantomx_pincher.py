"""The PhantomX Pincher."""

MOVE_GROUP_ARM = "arm"
MOVE_GROUP_GRIPPER = "gripper"
OPEN_GRIPPER_JOINT_POSITIONS = [0.0158, 0.0158]
CLOSED_GRIPPER_JOINT_POSITIONS = [0.001, 0.001]


def joint_names(prefix: str = "phantomx_pincher_") -> list[str]:
    """Return the joints of the arm."""
    parts = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex")
    return [f"{prefix}arm_{part}_joint" for part in parts]


def base_link_name(prefix: str = "phantomx_pincher_") -> str:
    """Return the base link."""
    return prefix + "arm_base_link"


def end_effector_name(prefix: str = "phantomx_pincher_") -> str:
    """Return the link of the end effector."""
    return prefix + "end_effector"


def gripper_joint_names(prefix: str = "phantomx_pincher_") -> list[str]:
    """Return the joints of the fingers."""
    return [f"{prefix}gripper_finger{number}_joint" for number in (1, 2)]
