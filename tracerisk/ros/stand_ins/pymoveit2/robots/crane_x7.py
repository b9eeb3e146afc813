"""The CRANE-X7."""

MOVE_GROUP_ARM = "arm"
MOVE_GROUP_GRIPPER = "gripper"
OPEN_GRIPPER_JOINT_POSITIONS = [0.7, 0.7]
CLOSED_GRIPPER_JOINT_POSITIONS = [0.0, 0.0]
robot_prefix = "crane_x7_"


def joint_names(prefix: str = robot_prefix) -> list[str]:
    """Return the joints of the arm."""
    parts = (
        "shoulder_fixed_part_pan_joint",
        "shoulder_revolute_part_tilt_joint",
        "upper_arm_revolute_part_twist_joint",
        "upper_arm_revolute_part_rotate_joint",
        "lower_arm_fixed_part_joint",
        "lower_arm_revolute_part_joint",
        "wrist_joint",
    )
    return [prefix + part for part in parts]


def base_link_name(prefix: str = robot_prefix) -> str:
    """Return the base link."""
    return "base_link"


def end_effector_name(prefix: str = robot_prefix) -> str:
    """Return the link of the end effector."""
    return prefix + "gripper_base_link"


def gripper_joint_names(prefix: str = robot_prefix) -> list[str]:
    """Return the joints of the fingers."""
    return [f"{prefix}gripper_finger_{finger}_joint" for finger in "ab"]
