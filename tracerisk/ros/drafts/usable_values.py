"""Values with which a controller can go on: of the robot it drives, and as its code compares them.

They stand in for what only the author knows: the joints are the robot's own, a pose is one that
its tool reaches, and a text, a number or a truth value is one that the code asks for.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from tracerisk.instrument.source.literals.compared_values import Compared
from tracerisk.ros.drafts.named_numbers import (
    SI,
    Units,
    lasting_numbers,
    named_number,
    numbers_in_place,
    units_of,
    units_said,
)
from tracerisk.ros.drafts.pictures.drafted_pictures import (
    PICTURES,
    box_in_picture,
    cloud,
    picture,
)
from tracerisk.ros.drafts.posture_numbers import numbers_of, says_no_place
from tracerisk.ros.drafts.reached_poses import BOX, ReachedPoses
from tracerisk.ros.messages.fields import (
    DURATIONS,
    FLOATS,
    TIMES,
    MessageField,
    constants_of,
    fields_of,
    snake_case,
    type_of,
)
from tracerisk.twin.robots.assumed_names import HAND
from tracerisk.twin.robots.robot_parts import Joint
from tracerisk.twin.urdf.text import urdf_text

_CONVERTED = re.compile(r"(?<=\.)[xyz]\s*[*/]\s*[\w.+-]+")
_DEEPEST = 5  # of nested messages: what lies deeper, but for poses, is left at its defaults
_OFF = re.compile(
    r"(^|_)(e?stop|halt|abort|cancel|pause|emergency|error|fault|busy|shutdown|quit|exit|disable"
    r"|sim(_|ul|$)|dry|debug|fake|mock|preview|test|verbose|plan_?only)",
    re.IGNORECASE,
)
_FRAME = re.compile(r"(^|_)(frame|frame_id|link)$")
_JOINTS = re.compile(r"^(joint_?names?|joints|names?)$")
_DESCRIPTION = re.compile(r"(^|[/_])robot_description$|(^|[/_])urdf(_(xml|string|text))?$")
_NUMBERED = re.compile(r"^(?:j|joint|q|axis|theta|angle)_?(\d)$")
_GROUP = re.compile(r"(^|_)(planning_)?group(_name)?$")
_FAILED = re.compile(r"fail|err|abort|reject|refus|invalid|timeout|cancel")
_FAILS = re.compile(r"err|fault|fail|status|state|index|idx|(^|_)id$", re.IGNORECASE)
_NUMBERS = re.compile(r"(^|_)ids?$", re.IGNORECASE)
_SUCCESS = ("SUCCESS", "SUCCEEDED", "SUCCESSFUL", "OK", "STATUS_OK", "ADD")
_GOAL = re.compile(r"(^|[/_])(goals?|targets?|desired|cmd|ctrl|commands?)([/_]|$)")
_LIKELY = re.compile(r"(^|_)(score|conf(idence)?|prob(ability)?|likelihood)$", re.IGNORECASE)
_SURE = 0.9  # how likely what somebody has seen is what it is said to be
_NEAR = 0.01  # a joint is where it was [rad or m]
_SOME = 0.5  # what stands for a number of a list in which others are compared
_LONGEST = 64  # as long as a list is drafted
# Who sends a goal for the arm's joints leaves these out: the server's own count then.
_LEFT_EMPTY = frozenset(
    {
        "trajectory_msgs/MultiDOFJointTrajectory",
        "control_msgs/JointTolerance",
        "control_msgs/JointComponentTolerance",
    }
)


@dataclass(frozen=True, slots=True)
class _Place:
    """The place of a field within a topic, service or action."""

    compared: Compared
    """The literals with which the code compares the fields."""
    name: str
    """The name of the topic, service or action."""
    path: tuple[str, ...] = ()
    """The names of the fields from the top down to this one."""
    depth: int = 1
    """The number of nested messages down to the field, from 1."""
    said: str = ""
    """The texts of the code around the interface, which may name units."""
    comments: Mapping[str, str] = dataclasses.field(default_factory=dict)
    """The comment in the definition of the message, by field."""
    of_driver: Units = SI
    """The units of the driver whose message the field is in."""

    @property
    def units(self) -> Units:
        """The units that are said of the field, else those of the driver."""
        name = self.path[-1] if self.path else ""
        said = units_of(name, self.comments.get(name, ""), self.said)
        return self.of_driver if said == SI else said

    @property
    def called(self) -> str:
        """The name of the field; of plain data that of what it is in, a field or the topic."""
        *outer, name = self.path
        return name if name != "data" else snake_case([_last(self.name), *outer][-1])

    @property
    def point_units(self) -> Units:
        """The units of a whole point: those of ROS, unless the code converts its coordinates."""
        return units_said(" ".join(_CONVERTED.findall(self.said)))

    @property
    def numbers(self) -> Sequence[float]:
        """The numbers with which the code compares the field."""
        return self.compared.numbers(self.path)


class UsableValues(ReachedPoses):
    """The values for one robot."""

    doubted: Collection[str] = ()
    """Dimensions whose SI units a controller does not speak in: `angle`, `length`."""
    units_of_packages: Mapping[str, Units] = MappingProxyType({})
    """The units of the messages of drivers' packages, where they are not SI units."""
    served: Mapping[tuple[str, str], Collection[str]] = MappingProxyType({})
    """The names that drivers serve, by kind (`service`, `action`) and type, without namespace."""
    mount: Callable[[], float | None] = staticmethod(lambda: None)
    """Returns the height of the base from which the first goals are reached [m], if any."""
    shown_markers: Callable[[str], Sequence[Any]] = staticmethod(lambda _: ())
    """Returns the interactive markers for which feedback comes on a topic."""

    def fields(
        self,
        message_class: Any,
        compared: Compared | None = None,
        name: str = "",
        said: str = "",
        comments: Mapping[str, str] | None = None,
    ) -> dict[str, Any]:
        """Return the fields of a message as a scenario writes them.

        `compared` is what the code compares them with, `name` that of their topic or service.
        What the code has `said` of them, and the `comments` of the definition, name their units.
        """
        place = _Place(compared or Compared(), name, said=said, comments=comments or {})
        return self._fields(message_class, place)

    def with_pose(self, number: int) -> UsableValues:
        """Return the values with another of the `poses`, counted from 0."""
        other = copy(self)
        other._number = number
        return other

    def doubting(self, dimensions: Collection[str]) -> UsableValues:
        """Return the values where SI units of these dimensions are not meant."""
        other = copy(self)
        other.doubted = dimensions
        return other

    # Messages

    def _fields(self, message_class: Any, place: _Place) -> dict[str, Any]:
        whole = self._whole(message_class, place)
        if whole is not None:
            return whole
        fields: dict[str, Any] = {}
        package = type_of(message_class).partition("/")[0]
        place = replace(place, of_driver=self.units_of_packages.get(package, SI))
        for field in fields_of(message_class):
            is_deep = place.depth >= _DEEPEST and not field.is_array
            if is_deep and field.message is not None and not _is_geometry(field.message):
                continue
            if field.message is not None and type_of(field.message) in _LEFT_EMPTY:
                continue
            inner = replace(place, path=(*place.path, field.name))
            fields[field.name] = self._field(message_class, field, inner)
        return fields

    def _in_units(self, joint: Joint, units: Units) -> float:
        moved = self._moved(joint)
        return units.length(moved) if joint.type == "prismatic" else units.angle(moved)

    def _whole(self, message_class: Any, place: _Place) -> dict[str, Any] | None:
        """Return the message where its type alone says what is in it."""
        kind, name = type_of(message_class), place.name
        (x, y, z), (qx, qy, qz, qw) = self.pose.position, self.pose.orientation
        x, y, z = (place.point_units.length(value) for value in (x, y, z))
        position, turn = {"x": x, "y": y, "z": z}, {"x": qx, "y": qy, "z": qz, "w": qw}
        header = {"stamp": "now", "frame_id": self.robot.base_link}
        plain: dict[str, dict[str, Any]] = {
            "std_msgs/Header": header,
            "geometry_msgs/Point": position,
            "geometry_msgs/Point32": position,
            "geometry_msgs/Quaternion": turn,
            "geometry_msgs/Transform": {"translation": position, "rotation": turn},
            "geometry_msgs/Twist": {"linear": {"x": 0.05, "y": 0.0, "z": 0.0}},
            "lifecycle_msgs/State": {"id": 3, "label": "active"},
            # As many as a common game pad has, the first stick moved and nothing pressed.
            "sensor_msgs/Joy": {"axes": [0.5, 0.5, *[0.0] * 6], "buttons": [0] * 12},
        }
        if kind == "geometry_msgs/Vector3":
            return self._vector(place)
        if kind in PICTURES:
            parts = [field.name for field in fields_of(message_class)]
            return picture(kind, parts, self.robot.base_link, name)
        if kind == "sensor_msgs/PointCloud2":
            return {"header": header, **cloud(self.pose.position)}
        if kind == "vision_msgs/BoundingBox2D":
            center = next(field for field in fields_of(message_class) if field.name == "center")
            return box_in_picture([field.name for field in fields_of(center.message)])
        if kind == "shape_msgs/SolidPrimitive":
            return {"type": constants_of(message_class)["BOX"], "dimensions": list(BOX)}
        if kind == "sensor_msgs/JointState":
            # Those of the gripper too, as the robot itself reports them.
            joints: Sequence[Joint] = self.robot.joints
            least = place.compared.least((*place.path, "position"))
            if _GOAL.search(f"{place.name}/{'/'.join(place.path)}") and least <= len(self.joints):
                # Who moves the arm there has no other joints.
                joints = self.joints or joints
            names = [joint.name for joint in joints]
            posture = [self._in_units(joint, place.units) for joint in joints]
            zeros = [0.0 for _ in names]
            return {
                "header": {**header, "frame_id": ""},
                "name": names, "position": posture, "velocity": zeros, "effort": zeros,
            }  # fmt: skip
        if kind == "trajectory_msgs/JointTrajectory":
            positions = [self._in_units(joint, place.units) for joint in self.joints]
            point = {"positions": positions, "time_from_start": 2.0}
            return {"joint_names": [joint.name for joint in self.joints], "points": [point]}
        return plain.get(kind)

    def _vector(self, place: _Place) -> dict[str, float]:
        """Return a vector: a place or angles where its name says so, else of length 0."""
        named = [part for part in place.path if part != "vector"] or [_last(place.name)]
        numbers = numbers_of(snake_case(named[-1]), 3, self.posture, self.pose, place.units)
        return dict(zip("xyz", numbers or (0.0, 0.0, 0.0), strict=True))

    def _field(self, owner: Any, field: MessageField, place: _Place) -> Any:
        if not field.is_array:
            return self._scalar(owner, field, place)
        if field.message is not None or field.base in TIMES | DURATIONS:
            if place.depth >= _DEEPEST or field.longest == 0:
                return []
            if (
                type_of(owner).endswith("MultiArray")
                or type_of(owner) == "std_msgs/MultiArrayLayout"
            ):
                return []
            count = field.length
            if count is None:
                least = max(1, place.compared.least(place.path))
                count = min(place.compared.length(place.path) or least, field.longest or _LONGEST)
            return [self._scalar(owner, field, place) for _ in range(count)]
        return self._array(field, place)

    def _array(self, field: MessageField, place: _Place) -> list[Any]:
        length, most = place.compared.length(place.path), field.longest or _LONGEST
        if field.length is None and length is not None and length <= most:
            field = replace(field, length=length)
        least = min(place.compared.least(place.path), most)
        if field.base in FLOATS and (array := self._by_index(field, place, least)):
            return array
        numbers = self._numbers(field, place)
        if field.length is None and field.base not in ("string", "wstring"):
            zero = type(numbers[0])() if numbers else 0.0 if field.base in FLOATS else 0
            numbers += [zero] * (least - len(numbers))
        return numbers

    def _by_index(self, field: MessageField, place: _Place, least: int) -> list[float]:
        """Return numbers of which the code compares some, or whose name says nothing; [] else."""
        count = field.length or least
        known = place.compared.by_index(place.path)
        if count != len(self.posture) and known and max(known) < count:
            # Each has a meaning of its own: no list of joints.
            return [float(known.get(index, _SOME)) for index in range(count)]
        if numbers_of(place.called, field.length, self.posture, self.pose, place.units):
            return []
        numbers = (
            None if says_no_place(field.name) else numbers_in_place(count, place.units, self.reach)
        )
        return list(numbers or ())

    def _numbers(self, field: MessageField, place: _Place) -> list[Any]:
        if field.base in ("string", "wstring"):
            if _JOINTS.match(field.name):
                return [joint.name for joint in self.joints]
            return [str(text) for text in place.compared.texts(place.path)]
        if field.base in FLOATS:
            for called in (place.called, field.name):
                numbers = numbers_of(called, field.length, self.posture, self.pose, place.units)
                if numbers:
                    return numbers
        if field.base == "bool":
            return [True] * (field.length or 0)
        if field.base not in FLOATS and field.length is None:
            # A list that something is looked for in; what is detected has a number at least.
            known = _fitting(field, place.numbers)
            if known or _NUMBERS.search(field.name):
                return known or [0]
        zero: Any = 0.0 if field.base in FLOATS else 0
        return [zero] * (field.length or 0)

    def _scalar(self, owner: Any, field: MessageField, place: _Place) -> Any:
        name = place.name
        if field.base in TIMES:
            return "now"
        if field.base in DURATIONS:
            return 0.0
        if field.message is not None:
            return self._fields(field.message, replace(place, depth=place.depth + 1))
        if field.base == "bool":
            return is_on(field.name) and (field.name != "data" or is_on(_last(name)))
        if field.default is not None and not place.compared.is_known(place.path):
            return field.default
        if field.base in ("string", "wstring"):
            if (owner_of_state := place.compared.state_of(place.path)) is not None:
                return self._state(owner_of_state)
            # The text of a plain message is of what its topic is called.
            called = _last(name) if field.name == "data" and name else field.name
            return self.text(called, place.compared.texts(place.path))
        if field.base in FLOATS:
            return self._float(field, place, type_of(owner))
        return _integer(owner, field, place.numbers)

    def text(self, name: str, texts: Sequence[str]) -> str:
        """Return the text of a field or parameter called `name`: one of `texts`, if any."""
        if texts:
            # A word of failure is the branch beside the one that goes on.
            return min(texts, key=lambda text: _FAILED.search(text.lower()) is not None)
        if _DESCRIPTION.search(name):
            return urdf_text(self.robot)
        if _FRAME.search(name):
            return self.robot.base_link
        if _GROUP.search(name) and self.group is not None:
            return self.group[0]
        if re.search(r"(^|_)robot(_?(name|model|type))?$", name):
            return self.robot.name
        return ""

    def _state(self, owner: str) -> str:
        """Return a named state of the arm, or of the gripper where the `owner`'s name says so.

        It is one in which the robot does not begin, if there is one.
        """
        is_hand = bool(self.robot.grippers) and HAND.search(owner) is not None
        group = self.robot.grippers[0].group if is_hand else self.group[0] if self.group else ""
        states = dict(self.robot.named_states.get(group) or {})
        for name, positions in states.items():
            here = self.robot.initial_state
            if any(abs(value - here.get(joint, 0.0)) > _NEAR for joint, value in positions.items()):
                return name
        return next(iter(states), "open" if is_hand else "home")

    def _float(self, field: MessageField, place: _Place, owner: str) -> float:
        if numbers := lasting_numbers(field.name, place.numbers):
            return float(numbers[0])
        if owner.startswith("geometry_msgs/"):
            return 0.1
        if _LIKELY.search(field.name):
            return _SURE
        numbered = _NUMBERED.match(field.name)
        if numbered is not None and not 0 < int(numbered[1]) <= len(self.posture):
            return 0.0
        result = named_number(field.name, place.units, self.reach)
        return 0.1 if result is None else result


def _is_geometry(message_class: Any) -> bool:
    return type_of(message_class).startswith("geometry_msgs/")


def is_on(name: str) -> bool:
    """Return whether a switch of this name is on where the arm works: not one that stops it."""
    return not _OFF.search(name)


def _fitting(field: MessageField, numbers: Sequence[float]) -> list[int]:
    low, high = field.integer_limits or (0, 1)
    return [whole for number in numbers if low <= (whole := round(number)) <= high]


def _integer(owner: Any, field: MessageField, numbers: Sequence[float]) -> int:
    fitting = _fitting(field, lasting_numbers(field.name, numbers))
    if fitting:
        return fitting[0]
    constants = constants_of(owner)
    for name in _SUCCESS:
        if isinstance(constants.get(name), int):
            return int(constants[name])
    return 0 if _FAILS.search(field.name) else 1


def _last(name: str) -> str:
    return name.rstrip("/").rpartition("/")[2]
