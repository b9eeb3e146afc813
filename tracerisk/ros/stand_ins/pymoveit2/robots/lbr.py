"""The LBR arms of KUKA."""

MOVE_GROUP_ARM = "arm"


def joint_names() -> list[str]:
    """Return the joints of the arm, as the library numbers them."""
    return [f"A{number}" for number in range(8)]


def base_link_name() -> str:
    """Return the base link."""
    return "link_0"


def end_effector_name() -> str:
    """Return the link of the end effector."""
    return "link_ee"
