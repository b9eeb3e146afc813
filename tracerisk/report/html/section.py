"""A section of the page, and the data that its script reads."""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from markupsafe import Markup


@dataclass(frozen=True, slots=True)
class Data:
    """Data within the page: `name` is the id of its element, `text` safe in a script element."""

    name: str
    text: str
    kind: str

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
    """A part of the page below a heading of its own.

    `name` is its id and the target of links, `title` its heading, `html` what stands below the
    heading, escaped; `css` and `js` are its own, `data` what its script reads.
    `summary` is what navigation says of it, its title if empty.
    One that `is_bare` brings style and script alone, and is not seen.
    """

    name: str
    title: str
    html: Markup
    css: str = ""
    js: str = ""
    data: tuple[Data, ...] = ()
    summary: str = ""
    is_bare: bool = False


def json_in_script(value: Any) -> str:
    r"""Return a value as JSON that no script element can end or comment out.

    `<`, `>` and `&` are escaped, so that neither `</script>` nor `<!--` stands in it; so are
    U+2028 and U+2029 and whatever is not ASCII, lone surrogates among them.
    """
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
