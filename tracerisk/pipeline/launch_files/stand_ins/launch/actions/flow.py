"""Actions that lead to other actions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from tracerisk.pipeline.launch_files.parameter_text import yaml_value
from tracerisk.pipeline.launch_files.stand_ins.launch.action import Action
from tracerisk.pipeline.launch_files.stand_ins.launch.actions.settings import (
    DeclareLaunchArgument,
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetLaunchConfiguration,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_description_source import (
    LaunchDescriptionSource,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import (
    normalize_to_list_of_substitutions,
    text_of,
)


class GroupAction(Action):
    """Actions in a scope of their own."""

    def __init__(
        self,
        actions: Iterable[Any],
        *,
        scoped: bool = True,
        forwarding: bool = True,
        launch_configurations: Mapping[Any, Any] | None = None,
        **rest: Any,
    ) -> None:
        super().__init__(**rest)
        self.actions = actions
        self.scoped = scoped
        self.forwarding = forwarding
        self.configurations = dict(launch_configurations or {})

    def execute(self, context: Any) -> Any:
        """Return the actions between those that begin and end the scope."""
        inner = [action for action in self.actions if action is not None]
        sets: list[Any] = [SetLaunchConfiguration(*item) for item in self.configurations.items()]
        if not self.scoped:
            return [*sets, *inner]
        if not self.forwarding:
            sets = [ResetEnvironment(), ResetLaunchConfigurations(self.configurations)]
        return [
            PushLaunchConfigurations(),
            PushEnvironment(),
            *sets,
            *inner,
            PopEnvironment(),
            PopLaunchConfigurations(),
        ]


class IncludeLaunchDescription(Action):
    """The entities of another launch file."""

    def __init__(
        self,
        launch_description_source: Any,
        *,
        launch_arguments: Iterable[tuple[Any, Any]] | None = None,
        **rest: Any,
    ) -> None:
        super().__init__(**rest)
        source = launch_description_source
        if not isinstance(source, LaunchDescriptionSource):
            source = LaunchDescriptionSource(location=source)
        self.source = source
        pairs = launch_arguments if launch_arguments is not None else ()
        self.launch_arguments = list(pairs.items() if isinstance(pairs, Mapping) else pairs)

    def execute(self, context: Any) -> Any:
        """Return the arguments as settings, then the description of the file."""
        sets = [SetLaunchConfiguration(name, value) for name, value in self.launch_arguments]
        path = self.source.path(context)
        if path is None:
            self._check_arguments(context)
            if self.source.location:
                place = text_of(context, self.source.location)
                places = _places(Path(place))
                is_file = Path(place).is_absolute()
                context.extend_locals(places if is_file else dict.fromkeys(places, place))
            return [*sets, self.source.description]
        # Values are taken where the file is included, not within it.
        done = [configuration.visit(context) for configuration in sets]
        assert not any(done)
        before = context.get_locals_as_dict()
        return [
            OpaqueFunction(function=lambda inner: inner.extend_locals(_places(path))),
            _Described(path),
            OpaqueFunction(function=lambda inner: inner.replace_locals(before)),
        ]

    def _check_arguments(self, context: Any) -> None:
        given = [text_of(context, name) for name, _ in self.launch_arguments]
        for entity in self.source.description.entities:
            if not isinstance(entity, DeclareLaunchArgument) or entity.is_optional:
                continue
            if entity.name not in (*given, *context.launch_configurations):
                raise RuntimeError(
                    f"Included launch description missing required argument '{entity.name}' "
                    f"(description: '{entity.description}'), given: [{', '.join(given)}]"
                )

    def describe_sub_entities(self) -> list[Any]:
        """Return the description that is included, where it is not in a file."""
        return [] if self.source.description is None else [self.source.description]


def _places(path: Path) -> dict[str, str]:
    """Return the path and folder of a launch file as launch names them."""
    return {
        "current_launch_file_path": str(path),
        "current_launch_file_directory": str(path.parent),
    }


class _Described(Action):
    def __init__(self, path: Path) -> None:
        super().__init__()
        self.path = path

    def describe(self) -> str:
        return self.path.name

    def execute(self, context: Any) -> Any:
        return [context.read_file(self.path, context)]


class OpaqueFunction(Action):
    """A function that returns entities."""

    def __init__(
        self,
        *,
        function: Callable[..., Any],
        args: Iterable[Any] | None = None,
        kwargs: Mapping[str, Any] | None = None,
        **rest: Any,
    ) -> None:
        super().__init__(**rest)
        self.function = function
        self.args, self.kwargs = tuple(args or ()), dict(kwargs or {})

    def execute(self, context: Any) -> Any:
        """Return what the function returns."""
        function = self.function(context, *self.args, **self.kwargs)
        return [item for item in function or () if item is not None]


class OpaqueCoroutine(Action):
    """A coroutine, which no description waits for: nothing is done."""

    def __init__(self, *, coroutine: Any, args: Any = None, kwargs: Any = None, **rest: Any):
        rest.pop("ignore_context", None)
        super().__init__(**rest)


class TimerAction(Action):
    """Actions after a time: their time comes at once."""

    def __init__(self, *, period: Any, actions: Iterable[Any], **rest: Any) -> None:
        rest.pop("cancel_on_shutdown", None)
        super().__init__(**rest)
        self.period = period
        self.actions = actions

    def execute(self, context: Any) -> Any:
        """Return the actions."""
        return [action for action in self.actions if action is not None]


class ForEach(Action):
    """Actions for each of a series of values, `name=x,pose=y;name=z,...`."""

    def __init__(self, input_values: Any, *, function: Callable[..., Any], **rest: Any) -> None:
        super().__init__(**rest)
        self.input_values, self.function = input_values, function

    def execute(self, context: Any) -> Any:
        """Return the actions for all values."""
        result: list[Any] = []
        for text in text_of(context, self.input_values).strip(" ;").split(";"):
            values = yaml_value("{" + text + "}") if text.strip() else {}
            result += self.function(**values) or []
        return result


class ForLoop(Action):
    """Actions for each of a number of times."""

    def __init__(self, length: Any, *, function: Callable[..., Any], name: str = "", **rest: Any):
        super().__init__(**rest)
        self.length, self.function = length, function

    def execute(self, context: Any) -> Any:
        """Return the actions of all turns."""
        turns = range(min(int(text_of(context, self.length)), 10_000))
        return [item for turn in turns for item in self.function(turn) or []]


class RegisterEventHandler(Action):
    """What is to be done when an event comes."""

    def __init__(self, event_handler: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self.event_handler = event_handler

    def execute(self, context: Any) -> Any:
        """Keep the handler."""
        context.register_event_handler(self.event_handler)


class UnregisterEventHandler(Action):
    """Forget an event's handler."""

    def __init__(self, event_handler: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self.event_handler = event_handler

    def execute(self, context: Any) -> Any:
        """Forget it."""
        context.unregister_event_handler(self.event_handler)


class EmitEvent(Action):
    """An event, which changes nothing here."""

    def __init__(self, *, event: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self.event = event


class LogInfo(Action):
    """A message, which is not printed."""

    def __init__(self, *, msg: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self._msg = msg

    @property
    def msg(self) -> Any:
        """The message as substitutions."""
        return normalize_to_list_of_substitutions(self._msg)


class ShutdownAction(Action):
    """The end of the launch, which is after the controller's run."""

    def __init__(self, *, reason: Any = "reason not given", **rest: Any) -> None:
        super().__init__(**rest)
        self.reason = reason


Shutdown = ShutdownAction
