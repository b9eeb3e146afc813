"""Quality of service: how many messages are kept, and who gets those sent before it came."""

from __future__ import annotations

import warnings
from enum import Enum, IntEnum
from typing import Any

from .duration import Duration, Infinite

__all__ = [
    "DurabilityPolicy",
    "HistoryPolicy",
    "InvalidQoSProfileException",
    "LivelinessPolicy",
    "QoSCompatibility",
    "QoSDurabilityPolicy",
    "QoSHistoryPolicy",
    "QoSLivelinessPolicy",
    "QoSPolicyEnum",
    "QoSPolicyKind",
    "QoSPresetProfiles",
    "QoSProfile",
    "QoSReliabilityPolicy",
    "ReliabilityPolicy",
    "qos_check_compatible",
    "qos_policy_name_from_kind",
    "qos_profile_action_status_default",
    "qos_profile_best_available",
    "qos_profile_parameter_events",
    "qos_profile_parameters",
    "qos_profile_sensor_data",
    "qos_profile_services_default",
    "qos_profile_system_default",
    "qos_profile_unknown",
]


class InvalidQoSProfileException(Exception):
    """A profile says too little: it has neither a history nor a depth."""

    def __init__(self, *args: Any) -> None:
        super().__init__("Invalid QoSProfile", *args)


class QoSPolicyEnum(IntEnum):
    """Base of the policies; their short names are `system_default` and the like."""

    @classmethod
    def short_keys(cls) -> list[str]:
        """Return the names of the policies, in lower case."""
        return [qo_s_policy_enum.name.lower() for qo_s_policy_enum in cls]

    @classmethod
    def get_from_short_key(cls, name: str) -> Any:
        """Return the policy of a short name."""
        return cls[name.upper()]

    @property
    def short_key(self) -> str:
        """The name of the policy in lower case."""
        return self.name.lower()


class HistoryPolicy(QoSPolicyEnum):
    """Which messages are kept."""

    SYSTEM_DEFAULT = 0
    KEEP_LAST = 1
    KEEP_ALL = 2
    UNKNOWN = 3


class ReliabilityPolicy(QoSPolicyEnum):
    """Whether each message must arrive."""

    SYSTEM_DEFAULT = 0
    RELIABLE = 1
    BEST_EFFORT = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class DurabilityPolicy(QoSPolicyEnum):
    """Whether those who come late get what was sent before."""

    SYSTEM_DEFAULT = 0
    TRANSIENT_LOCAL = 1
    VOLATILE = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class LivelinessPolicy(QoSPolicyEnum):
    """Who says that a publisher lives."""

    SYSTEM_DEFAULT = 0
    AUTOMATIC = 1
    MANUAL_BY_TOPIC = 3
    UNKNOWN = 4
    BEST_AVAILABLE = 5


# The names before ROS 2 Galactic, and their values with the policy's name in front.
QoSHistoryPolicy = HistoryPolicy
QoSReliabilityPolicy = ReliabilityPolicy
QoSDurabilityPolicy = DurabilityPolicy
QoSLivelinessPolicy = LivelinessPolicy
_POLICIES: tuple[type[QoSPolicyEnum], ...] = (
    HistoryPolicy,
    ReliabilityPolicy,
    DurabilityPolicy,
    LivelinessPolicy,
)
for _policy in _POLICIES:
    _prefix = f"RMW_QOS_POLICY_{_policy.__name__.removesuffix('Policy').upper()}_"
    for _each in _policy:
        setattr(_policy, _prefix + _each.name, _each)


class QoSPolicyKind(IntEnum):
    """The policies, as events of incompatible profiles name them."""

    INVALID = 1
    DURABILITY = 2
    DEADLINE = 4
    LIVELINESS = 8
    RELIABILITY = 16
    HISTORY = 32
    LIFESPAN = 64
    DEPTH = 128
    LIVELINESS_LEASE_DURATION = 256
    AVOID_ROS_NAMESPACE_CONVENTIONS = 512


