"""The parameters of a node: declared with a descriptor, guarded by callbacks."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any

from rcl_interfaces.msg import (
    ListParametersResult,
    ParameterDescriptor,
    ParameterEvent,
    SetParametersResult,
)

from tracerisk.ros.controller.needs import Need

from ._handle import Handle
from ._parameter_checks import declaration, refusal
from ._run import run
from .exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from .parameter import PARAMETER_SEPARATOR_STRING, Parameter, parameter_value_to_python

_NOT_SET = Parameter.Type.NOT_SET


class NodeParameters:
    """What a node does with parameters; the other half of `Node`."""

    _parameters: dict[str, Parameter]
    _descriptors: dict[str, Any]
    _handle: Handle
    _parameter_overrides: dict[str, Parameter]
    _allow_undeclared_parameters: bool
    _pre_set_parameters_callbacks: list[Callable[[list[Parameter]], list[Parameter]]]
    _on_set_parameters_callbacks: list[Callable[[list[Parameter]], Any]]
    _post_set_parameters_callbacks: list[Callable[[list[Parameter]], None]]

    def declare_parameter(
        self, name: str, value: Any = None, descriptor: Any = None, ignore_override: bool = False
    ) -> Parameter:
        """Declare a parameter by a default value or a type, and return it; see the next."""
        if value is None and descriptor is None:
            arguments: tuple[Any, ...] = (name,)
        else:
            arguments = (name, value, ParameterDescriptor() if descriptor is None else descriptor)
        return self.declare_parameters("", [arguments], ignore_override)[0]

    def declare_parameters(
        self, namespace: str, parameters: Sequence[tuple[Any, ...]], ignore_override: bool = False
    ) -> list[Parameter]:
        """Declare parameters: (name,), (name, value or type) or (name, value, descriptor).

        A value of the command line takes the place of the default.

        Raises:
            TypeError: a tuple is malformed, or a value of no type that a parameter can have.
            ValueError: a parameter would have neither a type nor `dynamic_typing`.
            ParameterAlreadyDeclaredException: one is declared.
            InvalidParameterTypeException: the command line gives another type.
            InvalidParameterValueException: a range or a callback refuses the value.
        """
        results: list[Parameter] = []
        descriptors: dict[str, Any] = {}
        for index, entry in enumerate(parameters):
            name, value, descriptor = declaration(namespace, index, entry)
            run().runtime.graph.parameters.ask(name)
            kind = Parameter.Type(descriptor.type).name.lower() if descriptor.type else ""
            scheduler, need = run().scheduler, Need("parameter", name, kind)
            if not ignore_override and name in self._parameter_overrides:
                value = self._parameter_overrides[name].value
                scheduler.needs.take(need, value, scheduler.now_ns)
            else:
                scheduler.needs.take_default(need, value, scheduler.now_ns)
            results.append(Parameter(name, value=value))
            descriptors[name] = descriptor
        known = [parameter.name for parameter in results if parameter.name in self._parameters]
        if known:
            raise ParameterAlreadyDeclaredException(known)
        for parameter in results:
            result = self._set_all([parameter], descriptors, keeps_unset=True)
            if result.successful:
                continue
            if result.reason.startswith("Wrong parameter type"):
                expected = Parameter.Type(descriptors[parameter.name].type).name
                raise InvalidParameterTypeException(parameter, expected)
            raise InvalidParameterValueException(parameter.name, parameter.value, result.reason)
        return [self._parameters[parameter.name] for parameter in results]

    def undeclare_parameter(self, name: str) -> None:
        """Forget a parameter.

        Raises:
            ParameterNotDeclaredException: it is not declared.
            ParameterImmutableException: it is read-only.
        """
        if name not in self._parameters:
            raise ParameterNotDeclaredException(name)
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(name)
        del self._parameters[name], self._descriptors[name]

    def has_parameter(self, name: str) -> bool:
        """Return whether a parameter is declared."""
        return name in self._parameters

    def get_parameter(self, name: str) -> Parameter:
        """Return a parameter.

        Raises:
            ParameterNotDeclaredException: it is not declared.
            ParameterUninitializedException: it has a type and no value yet.
        """
        if name in self._parameters:
            parameter = self._parameters[name]
            if parameter.type_ is not _NOT_SET or self._descriptors[name].dynamic_typing:
                return parameter
            kind = Parameter.Type(self._descriptors[name].type).name.lower()
            run().scheduler.miss(Need("parameter", name, kind))
            raise ParameterUninitializedException(name)
        # What is declared was asked for when it was declared.
        run().runtime.graph.parameters.ask(name)
        if self._allow_undeclared_parameters:
            return Parameter(name, _NOT_SET, None)
        raise ParameterNotDeclaredException(name)

    def get_parameters(self, names: Sequence[str]) -> list[Parameter]:
        """Return parameters; see `get_parameter`.

        Raises:
            TypeError: a name is not text.
        """
        if not all(isinstance(name, str) for name in names):
            raise TypeError("All names must be instances of type str")
        return [self.get_parameter(name) for name in names]

    def get_parameter_or(self, name: str, alternative_value: Parameter | None = None) -> Parameter:
        """Return a parameter, or the alternative where it is not declared or not set."""
        parameter = self._parameters.get(name)
        if parameter is not None and parameter.type_ is not _NOT_SET:
            return parameter
        return Parameter(name, _NOT_SET) if alternative_value is None else alternative_value

    def get_parameter_type(self, name: str) -> Any:
        """Return a parameter's type.

        Raises:
            ParameterNotDeclaredException: it is not declared.
        """
        if name in self._parameters:
            return self._parameters[name].type_.value
        if self._allow_undeclared_parameters:
            return _NOT_SET
        raise ParameterNotDeclaredException(name)

    def get_parameter_types(self, names: Sequence[str]) -> list[Any]:
        """Return the types of parameters; see `get_parameter_type`."""
        return [self.get_parameter_type(name) for name in names]

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Return the parameters below a prefix, by what follows it."""
        start = prefix + PARAMETER_SEPARATOR_STRING if prefix else ""
        return {
            name[len(start) :]: parameter
            for name, parameter in self._parameters.items()
            if name.startswith(start)
        }

    def list_parameters(self, prefixes: list[str], depth: int) -> Any:
        """Return a ListParametersResult of the names below prefixes, down to a depth (0: all).

        Raises:
            TypeError: the prefixes are no list of texts, or the depth is not a number.
            ValueError: the depth is negative.
        """
        if not isinstance(prefixes, list):
            raise TypeError("The prefixes argument must be a list")
        if not all(isinstance(prefix, str) for prefix in prefixes):
            raise TypeError("All prefixes must be instances of type str")
        if not isinstance(depth, int):
            raise TypeError("The depth must be instance of type int")
        if depth < 0:
            raise ValueError("The depth must be greater than or equal to zero")

        def is_within(rest: str) -> bool:
            return depth == 0 or rest.count(PARAMETER_SEPARATOR_STRING) < depth

        result = ListParametersResult()
        for name in self._parameters:
            below = [
                name[len(prefix) + 1 :]
                for prefix in prefixes
                if name.startswith(prefix + PARAMETER_SEPARATOR_STRING)
            ]
            if name in prefixes or any(map(is_within, below if prefixes else [name])):
                result.names.append(name)
                parent, separator, _ = name.rpartition(PARAMETER_SEPARATOR_STRING)
                if separator and parent not in result.prefixes:
                    result.prefixes.append(parent)
        return result

    def set_parameters(self, parameter_list: Sequence[Parameter]) -> list[Any]:
        """Set parameters one by one, and return a SetParametersResult for each.

        Raises:
            ParameterNotDeclaredException: one is not declared.
            TypeError: one is no Parameter.
        """
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list: Sequence[Parameter]) -> Any:
        """Set all parameters or none, and return a SetParametersResult; see `set_parameters`."""
        wanted = list(parameter_list)
        if self._pre_set_parameters_callbacks:
            wanted = [
                p for callback in self._pre_set_parameters_callbacks for p in callback(wanted)
            ]
            if not wanted:
                reason = (
                    "parameter list cannot be empty, this might be due to "
                    "pre_set_parameters_callback modifying the original parameters list."
                )
                return SetParametersResult(successful=False, reason=reason)
        if not all(isinstance(parameter, Parameter) for parameter in wanted):
            raise TypeError(f"parameter must be instance of type '{Parameter!r}'")
        unknown = [p.name for p in wanted if p.name not in self._parameters]
        if unknown and not self._allow_undeclared_parameters:
            # The real library asks a generator first whether there is any: that one is gone then.
            raise ParameterNotDeclaredException(unknown[1:])
        return self._set_all(wanted, None, keeps_unset=False)

    def add_pre_set_parameters_callback(self, callback: Any) -> None:
        """Call `callback` to change the list of parameters before they are checked."""
        self._pre_set_parameters_callbacks.insert(0, callback)

    def add_on_set_parameters_callback(self, callback: Any) -> None:
        """Call `callback` to agree to what is set: it returns a SetParametersResult."""
        self._on_set_parameters_callbacks.insert(0, callback)

    def add_post_set_parameters_callback(self, callback: Any) -> None:
        """Call `callback` after parameters were set."""
        self._post_set_parameters_callbacks.insert(0, callback)

    def remove_pre_set_parameters_callback(self, callback: Any) -> None:
        """Undo `add_pre_set_parameters_callback`."""
        self._pre_set_parameters_callbacks.remove(callback)

    def remove_on_set_parameters_callback(self, callback: Any) -> None:
        """Undo `add_on_set_parameters_callback`."""
        self._on_set_parameters_callbacks.remove(callback)

    def remove_post_set_parameters_callback(self, callback: Any) -> None:
        """Undo `add_post_set_parameters_callback`."""
        self._post_set_parameters_callbacks.remove(callback)

    def describe_parameter(self, name: str) -> Any:
        """Return a parameter's descriptor.

        Raises:
            ParameterNotDeclaredException: it is not declared.
        """
        if name in self._descriptors:
            return self._descriptors[name]
        if self._allow_undeclared_parameters:
            return ParameterDescriptor()
        raise ParameterNotDeclaredException(name)

    def describe_parameters(self, names: Sequence[str]) -> list[Any]:
        """Return the descriptors of parameters; see `describe_parameter`."""
        return [self.describe_parameter(name) for name in names]

    def set_descriptor(self, name: str, descriptor: Any, alternative_value: Any = None) -> Any:
        """Replace a parameter's descriptor, and return its value.

        Raises:
            ParameterNotDeclaredException: it is not declared.
            ParameterImmutableException: it is read-only.
            InvalidParameterValueException: the value does not fit.
        """
        if name not in self._descriptors:
            raise ParameterNotDeclaredException(name)
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(name)
        value = self._parameters[name].value
        if alternative_value is not None:
            value = parameter_value_to_python(alternative_value)
        result = self._set_all([Parameter(name, value=value)], {name: descriptor}, False)
        if not result.successful:
            raise InvalidParameterValueException(name, value, result.reason)
        return self._parameters[name].get_parameter_value()

    # How

    def _set_all(
        self, wanted: list[Parameter], descriptors: dict[str, Any] | None, keeps_unset: bool
    ) -> Any:
        for parameter in wanted:
            if descriptors is not None:
                descriptor = descriptors[parameter.name]
            else:
                descriptor = self._descriptors.get(parameter.name)
            reason = refusal(parameter, descriptor, is_new=descriptors is not None)
            if reason:
                return SetParametersResult(successful=False, reason=reason)
        for callback in self._on_set_parameters_callbacks:
            result = callback(wanted)
            asks = run().runtime.distro.value("parameter-callback-returns-no-result") == "refused"
            if asks and not isinstance(result, SetParametersResult):
                reason = "Callback returned an invalid type"
                warnings.warn(f"{reason}, it should return SetParameterResult.", stacklevel=2)
                return SetParametersResult(successful=False, reason=reason)
            if not result.successful:
                return result
        with self._handle:
            event = ParameterEvent()
        for parameter in wanted:
            self._store(parameter, descriptors, keeps_unset, event)
        self._publish_event(event)
        for notify in self._post_set_parameters_callbacks:
            notify(wanted)
        return SetParametersResult(successful=True)

    def _store(
        self,
        parameter: Parameter,
        descriptors: dict[str, Any] | None,
        keeps_unset: bool,
        event: Any,
    ) -> None:
        name = parameter.name
        if parameter.type_ is _NOT_SET and not keeps_unset:
            event.deleted_parameters.append(parameter.to_parameter_msg())
            self._parameters.pop(name, None)
            self._descriptors.pop(name, None)
            return
        is_new = self.get_parameter_or(name).type_ is _NOT_SET
        (event.new_parameters if is_new else event.changed_parameters).append(
            parameter.to_parameter_msg()
        )
        if descriptors is not None:
            self._descriptors[name] = descriptors[name]
        elif name not in self._descriptors:
            self._descriptors[name] = ParameterDescriptor(dynamic_typing=True)
        self._descriptors[name].name = name
        if self._descriptors[name].dynamic_typing:
            self._descriptors[name].type = parameter.type_.value
        self._parameters[name] = parameter

    def _publish_event(self, event: Any) -> None:
        raise NotImplementedError
