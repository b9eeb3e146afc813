"""Callbacks for events of an endpoint; in one process none of them happens."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class _EventCallbacks:
    def __init__(
        self,
        *,
        incompatible_qos: Callable[[Any], None] | None = None,
        liveliness: Callable[[Any], None] | None = None,
        deadline: Callable[[Any], None] | None = None,
        incompatible_type: Callable[[Any], None] | None = None,
        matched: Callable[[Any], None] | None = None,
        use_default_callbacks: bool = True,
        **others: Any,
    ) -> None:
        self.incompatible_qos = incompatible_qos
        self.liveliness = liveliness
        self.deadline = deadline
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks


class SubscriptionEventCallbacks(_EventCallbacks):
    """What is called on events of a subscription."""


class PublisherEventCallbacks(_EventCallbacks):
    """What is called on events of a publisher."""
