# ruff: noqa: F401 - what is imported here is what the module gives
"""Lifecycle nodes: configured, activated, deactivated, cleaned up and shut down from outside."""

from tracerisk.ros.imports.exported import exported as _exported

from .managed_entity import ManagedEntity, SimpleManagedEntity, TransitionCallbackReturn
from .node import LifecycleNode, LifecycleNodeMixin, LifecycleState
from .publisher import LifecyclePublisher

Node = LifecycleNode
NodeMixin = LifecycleNodeMixin
State = LifecycleState
Publisher = LifecyclePublisher

__all__ = _exported(globals())