def qos_policy_name_from_kind(policy_kind: QoSPolicyKind | int) -> str:
    """Return the name of a policy."""
    return QoSPolicyKind(policy_kind).name


_DEFAULTS: dict[str, Any] = {
    "history": HistoryPolicy.SYSTEM_DEFAULT,
    "depth": 10,
    "reliability": ReliabilityPolicy.RELIABLE,
    "durability": DurabilityPolicy.VOLATILE,
    "lifespan": Duration(),
    "deadline": Duration(),
    "liveliness": LivelinessPolicy.SYSTEM_DEFAULT,
    "liveliness_lease_duration": Duration(),
    "avoid_ros_namespace_conventions": False,
}
_KINDS: dict[str, Any] = {
    "history": HistoryPolicy,
    "reliability": ReliabilityPolicy,
    "durability": DurabilityPolicy,
    "liveliness": LivelinessPolicy,
}


class QoSProfile:
    """The policies of an endpoint, by keyword; a `depth` alone means KEEP_LAST.

    Raises:
        InvalidQoSProfileException: neither history nor depth is given.
        AssertionError: a keyword is not a policy, or a value of the wrong type.
    """

    __slots__ = tuple(f"_{name}" for name in _DEFAULTS)

    history: HistoryPolicy
    depth: int
    reliability: ReliabilityPolicy
    durability: DurabilityPolicy
    lifespan: Duration
    deadline: Duration
    liveliness: LivelinessPolicy
    liveliness_lease_duration: Duration

    def __init__(self, **kwargs: Any) -> None:
        unknown = sorted(set(kwargs) - set(_DEFAULTS))
        if unknown:
            raise AssertionError(f"Invalid arguments passed to constructor: {', '.join(unknown)}")
        if "history" not in kwargs:
            if "depth" not in kwargs:
                raise InvalidQoSProfileException("History and/or depth settings are required.")
            kwargs["history"] = HistoryPolicy.KEEP_LAST
        if kwargs["history"] == HistoryPolicy.KEEP_LAST and "depth" not in kwargs:
            raise InvalidQoSProfileException("History set to KEEP_LAST without a depth setting.")
        for name, default in _DEFAULTS.items():
            setattr(self, f"_{name}", default)
        for name in _DEFAULTS:
            if name in kwargs:
                setattr(self, name, kwargs[name])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, QoSProfile):
            return False
        return all(getattr(self, name) == getattr(other, name) for name in _DEFAULTS)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        text = ", ".join(f"{name}={getattr(self, name)}" for name in _DEFAULTS)
        return f"{type(self).__name__}({text})"

    @property
    def is_latching(self) -> bool:
        """Whether late comers get what was sent before."""
        return self.durability == DurabilityPolicy.TRANSIENT_LOCAL

    @property
    def kept(self) -> int | None:
        """How many messages are kept; None means all of them."""
        if self.history == HistoryPolicy.KEEP_ALL:
            return None
        return max(1, self.depth) if self.history == HistoryPolicy.KEEP_LAST else 10


def _accessor(name: str) -> property:
    slot = f"_{name}"

    def read(profile: Any) -> Any:
        return getattr(profile, slot)

    def write(profile: Any, value: Any) -> None:
        kind = _KINDS.get(name)
        if kind is not None:
            _assert(isinstance(value, int), name)
            value = kind(value)
        elif isinstance(_DEFAULTS[name], Duration):
            _assert(isinstance(value, Duration), name)
        elif name == "depth":
            _assert(isinstance(value, int) and not isinstance(value, bool) and value >= 0, name)
            if value == 0 and profile.history == HistoryPolicy.KEEP_LAST:
                warnings.warn(
                    "A zero depth with KEEP_LAST doesn't make sense; no data could be stored. "
                    "This will be interpreted as SYSTEM_DEFAULT",
                    stacklevel=2,
                )
        else:
            _assert(isinstance(value, bool), name)
        setattr(profile, slot, value)

    return property(read, write, doc=f"The policy '{name}'.")


