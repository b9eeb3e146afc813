"""Whether a description fits the messages that it speaks of, before anything runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from tracerisk.errors import DriverError, InputError, one_of
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.vendors.answers import Result
from tracerisk.ros.vendors.description import OUTCOMES, Case, Driver, Interface, Output, Value
from tracerisk.ros.vendors.message_paths import FieldError, check, write

if TYPE_CHECKING:
    from tracerisk.ros.vendors.answers import Answers


def types_in_use(driver: Driver, interface: Interface, messages: TwinMessages) -> tuple[str, ...]:
    """Return those types of an interface that the controller's ROS has.

    Raises:
        DriverError: it has their package without them, and a user says that it is there.
    """
    kind = {"services": "service", "actions": "action"}.get(interface.kind, "message")
    types = tuple(name for name in interface.types if messages.has(kind, name))
    if types or driver.origin == "shipped":
        return types
    for name in interface.types:
        package, _, short = name.partition("/")
        if messages.has_package(package):
            names = messages.names(package, kind)
            raise DriverError(
                f"{interface.kind}.{interface.name}: {package} has no {kind} '{short}'; "
                f"{one_of(names, short) if names else 'it has none'}; or put its text into "
                "'definitions'",
                interface.location,
            )
    return ()


def unknown_package(interface: Interface) -> DriverError:
    """Return the error of a description of whose messages none is known."""
    package = interface.types[0].partition("/")[0]
    return DriverError(
        f"{interface.kind}.{interface.name}: no message package '{package}'; put its definitions "
        "into the workspace, in a folder with a package.xml, or into 'definitions'",
        interface.location,
    )


def check_interface(
    interface: Interface,
    type_name: str,
    messages: TwinMessages,
    answers: Answers | None = None,
) -> None:
    """Check each field that an interface names against one of its types.

    With `answers`, each value that can be answered is tried in its field too.

    Raises:
        DriverError: a field is not there, or cannot hold what it is given; with the place of it.
    """
    try:
        asked, answered, fed_back = _samples(interface, type_name, messages)
    except InputError as error:
        raise DriverError(
            f"{interface.kind}.{interface.name}: {error}", interface.location
        ) from error
    for case in interface.cases:
        for key, location, path in _paths(case):
            if path.startswith("$"):
                continue
            try:
                check(type(asked), path)
            except FieldError as error:
                raise DriverError(f"{key}: {error}", location) from error
    for outputs in (interface.response, *(case.response for case in interface.cases)):
        if answered is not None:
            _check_outputs(outputs or {}, answered, asked, answers)
    if fed_back is not None:
        _check_outputs(interface.feedback, fed_back, asked, answers)


def _samples(interface: Interface, type_name: str, messages: TwinMessages) -> tuple[Any, Any, Any]:
    """Return an empty message of what is asked, answered and fed back; None for none."""
    if interface.kind == "services":
        return messages.request(type_name), messages.response(type_name), None
    if interface.kind == "actions":
        parts = ("Goal", "Result", "Feedback")
        asked, answered, fed_back = (messages.part(type_name, part) for part in parts)
        return asked, answered, fed_back
    made = messages.new(type_name)
    is_heard = interface.kind == "subscribed_topics"
    return (made, None, None) if is_heard else (None, made, None)


def _paths(case: Case) -> Iterator[tuple[str, Any, str]]:
    for one in case.when:
        yield one.key, one.location, one.path
    values: list[Value] = [*case.roles.values(), *case.set.values()]
    values += [item for item in (case.wait, case.timeout) if item is not None]
    for value in values:
        for path in value.paths:
            yield value.key, value.location, path


def _check_outputs(
    outputs: Mapping[str, Output],
    message: Any,
    asked: Any,
    answers: Answers | None,
) -> None:
    for path, output in outputs.items():
        try:
            check(type(message), path)
            if output.reference.startswith("request."):
                if asked is None:
                    raise FieldError("a published topic answers no request")
                check(type(asked), output.reference.removeprefix("request."))
                continue
            for value in () if answers is None else _possible(output, answers):
                write(message, path, value, answers.conventions, output.unit)  # type: ignore[union-attr]
        except FieldError as error:
            raise DriverError(f"{output.key}: {error}", output.location) from error


def _possible(output: Output, answers: Answers) -> Iterator[Any]:
    """Yield what an output can come to: what it is now, each code, each value of its map."""
    if output.reference == "code":
        for outcome in OUTCOMES:
            yield answers.value(output, Result(outcome))
        return
    if output.map is not None:
        yield from output.map.values()
        return
    yield answers.value(output, Result())
