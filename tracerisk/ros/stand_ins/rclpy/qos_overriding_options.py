"""Policies of an endpoint that parameters of its node may change: `qos_overrides./topic...`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from operator import attrgetter
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult

from .duration import Duration
from .exceptions import ParameterAlreadyDeclaredException
from .publisher import Publisher
from .qos import QoSPolicyEnum, QoSPolicyKind, QoSProfile
from .subscription import Subscription

QosCallbackResult = SetParametersResult
QosCallbackType = Callable[[QoSProfile], Any]


class InvalidQosOverridesError(Exception):
    """The callback of the options refuses the profile that parameters have made."""


class QoSOverridingOptions:
    """Which policies parameters may change; `callback` judges the profile that comes of it.

    `entity_id` distinguishes endpoints of one topic.
    """

    def __init__(
        self,
        policy_kinds: Iterable[QoSPolicyKind],
        *,
        callback: QosCallbackType | None = None,
        entity_id: str | None = None,
    ) -> None:
        self._policy_kinds = policy_kinds
        self._callback = callback
        self._entity_id = entity_id

    policy_kinds = property(attrgetter("_policy_kinds"), doc="The policies that have a parameter.")

    callback = property(attrgetter("_callback"), doc="What judges the profile.")

    @property
    def entity_id(self) -> str | None:
        """What distinguishes the endpoint from others of the topic."""
        return self._entity_id

    @classmethod
    def with_default_policies(
        cls, *, callback: QosCallbackType | None = None, entity_id: str | None = None
    ) -> QoSOverridingOptions:
        """Return options for history, depth and reliability."""
        kinds = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY)
        return cls(kinds, callback=callback, entity_id=entity_id)


def _declare_qos_parameters(
    entity_type: type, node: Any, topic_name: str, qos: QoSProfile, options: QoSOverridingOptions
) -> None:
    """Declare the parameters of an endpoint, and put what they say into its profile."""
    if not issubclass(entity_type, Publisher | Subscription):
        raise TypeError("Argument `entity_type` should be a subclass of Publisher or Subscription")
    kind = "publisher" if issubclass(entity_type, Publisher) else "subscription"
    suffix = "" if options.entity_id is None else f"_{options.entity_id}"
    text = f"for {kind} `{topic_name}` with id `{options.entity_id}`"
    for policy in options.policy_kinds:
        if kind == "subscription" and policy is QoSPolicyKind.LIFESPAN:
            continue
        name = f"qos_overrides.{topic_name}.{kind}{suffix}.{policy.name.lower()}"
        descriptor = ParameterDescriptor(
            description=f"{policy.name.lower()} {text}", read_only=True
        )
        try:
            given = node.declare_parameter(name, _get_qos_policy_parameter(qos, policy), descriptor)
        except ParameterAlreadyDeclaredException:
            given = node.get_parameter(name)
        _override_qos_policy_with_param(qos, policy, given)
    if options.callback is not None:
        result = options.callback(qos)
        if not result.successful:
            raise InvalidQosOverridesError(
                f"Provided QoS overrides {text}, are not valid: {result.reason}"
            )


def _get_qos_policy_parameter(qos: QoSProfile, policy: QoSPolicyKind) -> str | int | bool:
    """Return a policy of a profile as the value of a parameter."""
    value: Any = getattr(qos, policy.name.lower())
    if isinstance(value, QoSPolicyEnum):
        if value.short_key == "unknown":
            raise ValueError("User provided QoS profile is invalid")
        return value.short_key
    if isinstance(value, Duration):
        return value.nanoseconds
    plain: int | bool = value
    return plain


def _override_qos_policy_with_param(qos: QoSProfile, policy: QoSPolicyKind, param: Any) -> None:
    """Put the value of a parameter into a profile."""
    name = policy.name.lower()
    value, known = param.value, getattr(qos, name)
    if isinstance(known, QoSPolicyEnum):
        try:
            value = type(known).get_from_short_key(value)
        except KeyError:
            raise RuntimeError(f"Unexpected QoS override for policy `{name}`: `{value}`") from None
    elif isinstance(known, Duration):
        value = Duration(nanoseconds=value)
    setattr(qos, name, value)
