"""Whether a description fits the messages that it speaks of, before anything runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tracerisk.errors import DriverError, InputError
from tracerisk.ros.twin_messages import TwinMessages
from tracerisk.vendors.answers import Answers, Result
from tracerisk.vendors.description import OUTCOMES, Case, Interface, Output, Value
from tracerisk.vendors.message_paths import FieldError, check, write

_ASKS = {"services": "request", "actions": "goal", "subscribed_topics": "message"}
_ANSWERS = {"services": "response", "actions": "result", "published_topics": "message"}


def check_interface(
    interface: Interface,
    type_name: str,
    messages: TwinMessages,
    answers: Answers,
) -> None:
    """Check each field that an interface names against one of its types.

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
        asked, answered, fed_back = (messages.part(type_name, each) for each in parts)
        return asked, answered, fed_back
    made = messages.new(type_name)
    is_heard = interface.kind == "subscribed_topics"
    return (made, None, None) if is_heard else (None, made, None)


def _paths(case: Case) -> Iterator[tuple[str, Any, str]]:
    for one in case.when:
        yield one.key, one.location, one.path
    values: list[Value] = [*case.roles.values(), *case.set.values()]
    values += [each for each in (case.wait, case.timeout) if each is not None]
    for value in values:
        for path in value.paths:
            yield value.key, value.location, path


def _check_outputs(
    outputs: Mapping[str, Output],
    message: Any,
    asked: Any,
    answers: Answers,
) -> None:
    for path, output in outputs.items():
        try:
            check(type(message), path)
            if output.reference.startswith("request."):
                if asked is None:
                    raise FieldError("a published topic answers no request")
                check(type(asked), output.reference.removeprefix("request."))
                continue
            for value in _possible(output, answers):
                write(message, path, value, answers.conventions, output.unit)
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
