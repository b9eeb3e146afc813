"""Listeners that a controller waits for, and of which nobody knows: the node of a tool, say.

A program that asks in a loop whether anybody listens to a topic goes on once somebody does. On its
robot some other node would; here one is assumed, and the run says so.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.graph.topic_ends import Publication

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_ASKED_IN_VAIN = 10
_NODE = "/assumed_listener"
# A program that asks whether anybody wants a picture goes on without.
_ON_DEMAND = re.compile(r"(sensor_msgs|nav_msgs|visualization_msgs|stereo_msgs)/")


class AssumedListeners:
    """Counts who listens to what the controller publishes: `runtime.client(AssumedListeners)`."""

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._graph = runtime.graph
        self._asked: dict[str, tuple[int, int]] = {}

    def count(self, publication: Publication) -> int:
        """Return how many subscriptions a publication reaches, as the controller asks it.

        Who asks again and again, and sends nothing meanwhile, waits for the first.
        """
        number = len(publication.subscriptions)
        if number or publication.is_wanted or self._runtime.recorder is None:
            return number
        topic, sent = publication.topic, self._graph.counts.total()
        times, sent_before = self._asked.get(topic, (0, sent))
        times = times + 1 if sent == sent_before else 1
        self._asked[topic] = times, sent
        if times < _ASKED_IN_VAIN or _ON_DEMAND.match(publication.type_name):
            return 0
        listener = self._graph.subscribe(
            topic, publication.type_name, lambda *_: None, node=_NODE, by_controller=False
        )
        listener.is_assumed = True
        self._runtime.recorder.finding(
            "unprovided",
            f"nobody receives what it publishes on {topic} ({publication.type_name}), and it waits "
            "until somebody does: a listener is assumed, and if that moves anything, no figure has "
            "it",
            asking_place(),
            object_name=topic,
        )
        return len(publication.subscriptions)
