"""What lookups of transforms raise."""


class TransformException(Exception):
    """A transform is not available."""


class ConnectivityException(TransformException):
    """No transforms lead from one frame to the other."""


class LookupException(TransformException):
    """A frame does not exist."""


class ExtrapolationException(TransformException):
    """The time is not within what is known."""


class InvalidArgumentException(TransformException):
    """A frame's name is none."""


class TimeoutException(TransformException):
    """The answer did not come in time."""
