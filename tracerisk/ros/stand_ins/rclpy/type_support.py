"""Whether a class is an interface of ROS 2."""

from __future__ import annotations

from typing import Any

from .exceptions import NoTypeSupportImportedException


def check_for_type_support(msg_or_srv_type: Any) -> None:
    """Accept an interface class of ROS 2.

    Raises:
        AttributeError: it is none.
        NoTypeSupportImportedException: it is one that was not built.
    """
    if not hasattr(type(msg_or_srv_type), "__import_type_support__") and not getattr(
        msg_or_srv_type, "_ros_type", ""
    ):
        raise AttributeError(
            f"{msg_or_srv_type!r} has no '_TYPE_SUPPORT'. This might be a ROS 1 message type but "
            "it should be a ROS 2 message type."
        )
    if not isinstance(msg_or_srv_type, type) or not getattr(msg_or_srv_type, "_ros_type", ""):
        raise NoTypeSupportImportedException(
            f"{msg_or_srv_type!r} is not an interface class of ROS 2"
        )


def check_is_valid_msg_type(msg_type: Any) -> None:
    """Accept a message class.

    Raises:
        AttributeError: it is not an interface class.
        RuntimeError: it is one of a service or an action.
    """
    check_for_type_support(msg_type)
    if not hasattr(msg_type, "get_fields_and_field_types"):
        raise RuntimeError(f"The message type provided is not valid ({msg_type!r}).")


def check_is_valid_srv_type(srv_type: Any) -> None:
    """Accept a service class.

    Raises:
        AttributeError: it is not an interface class.
        RuntimeError: it is one of a message or an action.
    """
    check_for_type_support(srv_type)
    if not hasattr(srv_type, "Request") or not hasattr(srv_type, "Response"):
        raise RuntimeError(f"The service type provided is not valid ({srv_type!r}).")
