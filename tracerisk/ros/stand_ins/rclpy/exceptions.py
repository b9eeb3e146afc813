"""The exceptions of rclpy."""

from __future__ import annotations

from typing import Any

from tracerisk.ros.graph.runtime import current


def _arguments(text: str, details: tuple[Any, ...], separator: str = ": ") -> tuple[Any, ...]:
    """Return the arguments of an error: what Humble keeps apart Jazzy joins to one text."""
    if _keeps_apart():
        return (text, *details)
    return (separator.join((text, *map(str, details))),)


def _keeps_apart() -> bool:
    return bool(current().distro.value("words-of-errors") == "several arguments")


class NotInitializedException(Exception):
    """`rclpy.init()` has not been called."""

    def __init__(self, *args: Any) -> None:
        text = "rclpy.init() has not been called"
        super().__init__(
            *(_arguments(text, args, ". msg:") if args or _keeps_apart() else (f"{text}.",))
        )


class NoTypeSupportImportedException(Exception):
    """A class is not an interface of ROS 2."""

    def __init__(self, *args: Any) -> None:
        super().__init__("no type_support imported", *args)


class InvalidHandle(Exception):
    """What is used has been destroyed."""


class NameValidationException(Exception):
    """A name is not one that ROS takes."""

    def __init__(
        self, name_type: str, name: str, error_msg: str, invalid_index: int, *args: Any
    ) -> None:
        mark = " " * invalid_index
        super().__init__(f"Invalid {name_type}: {error_msg}:\n  '{name}'\n   {mark}^", *args)


class InvalidNamespaceException(NameValidationException):
    """A namespace is not one that ROS takes."""

    def __init__(self, name: str, error_msg: str, invalid_index: int, *args: Any) -> None:
        super().__init__("namespace", name, error_msg, invalid_index, *args)


class InvalidNodeNameException(NameValidationException):
    """A node's name is not one that ROS takes."""

    def __init__(self, name: str, error_msg: str, invalid_index: int, *args: Any) -> None:
        super().__init__("node name", name, error_msg, invalid_index, *args)


class InvalidTopicNameException(NameValidationException):
    """A topic's name is not one that ROS takes."""

    def __init__(self, name: str, error_msg: str, invalid_index: int, *args: Any) -> None:
        super().__init__("topic name", name, error_msg, invalid_index, *args)


class InvalidServiceNameException(NameValidationException):
    """A service's name is not one that ROS takes."""

    def __init__(self, name: str, error_msg: str, invalid_index: int, *args: Any) -> None:
        super().__init__("service name", name, error_msg, invalid_index, *args)


class ParameterException(Exception):
    """Base of the errors of parameters."""

    def __init__(self, error_msg: str, parameters: Any, *args: Any) -> None:
        super().__init__(*_arguments(error_msg, (parameters, *args)))


class ParameterNotDeclaredException(ParameterException):
    """A parameter is used that was not declared."""

    def __init__(self, parameters: Any, *args: Any) -> None:
        super().__init__("Invalid access to undeclared parameter(s)", parameters, *args)


class ParameterAlreadyDeclaredException(ParameterException):
    """A parameter is declared a second time."""

    def __init__(self, parameters: Any, *args: Any) -> None:
        super().__init__("Parameter(s) already declared", parameters, *args)


class InvalidParameterException(ParameterException):
    """A parameter's name is not one that ROS takes."""

    def __init__(self, parameter: Any, *args: Any) -> None:
        super().__init__("Invalid parameter name", parameter, *args)


class InvalidParameterTypeException(ParameterException):
    """A parameter is given a value of another type than it was declared with."""

    def __init__(self, desired_parameter: Any, expected_type: str, *args: Any) -> None:
        super().__init__(
            f"Trying to set parameter '{desired_parameter.name}' to '{desired_parameter.value}'"
            f" of type '{desired_parameter.type_.name}', expecting type '{expected_type}'",
            desired_parameter.name,
            *args,
        )


class InvalidParameterValueException(ParameterException):
    """A callback or a descriptor refuses a parameter's value."""

    def __init__(self, parameter: Any, value: Any, reason: str, *args: Any) -> None:
        super().__init__(
            f"Invalid parameter value ({value}) for parameter. Reason: {reason}", parameter, *args
        )


class ParameterImmutableException(ParameterException):
    """A read-only parameter is to be changed."""

    def __init__(self, parameter: Any, *args: Any) -> None:
        super().__init__("Attempted to modify read-only parameter", parameter, *args)


class ParameterUninitializedException(ParameterException):
    """A parameter that has a type and no value yet is read."""

    def __init__(self, parameter_name: str, *args: Any) -> None:
        text = f"The parameter '{parameter_name}' is not initialized"
        super().__init__(text, parameter_name, *args)


class ROSInterruptException(Exception):
    """A wait is over since the context was shut down."""

    def __init__(self, *args: Any) -> None:
        super().__init__("rclpy.shutdown() has been called", *args)
