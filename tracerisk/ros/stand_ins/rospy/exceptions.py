"""The exceptions of rospy."""


class ROSException(Exception):
    """Base of what rospy raises."""


class ROSSerializationException(ROSException):
    """A message cannot be sent: a field holds what its type cannot take."""


class ROSInitException(ROSException):
    """The node, or its time, is not initialized."""


class ROSInterruptException(ROSException, KeyboardInterrupt):
    """An operation was interrupted: the node shuts down."""


class ROSTimeMovedBackwardsException(ROSInterruptException):
    """The time moved backwards while something slept, by `time` seconds."""

    def __init__(self, time: float) -> None:
        self.time = time
        super().__init__("ROS time moved backwards")


class ROSInternalException(Exception):
    """Base of what is internal to ROS."""


class TransportException(ROSInternalException):
    """Base of the errors of connections."""


class TransportTerminated(TransportException):
    """A connection is gone."""


class TransportInitError(TransportException):
    """A connection could not be made."""
