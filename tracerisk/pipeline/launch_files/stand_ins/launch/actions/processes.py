"""Actions that start programs: they are noted, none is started."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from tracerisk.pipeline.launch_files.records import StartedNode
from tracerisk.pipeline.launch_files.stand_ins.launch.action import Action
from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import text_of

# They say how a program runs, not with what.
_HOW = frozenset(
    {
        "cached_output",
        "cwd",
        "emulate_tty",
        "log_cmd",
        "name",
        "on_exit",
        "output",
        "output_format",
        "prefix",
        "respawn",
        "respawn_delay",
        "respawn_max_retries",
        "shell",
        "sigkill_timeout",
        "sigterm_timeout",
        "sigquit_timeout",
    }
)


def only_how(options: Mapping[str, Any], owner: str) -> None:
    """Raise TypeError where an option is none that a program takes."""
    for name in options:
        if name not in _HOW:
            raise TypeError(f"{owner} got an unexpected keyword argument '{name}'")


class ExecuteProcess(Action):
    """A program by its command line."""

    def __init__(
        self,
        *,
        cmd: Iterable[Any],
        env: Mapping[Any, Any] | None = None,
        additional_env: Mapping[Any, Any] | None = None,
        condition: Any = None,
        **rest: Any,
    ) -> None:
        super().__init__(condition=condition)
        only_how(rest, type(self).__name__)
        self.cmd = list(cmd)
        self._environment = {**(env or {}), **(additional_env or {})}

    def environment(self, context: Any) -> tuple[tuple[str, str], ...]:
        """Return the variables that the launch file sets for the program."""
        own = {text_of(context, k): text_of(context, v) for k, v in self._environment.items()}
        return tuple(sorted({**context.changed_environment, **own}.items()))

    def execute(self, context: Any) -> Any:
        """Note the program."""
        words = [text_of(context, word) for word in self.cmd]
        # One text may hold a whole command line.
        command = words[0].split() if len(words) == 1 else words
        context.reading.nodes.append(
            StartedNode("", "", command=tuple(command), environment=self.environment(context))
        )


class ExecuteLocal(Action):
    """A program by its description."""

    def __init__(self, *, process_description: Any, condition: Any = None, **rest: Any) -> None:
        super().__init__(condition=condition)
        self.process_description = process_description
