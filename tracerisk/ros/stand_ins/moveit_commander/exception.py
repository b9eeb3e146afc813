"""The error of moveit_commander."""


class MoveItCommanderException(Exception):
    """A call that MoveIt refuses: a bad argument, a target out of bounds, an unknown name."""
