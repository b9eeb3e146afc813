"""Actions that change launch configurations and the environment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch.action import Action
from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import (
    normalize_to_list_of_substitutions,
    text_of,
)


class DeclareLaunchArgument(Action):
    """An argument of the launch file, which has its default if nobody gives another value."""

    def __init__(
        self,
        name: str,
        *,
        default_value: Any = None,
        description: str | None = None,
        choices: Sequence[str] | None = None,
        **rest: Any,
    ) -> None:
        super().__init__(**rest)
        self.name = name
        self._default = default_value
        self.choices = None if choices is None else list(choices)
        message = "no description given" if description is None else description
        valid = "" if self.choices is None else f" Valid choices are: {self.choices}"
        self.description = message + valid
        self._conditionally_included = False

    def _gather_arguments(self, is_conditional: bool, found: list[Any]) -> None:
        self._conditionally_included = is_conditional
        if self.name not in {known.name for known in found}:
            found.append(self)

    @property
    def is_optional(self) -> bool:
        """Whether nobody has to give a value: there is a default, or a condition."""
        return self._default is not None or self.condition is not None

    @property
    def default_value(self) -> Any:
        """The default as substitutions; None where there is none."""
        given = self._default
        return None if given is None else normalize_to_list_of_substitutions(given)

    def execute(self, context: Any) -> Any:
        """Set the default.

        Raises:
            RuntimeError: there is none, or the value is none of the choices.
        """
        if self.name not in context.launch_configurations:
            if self._default is None:
                raise RuntimeError(
                    f"Required launch argument '{self.name}' was not provided: it has no default"
                )
            text = text_of(context, self._default)
            context.launch_configurations[self.name] = text
        value = context.launch_configurations[self.name]
        if self.choices is not None and value not in self.choices:
            raise RuntimeError(
                f"argument '{self.name}' is '{value}'; its choices: {', '.join(self.choices)}"
            )
        return None


class SetLaunchConfiguration(Action):
    """Set a launch configuration."""

    def __init__(self, name: Any, value: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self._given = (name, value)

    @property
    def name(self) -> Any:
        """The name as substitutions."""
        return normalize_to_list_of_substitutions(self._given[0])

    @property
    def value(self) -> Any:
        """The value as substitutions."""
        return normalize_to_list_of_substitutions(self._given[1])

    def execute(self, context: Any) -> Any:
        """Set it."""
        name, value = (text_of(context, item) for item in self._given)
        context.launch_configurations[name] = value


class UnsetLaunchConfiguration(Action):
    """Remove a launch configuration."""

    def __init__(self, name: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self.name = name

    def execute(self, context: Any) -> Any:
        """Remove it, if it is set."""
        context.launch_configurations.pop(text_of(context, self.name), None)


class PushLaunchConfigurations(Action):
    """Begin a scope of launch configurations."""

    def execute(self, context: Any) -> Any:
        """Begin it."""
        context.push_configurations()


class PopLaunchConfigurations(Action):
    """End a scope of launch configurations."""

    def execute(self, context: Any) -> Any:
        """End it."""
        context.pop_configurations()


class ResetLaunchConfigurations(Action):
    """Forget all launch configurations but those given."""

    def __init__(self, launch_configurations: Mapping[Any, Any] | None = None, **rest: Any):
        super().__init__(**rest)
        self.kept = dict(launch_configurations or {})

    def execute(self, context: Any) -> Any:
        """Forget them."""
        kept = {text_of(context, k): text_of(context, v) for k, v in self.kept.items()}
        context.launch_configurations.clear()
        context.launch_configurations.update(kept)


class SetEnvironmentVariable(Action):
    """Set an environment variable."""

    def __init__(self, name: Any, value: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self.name, self.value = name, value

    def execute(self, context: Any) -> Any:
        """Set it."""
        context.set_environment(text_of(context, self.name), text_of(context, self.value))


class AppendEnvironmentVariable(Action):
    """Add to an environment variable."""

    def __init__(
        self, name: Any, value: Any, prepend: bool = False, separator: Any = ":", **rest: Any
    ) -> None:
        super().__init__(**rest)
        self.name, self.value, self.prepend, self.separator = name, value, prepend, separator

    def execute(self, context: Any) -> Any:
        """Add to it."""
        name, value = text_of(context, self.name), text_of(context, self.value)
        old = context.environment.get(name)
        parts = [text for text in ((value, old) if self.prepend else (old, value)) if text]
        context.set_environment(name, text_of(context, self.separator).join(parts))


class UnsetEnvironmentVariable(Action):
    """Remove an environment variable."""

    def __init__(self, name: Any, **rest: Any) -> None:
        super().__init__(**rest)
        self.name = name

    def execute(self, context: Any) -> Any:
        """Remove it, if it is set."""
        name = text_of(context, self.name)
        context.environment.pop(name, None)
        context.changed_environment.pop(name, None)


class PushEnvironment(Action):
    """Begin a scope of environment variables."""

    def execute(self, context: Any) -> Any:
        """Begin it."""
        context.push_environment()


class PopEnvironment(Action):
    """End a scope of environment variables."""

    def execute(self, context: Any) -> Any:
        """End it."""
        context.pop_environment()


class ResetEnvironment(Action):
    """Forget what the launch file has changed in the environment."""

    def execute(self, context: Any) -> Any:
        """Forget it."""
        for name in context.changed_environment:
            context.environment.pop(name, None)
        context.changed_environment.clear()