def _assert(holds: bool, name: str) -> None:
    if not holds:
        raise AssertionError(f"the value of '{name}' is of the wrong type or out of range")


for _name in _DEFAULTS:
    setattr(QoSProfile, _name, _accessor(_name))


class QoSCompatibility(IntEnum):
    """Whether two profiles fit."""

    OK = 0
    WARNING = 1
    ERROR = 2


def _promises(offered: Duration, asked: Duration) -> bool:
    """Return whether a publisher's span is as short as a subscription wants it; 0 is no span."""
    return not asked.nanoseconds or 0 < offered.nanoseconds <= asked.nanoseconds


def misfit_of(offered: QoSProfile, asked: QoSProfile) -> QoSPolicyKind | None:
    """Return the last policy in which a subscription asks for more than a publisher offers."""
    misfit = None
    if (
        offered.durability == DurabilityPolicy.VOLATILE
        and asked.durability == DurabilityPolicy.TRANSIENT_LOCAL
    ):
        misfit = QoSPolicyKind.DURABILITY
    if not _promises(offered.deadline, asked.deadline):
        misfit = QoSPolicyKind.DEADLINE
    if not _promises(offered.liveliness_lease_duration, asked.liveliness_lease_duration) or (
        offered.liveliness != LivelinessPolicy.MANUAL_BY_TOPIC
        and asked.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC
    ):
        misfit = QoSPolicyKind.LIVELINESS
    if (
        offered.reliability == ReliabilityPolicy.BEST_EFFORT
        and asked.reliability == ReliabilityPolicy.RELIABLE
    ):
        misfit = QoSPolicyKind.RELIABILITY
    return misfit


_UNDECIDED = frozenset({"SYSTEM_DEFAULT", "UNKNOWN"})
# Of each policy: what a publisher has that promises least, and what a subscription asks at most,
# with the words that the real library has for both and for two that are left to the system.
_WEAK_AND_STRICT: tuple[tuple[str, Any, Any, str, str, str], ...] = (
    (
        "reliability",
        ReliabilityPolicy.BEST_EFFORT,
        ReliabilityPolicy.RELIABLE,
        "Reliable subscription, but publisher",
        "Best effort publisher, but subscription",
        "reliability",
    ),
    (
        "durability",
        DurabilityPolicy.VOLATILE,
        DurabilityPolicy.TRANSIENT_LOCAL,
        "Transient local subscription, but publisher",
        "Volatile publisher, but subscription",
        "durabilty",
    ),
    (
        "liveliness",
        LivelinessPolicy.AUTOMATIC,
        LivelinessPolicy.MANUAL_BY_TOPIC,
        "Subscription's liveliness is manual by topic, but publisher's",
        "Publisher's liveliness is automatic, but subscription's",
        "liveliness",
    ),
)


def qos_check_compatible(
    publisher_qos: QoSProfile, subscription_qos: QoSProfile
) -> tuple[QoSCompatibility, str]:
    """Return whether a subscription gets what a publisher sends, and why it does not."""
    errors = _errors(publisher_qos, subscription_qos)
    if errors:
        return QoSCompatibility.ERROR, "".join(f"ERROR: {error};" for error in errors)
    doubts = []
    for name, weak, strict, of_publisher, of_subscription, first_name in _WEAK_AND_STRICT:
        offered, asked = getattr(publisher_qos, name), getattr(subscription_qos, name)
        has, wants = offered.name.lower(), asked.name.lower()
        if offered.name in _UNDECIDED and asked.name in _UNDECIDED:
            doubts.append(f"Publisher {first_name} is {has} and subscription {name} is {wants}")
        elif offered.name in _UNDECIDED and asked is strict:
            doubts.append(f"{of_publisher} is {has}")
        elif offered is weak and asked.name in _UNDECIDED:
            doubts.append(f"{of_subscription} is {wants}")
    words = "".join(f"WARNING: {doubt};" for doubt in doubts)
    return (QoSCompatibility.WARNING if doubts else QoSCompatibility.OK), words


