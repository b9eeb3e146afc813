"""What the library raises."""


class ActionException(Exception):
    """The type is no action: `Nav` in place of `NavAction`, say."""
