"""The YAML of `ruamel.yaml` that refuses a text nested too deeply, before time and memory go."""

from __future__ import annotations

import warnings
from typing import Any, Literal

from ruamel.yaml import YAML
from ruamel.yaml.error import MantissaNoDotYAML1_1Warning
from ruamel.yaml.scanner import RoundTripScanner, Scanner, ScannerError

MOST_LEVELS = 100
"""How deeply a text may nest."""

# Files of other people's robots are read, and nobody asked for advice on `1e300` in them.
warnings.simplefilter("ignore", MantissaNoDotYAML1_1Warning)


def bounded_yaml(typ: Literal["rt", "safe"], version: tuple[int, int]) -> Any:
    """Return what reads YAML of a version, with the places of all keys where `typ` is `rt`.

    Its errors are `ruamel.yaml.error.YAMLError`; that of a text that is nested deeper than
    `MOST_LEVELS` names the place.
    """
    yaml = _Plain(typ=typ, pure=True)
    yaml.version = version
    yaml.Scanner = _BoundedRoundTripScanner if typ == "rt" else _BoundedScanner
    return yaml


class _Plain(YAML):
    def official_plug_ins(self) -> list[str]:
        """Return no plug-ins: the library has none here, and looks for them on disk each time."""
        return []


class _Bounded:
    """What both scanners do at each level."""

    flow_context: list[str]
    indents: list[int]
    reader: Any

    def fetch_flow_collection_start(self, token: Any, to_push: str) -> None:
        self._check()
        super().fetch_flow_collection_start(token, to_push)  # type: ignore[misc]

    def add_indent(self, column: int) -> bool:
        self._check()
        return bool(super().add_indent(column))  # type: ignore[misc]

    def _check(self) -> None:
        if len(self.flow_context) + len(self.indents) > MOST_LEVELS:
            raise ScannerError(
                None, None, f"is nested deeper than {MOST_LEVELS} levels", self.reader.get_mark()
            )


class _BoundedScanner(_Bounded, Scanner):
    pass


class _BoundedRoundTripScanner(_Bounded, RoundTripScanner):
    pass
