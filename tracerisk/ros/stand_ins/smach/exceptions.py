"""The errors of smach."""


class InvalidStateError(Exception):
    """A state that a container cannot hold."""


class InvalidTransitionError(Exception):
    """A transition from an unknown outcome, or to nowhere."""


class InvalidConstructionError(Exception):
    """A container that is put together wrongly."""


class InvalidUserCodeError(Exception):
    """Code of a state that raised, gave an unknown outcome or asked for undeclared data."""


class PreemptError(Exception):
    """A preempt that cannot be carried out."""
