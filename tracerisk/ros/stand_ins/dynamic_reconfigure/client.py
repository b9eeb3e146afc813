"""Clients of a server's parameters."""

from __future__ import annotations

import ast
from collections.abc import Callable
from operator import attrgetter
from typing import Any

import rospy
from dynamic_reconfigure.msg import Config as ConfigMsg
from dynamic_reconfigure.msg import ConfigDescription as ConfigDescrMsg
from dynamic_reconfigure.srv import Reconfigure as ReconfigureSrv

from tracerisk.ros.controller.needs import Need
from tracerisk.ros.graph.runtime import current

from . import DynamicReconfigureCallbackException, DynamicReconfigureParameterException
from .encoding import decode_config, decode_description, encode_config, extract_params

_TYPES: dict[str, Callable[[Any], Any]] = {"int": int, "double": float, "str": str, "bool": bool}
Callback = Callable[[Any], object] | None


def _callback(name: str, present: str, doc: str) -> Any:
    """Return the property of a callback, which is called with what is present when it is set."""

    def write(client: Client, value: Callback) -> None:
        setattr(client, name, value)
        if value is not None:
            value(getattr(client, present))

    return property(attrgetter(name), write, doc=doc)


class Client:
    """Reads and changes the configuration of the server `name`, usually the name of a node.

    Raises:
        ROSException: the server is not there after `timeout` seconds; without one, it is waited
            for.
    """

    def __init__(
        self,
        name: str,
        timeout: float | None = None,
        config_callback: Callback = None,
        description_callback: Callback = None,
    ) -> None:
        self.name = name
        self.config: Any = None
        self.param_description: Any = None
        self.group_description: Any = None
        self._param_types: dict[str, Callable[[Any], Any]] = {}
        self._config_callback = config_callback
        self._description_callback = description_callback
        service = rospy.resolve_name(f"{name}/set_parameters")
        rospy.wait_for_service(service, timeout or None)
        self._set_service = rospy.ServiceProxy(service, ReconfigureSrv)
        self._descriptions_sub = rospy.Subscriber(
            rospy.resolve_name(f"{name}/parameter_descriptions"),
            ConfigDescrMsg,
            self._descriptions_msg,
        )
        self._updates_sub = rospy.Subscriber(
            rospy.resolve_name(f"{name}/parameter_updates"), ConfigMsg, self._updates_msg
        )

    def get_configuration(self, timeout: float | None = None) -> Any:
        """Return the latest configuration, waiting for one; None after `timeout` seconds."""
        return self._wait_for("config", "parameter_updates", ConfigMsg, timeout)

    def get_parameter_descriptions(self, timeout: float | None = None) -> Any:
        """Return what the server says of its parameters; see `get_configuration`."""
        return self._wait_for(
            "param_description", "parameter_descriptions", ConfigDescrMsg, timeout
        )

    def get_group_descriptions(self, timeout: float | None = None) -> Any:
        """Return what the server says of its groups; see `get_configuration`."""
        return self._wait_for(
            "group_description", "parameter_descriptions", ConfigDescrMsg, timeout
        )

    def update_configuration(self, changes: dict[str, Any]) -> Any:
        """Change parameters, and return the configuration that the server has then.

        Raises:
            DynamicReconfigureParameterException: one is not known, or cannot have the value.
            DynamicReconfigureCallbackException: the call fails.
        """
        if self.param_description is None:
            self.get_parameter_descriptions()
        if self.param_description is not None:
            for name, value in list(changes.items()):
                if name != "groups":
                    changes[name] = self._cast(name, value)
        if "groups" in changes:
            changes["groups"] = self.update_groups(changes["groups"])
        try:
            msg = self._set_service(encode_config(changes)).config
        except rospy.ServiceException as error:
            raise DynamicReconfigureCallbackException("service call failed") from error
        if self.group_description is None:
            self.get_group_descriptions()
        return decode_config(msg, self.group_description)

    def update_groups(self, changes: dict[str, Any]) -> Any:
        """Change the states of groups by their names, and return the tree of groups."""

        def update(group: Any, name: str) -> None:
            for inner in group["groups"].values():
                if inner["name"] == name:
                    inner["state"] = changes[name]
                else:
                    update(inner, name)

        tree = self.get_group_descriptions()
        for name in changes:
            update(tree, name)
        return tree

    def close(self) -> None:
        """Listen no longer."""
        self._descriptions_sub.unregister()
        self._updates_sub.unregister()

    config_callback = _callback(
        "_config_callback",
        "config",
        "What is called with each configuration; at once with the present one.",
    )
    description_callback = _callback(
        "_description_callback",
        "param_description",
        "What is called with each description; at once with the present one.",
    )

    def _wait_for(self, what: str, suffix: str, kind: Any, timeout: float | None) -> Any:
        topic = rospy.resolve_name(f"{self.name}/{suffix}")
        current().scheduler.wait_until(
            lambda: getattr(self, what) is not None or rospy.core.is_shutdown(),
            timeout_ns=round(timeout * 1e9) if timeout else None,
            reason=f"a message on {topic} ({kind._type})",
            kind="unmet",
            need=Need("topic", topic, kind._type),
        )
        return getattr(self, what)

    def _cast(self, name: str, value: Any) -> Any:
        kind = self._param_types.get(name)
        if kind is None:
            raise DynamicReconfigureParameterException(f"don't know parameter: {name}")
        if kind is bool and isinstance(value, str):
            return value.lower() in ("yes", "true", "t", "1")
        if isinstance(value, str):
            for constant in self._constants(name):
                if value.lower() == constant["name"].lower():
                    return _TYPES[constant["type"]](constant["value"])
        try:
            return kind(value)
        except ValueError as error:
            raise DynamicReconfigureParameterException(
                f"can't set parameter '{name}' of {kind}: {error}"
            ) from error

    def _constants(self, name: str) -> list[Any]:
        method = next(p["edit_method"] for p in self.param_description if p["name"] == name)
        return list(ast.literal_eval(method)["enum"]) if method else []

    def _updates_msg(self, msg: Any) -> None:
        if self.group_description is None:
            self.get_group_descriptions()
        self.config = decode_config(msg, self.group_description)
        if self._config_callback is not None:
            self._config_callback(self.config)

    def _descriptions_msg(self, msg: Any) -> None:
        self.group_description = decode_description(msg)
        self.param_description = extract_params(self.group_description)
        self._param_types = {p["name"]: _TYPES[p["type"]] for p in self.param_description}
        if self._description_callback is not None:
            self._description_callback(self.param_description)