def _errors(offered: QoSProfile, asked: QoSProfile) -> list[str]:
    """Return where a subscription surely asks for more than it gets, in the library's words."""
    errors = []
    if (
        offered.reliability == ReliabilityPolicy.BEST_EFFORT
        and asked.reliability == ReliabilityPolicy.RELIABLE
    ):
        errors.append("Best effort publisher and reliable subscription")
    if (
        offered.durability == DurabilityPolicy.VOLATILE
        and asked.durability == DurabilityPolicy.TRANSIENT_LOCAL
    ):
        errors.append("Volatile publisher and transient local subscription")
    if not _promises(offered.deadline, asked.deadline):
        errors.append(
            "Subscription deadline is less than publisher deadline"
            if offered.deadline.nanoseconds
            else "Subscription has a deadline, but publisher does not"
        )
    if (
        offered.liveliness == LivelinessPolicy.AUTOMATIC
        and asked.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC
    ):
        errors.append("Publisher's liveliness is automatic and subscription's is manual by topic")
    if not _promises(offered.liveliness_lease_duration, asked.liveliness_lease_duration):
        errors.append(
            "Subscription liveliness lease duration is less than publisher"
            if offered.liveliness_lease_duration.nanoseconds
            else "Subscription has a liveliness lease duration, but publisher does not"
        )
    return errors


def reaches(publication: Any, subscription: Any) -> bool:
    """Return whether messages of a publication come to a subscription; the twin's always fit."""
    sender = getattr(publication.on_connect, "__self__", None)
    receiver = getattr(subscription.deliver, "__self__", None)
    offered, asked = getattr(sender, "qos_profile", None), getattr(receiver, "qos_profile", None)
    return offered is None or asked is None or misfit_of(offered, asked) is None


qos_profile_unknown = QoSProfile(
    history=HistoryPolicy.UNKNOWN,
    depth=0,
    reliability=ReliabilityPolicy.UNKNOWN,
    durability=DurabilityPolicy.UNKNOWN,
    liveliness=LivelinessPolicy.UNKNOWN,
)
qos_profile_default = QoSProfile(depth=10)
qos_profile_system_default = QoSProfile(
    history=HistoryPolicy.SYSTEM_DEFAULT,
    depth=0,
    reliability=ReliabilityPolicy.SYSTEM_DEFAULT,
    durability=DurabilityPolicy.SYSTEM_DEFAULT,
)
qos_profile_sensor_data = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
qos_profile_services_default = QoSProfile(depth=10)
qos_profile_parameters = QoSProfile(depth=1000)
qos_profile_parameter_events = QoSProfile(depth=1000)
qos_profile_action_status_default = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
qos_profile_rosout_default = QoSProfile(
    depth=1000,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    lifespan=Duration(seconds=10),
)
qos_profile_best_available = QoSProfile(
    depth=10,
    reliability=ReliabilityPolicy.BEST_AVAILABLE,
    durability=DurabilityPolicy.BEST_AVAILABLE,
    liveliness=LivelinessPolicy.BEST_AVAILABLE,
)
DURATION_INFINITE = Infinite


class QoSPresetProfiles(Enum):
    """The profiles with names."""

    UNKNOWN = qos_profile_unknown
    DEFAULT = qos_profile_default
    SYSTEM_DEFAULT = qos_profile_system_default
    SENSOR_DATA = qos_profile_sensor_data
    SERVICES_DEFAULT = qos_profile_services_default
    PARAMETERS = qos_profile_parameters
    PARAMETER_EVENTS = qos_profile_parameter_events
    ACTION_STATUS_DEFAULT = qos_profile_action_status_default
    ROSOUT_DEFAULT = qos_profile_rosout_default
    BEST_AVAILABLE = qos_profile_best_available

    @classmethod
    def short_keys(cls) -> list[str]:
        """Return the names of the profiles, in lower case."""
        return [profiles.name.lower() for profiles in cls]

    @classmethod
    def get_from_short_key(cls, name: str) -> QoSProfile:
        """Return the profile of a short name."""
        return cls[name.upper()].value
