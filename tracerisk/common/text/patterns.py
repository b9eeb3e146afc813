"""Regular expressions that are compiled when they are first used.

To compile one takes a tenth of a millisecond and more, and a command uses few of those that it
loads.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    import re
    from typing import Any, AnyStr


def pattern(text: AnyStr, flags: int = 0) -> re.Pattern[AnyStr]:
    """Return what `re.compile` does, compiled when one of its methods is first asked for."""
    found: Any = _Pattern(text, flags)
    return found  # type: ignore[no-any-return]


class _Pattern:
    def __init__(self, text: Any, flags: int) -> None:
        self._text = text
        self._flags = flags

    def __getattr__(self, name: str) -> Any:
        import re

        found = getattr(re.compile(self._text, self._flags), name)
        # The next time the attribute is there.
        setattr(self, name, found)
        return found
