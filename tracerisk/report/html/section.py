"""A section of the page, and the data that its script reads."""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.common.text.printable import printable_script

if TYPE_CHECKING:
    from markupsafe import Markup


@dataclass(frozen=True, slots=True)
class Data:
    """Data within the page for a script."""

    name: str
    """Id of the element that holds it."""
    text: str
    """Content, safe in a script element."""
    kind: str
    """Media type of the content."""

    @classmethod
    def of_json(cls, name: str, value: Any) -> Data:
        """Return a value that JSON has; `NaN` and infinity are refused by a ValueError."""
        return cls(name, json_in_script(value), "application/json")

    @classmethod
    def of_bytes(cls, name: str, content: bytes) -> Data:
        """Return bytes as base64."""
        return cls(name, base64.b64encode(content).decode("ascii"), "application/octet-stream")


@dataclass(frozen=True, slots=True)
class Section:
    """A part of the page below a heading of its own."""

    name: str
    """Id of the section, and the target of links."""
    title: str
    """Heading of the section."""
    html: Markup
    """Content below the heading, escaped."""
    css: str = ""
    """Style of the section; "" for none."""
    js: str = ""
    """Script of the section; "" for none."""
    data: tuple[Data, ...] = ()
    """Data that the script reads."""
    summary: str = ""
    """Text for the navigation; the title if ""."""
    is_bare: bool = False
    """Whether it brings only style and script and is not seen."""
    beside: Markup | None = None
    """What of it stands beside the headline of the page, escaped; `None` for nothing."""


def json_in_script(value: Any) -> str:
    r"""Return a value as JSON that no script element can end or comment out.

    `<`, `>` and `&` are escaped, so that neither `</script>` nor `<!--` stands in it; so are
    whatever is not ASCII, and what no page may show (`without_controls`).
    """
    dumped = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    text = printable_script(dumped)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
