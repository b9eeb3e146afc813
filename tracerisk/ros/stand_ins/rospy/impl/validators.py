"""The error of parameters that are no legal names."""


class ParameterInvalid(Exception):
    """A parameter of a call is no legal value."""
