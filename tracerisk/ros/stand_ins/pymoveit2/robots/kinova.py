"""The Jaco and Mico of Kinova."""

MOVE_GROUP_ARM = "arm"
MOVE_GROUP_GRIPPER = "gripper"
JACO_PREFIX = "j2"
MICO_PREFIX = "m1"


def get_prefix(
    version_prefix: str = JACO_PREFIX,
    arm_dof: int = 6,
    hand_dof: int = 2,
    spherical: bool = False,
    assistive: bool = False,
) -> str:
    """Return the prefix of a model's names."""
    wrist, kind = "s" if spherical else "n", "a" if assistive else "s"
    return f"{version_prefix}{wrist}{arm_dof}{kind}{hand_dof}00_"


def joint_names(prefix: str = get_prefix()) -> list[str]:
    """Return the joints of the arm."""
    return [f"{prefix}joint_{number + 1}" for number in range(int(prefix[3]))]


def base_link_name(prefix: str = get_prefix()) -> str:
    """Return the base link."""
    return prefix + "link_base"


def end_effector_name(prefix: str = get_prefix()) -> str:
    """Return the link of the end effector."""
    return prefix + "end_effector"


def gripper_joint_names(prefix: str = get_prefix()) -> list[str]:
    """Return the joints of the fingers."""
    return [f"{prefix}joint_finger_{number + 1}" for number in range(int(prefix[5]))]
