"""What every buffer offers, and the registry of types that it can transform."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

from std_msgs.msg import Header

from tracerisk.ros.graph.runtime import Runtime, current
from tracerisk.ros.imports.exported import defined as _defined


class TypeException(Exception):
    """A type is not registered."""

    def __init__(self, errstr: str) -> None:
        super().__init__(errstr)
        self.errstr = errstr


class NotImplementedException(Exception):
    """A buffer lacks one of the calls."""

    def __init__(self) -> None:
        self.errstr = "CanTransform or LookupTransform not implemented"
        super().__init__(self.errstr)


class _Registered:
    """The functions that were registered in this run."""

    is_of_world = True  # filled by modules, which are imported once for all programs of a run

    def __init__(self, runtime: Runtime) -> None:
        self.transform: dict[Any, Callable[..., Any]] = {}
        self.to_msg: dict[Any, Callable[..., Any]] = {}
        self.from_msg: dict[Any, Callable[..., Any]] = {}
        self.convert: dict[Any, Callable[..., Any]] = {}


def _registered() -> _Registered:
    return current().client(_Registered)


def _found(table: dict[Any, Callable[..., Any]], key: Any) -> Callable[..., Any]:
    if key not in table:
        raise TypeException(f"Type {key} is not loaded or supported")
    return table[key]


class TransformRegistration:
    """How each type is transformed: functions of an object and a TransformStamped."""

    def print_me(self) -> None:
        """Print what is registered."""
        print(_registered().transform)  # noqa: T201 - this is its purpose

    def add(self, key: Any, callback: Callable[[Any, Any], Any]) -> None:
        """Register a type."""
        _registered().transform[key] = callback

    def get(self, key: Any) -> Callable[[Any, Any], Any]:
        """Return the function of a type.

        Raises:
            TypeException: there is none; the package that has it must be imported.
        """
        return _found(_registered().transform, key)


class ConvertRegistration:
    """How types are converted, directly or by way of a message."""

    def add_from_msg(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register how a type is made from a message."""
        _registered().from_msg[key] = callback

    def add_to_msg(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register how a type is made into a message."""
        _registered().to_msg[key] = callback

    def add_convert(self, key: tuple[Any, Any], callback: Callable[[Any], Any]) -> None:
        """Register how a pair of types is converted."""
        _registered().convert[key] = callback

    def get_from_msg(self, key: Any) -> Callable[[Any], Any]:
        """Return what makes a type from a message; raise TypeException if there is nothing."""
        return _found(_registered().from_msg, key)

    def get_to_msg(self, key: Any) -> Callable[[Any], Any]:
        """Return what makes a message from a type; raise TypeException if there is nothing."""
        return _found(_registered().to_msg, key)

    def get_convert(self, key: tuple[Any, Any]) -> Callable[[Any], Any]:
        """Return what converts a pair of types; raise TypeException if there is nothing."""
        return _found(_registered().convert, key)


def convert(a: Any, b_type: Any) -> Any:
    """Return an object as another type.

    Raises:
        TypeException: nothing converts it.
    """
    registration = ConvertRegistration()
    try:
        direct = registration.get_convert((type(a), b_type))
    except TypeException:
        if type(a) is b_type:
            return deepcopy(a)
        to_msg, from_msg = registration.get_to_msg(type(a)), registration.get_from_msg(b_type)
        return from_msg(to_msg(a))
    return direct(a)


def Stamped(obj: Any, stamp: Any, frame_id: str) -> Any:
    """Give an object a header."""
    obj.header = Header(frame_id=frame_id, stamp=stamp)
    return obj


class BufferInterface:
    """Transforms stamped objects; lookups are the subclass's."""

    def __init__(self) -> None:
        self.registration = TransformRegistration()

    def transform(
        self, object_stamped: Any, target_frame: str, timeout: Any = None, new_type: Any = None
    ) -> Any:
        """Return a stamped object in another frame, at its own time.

        Raises:
            TypeException: its type is not registered; `import tf2_geometry_msgs` registers those
                of geometry_msgs.
            TransformException: there is no such transform.
        """
        do_transform = self.registration.get(type(object_stamped))
        header = object_stamped.header
        lookup_transform = self.lookup_transform(
            target_frame, header.frame_id, header.stamp, timeout
        )
        result = do_transform(object_stamped, lookup_transform)
        return result if new_type is None else convert(result, new_type)

    def transform_full(
        self,
        object_stamped: Any,
        target_frame: str,
        target_time: Any,
        fixed_frame: str,
        timeout: Any = None,
        new_type: Any = None,
    ) -> Any:
        """Return a stamped object in another frame at another time, by way of a fixed frame."""
        do_transform = self.registration.get(type(object_stamped))
        header = object_stamped.header
        results = self.lookup_transform_full(
            target_frame, target_time, header.frame_id, header.stamp, fixed_frame, timeout
        )
        result = do_transform(object_stamped, results)
        return result if new_type is None else convert(result, new_type)

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any = None
    ) -> Any:
        """Return a transform; a subclass's."""
        raise NotImplementedException

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = None,
    ) -> Any:
        """Return a transform between two times; a subclass's."""
        raise NotImplementedException

    def can_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any = None
    ) -> Any:
        """Return whether there is a transform; a subclass's."""
        raise NotImplementedException

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = None,
    ) -> Any:
        """Return whether there is a transform between two times; a subclass's."""
        raise NotImplementedException


__all__ = _defined(globals())
