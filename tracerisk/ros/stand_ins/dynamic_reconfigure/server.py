"""Servers: a node's own parameters, changed by others."""

from __future__ import annotations

import copy
import threading
from collections.abc import Callable
from typing import Any

import rospy
from dynamic_reconfigure.msg import Config as ConfigMsg
from dynamic_reconfigure.msg import ConfigDescription as ConfigDescrMsg
from dynamic_reconfigure.srv import Reconfigure as ReconfigureSrv

from . import DynamicReconfigureCallbackException
from .encoding import (
    Config,
    decode_config,
    encode_config,
    encode_description,
    extract_params,
    get_tree,
    initial_config,
)


class Server:
    """Serves the parameters of the generated type `type` below a namespace, by default `~`.

    `callback` gets the configuration and which levels changed (at first all: -1), and returns
    the configuration that holds.

    Raises:
        DynamicReconfigureCallbackException: it returns none.
    """

    def __init__(self, type: Any, callback: Callable[[Any, int], Any], namespace: str = "") -> None:
        self.mutex = threading.Lock()
        if not namespace or namespace == "~":
            self.ns = "~"
        else:
            begin = "" if namespace[0] in "/~" else "~"
            self.ns = f"{begin}{namespace}/".replace("//", "/")
        self.type = type
        self.callback = callback
        self.config: Any = Config(type.defaults)
        self.description = encode_description(type)
        for param in self._params():
            self.config[param["name"]] = rospy.get_param(
                self.ns + param["name"], self.config[param["name"]]
            )
        self._clamp(self.config)
        self.config["groups"] = get_tree(self.description)
        self.config = initial_config(encode_config(self.config), type.config_description)
        self.descr_topic = rospy.Publisher(
            f"{self.ns}parameter_descriptions", ConfigDescrMsg, latch=True, queue_size=10
        )
        self.descr_topic.publish(self.description)
        self.update_topic = rospy.Publisher(
            f"{self.ns}parameter_updates", ConfigMsg, latch=True, queue_size=10
        )
        self._change_config(self.config, ~0)
        self.set_service = rospy.Service(
            f"{self.ns}set_parameters", ReconfigureSrv, self._set_callback
        )

    def update_configuration(self, changes: dict[str, Any]) -> Any:
        """Change parameters, within their limits, and return the configuration that holds."""
        with self.mutex:
            wanted = copy.deepcopy(self.config)
            wanted.update(changes)
            self._clamp(wanted)
            level = 0
            for param in self._params():
                if wanted[param["name"]] != self.config[param["name"]]:
                    level |= param["level"]
            return self._change_config(wanted, level)

    def _params(self) -> list[Any]:
        return extract_params(self.type.config_description)

    def _change_config(self, config: Any, level: int) -> Any:
        self.config = self.callback(config, level)
        if self.config is None:
            text = "Reconfigure callback should return a possibly updated configuration."
            rospy.logerr(text)
            raise DynamicReconfigureCallbackException(text)
        for param in self._params():
            rospy.set_param(self.ns + param["name"], self.config[param["name"]])
        self.update_topic.publish(encode_config(self.config))
        return self.config

    def _clamp(self, config: Any) -> None:
        for param in self._params():
            name = param["name"]
            least, most = self.type.min[name], self.type.max[name]
            if most != "" and config[name] > most:
                config[name] = most
            elif least != "" and config[name] < least:
                config[name] = least

    def _set_callback(self, request: Any) -> Any:
        asked = decode_config(request.config, self.type.config_description)
        return encode_config(self.update_configuration(asked))
