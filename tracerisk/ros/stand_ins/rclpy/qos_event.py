# ruff: noqa: F401 - what is imported here is what the module gives
"""The older name of `rclpy.event_handler`."""

from tracerisk.ros.imports.exported import exported as _exported

from .event_handler import (
    PublisherEventCallbacks,
    QoSEventHandler,
    QoSLivelinessChangedInfo,
    QoSLivelinessLostInfo,
    QoSMessageLostInfo,
    QoSOfferedDeadlineMissedInfo,
    QoSOfferedIncompatibleQoSInfo,
    QoSPublisherEventType,
    QoSPublisherMatchedInfo,
    QoSRequestedDeadlineMissedInfo,
    QoSRequestedIncompatibleQoSInfo,
    QoSSubscriptionEventType,
    QoSSubscriptionMatchedInfo,
    SubscriptionEventCallbacks,
)

__all__ = _exported(globals())
