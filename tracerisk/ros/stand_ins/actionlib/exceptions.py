"""What the library raises."""


class ActionException(Exception):
    """The type is not an action: `Nav` in place of `NavAction`, say."""
