"""The page: sections, styles and scripts in one file that fetches nothing."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Mapping, Sequence
from functools import cache
from html import unescape
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from tracerisk.common.text.printable import without_controls
from tracerisk.report.html.section import Section

_HERE = Path(__file__).parent
_POLICY = re.compile(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">')


def page(
    title: str,
    lead: Markup,
    sections: Sequence[Section],
    *,
    connects: bool = False,
    sheet: str = "",
) -> str:
    """Return the page, the same for the same sections.

    `lead` stands before the sections: the headline and what belongs to it. A page that `connects`
    may ask the server that it came from. `sheet` says at the foot of each printed sheet what it
    belongs to; the title if "".
    """
    script = "\n".join(_function_of(js) for js in (asset("core.js"), *_each(sections, "js")))
    foot = f"@page {{ @bottom-left {{ content: {_css_string(sheet or title)}; }} }}"
    style = "\n".join((asset("page.css"), *_each(sections, "css"), foot))
    for part, ends in ((script, ("</script", "<!--")), (style, ("</style",))):
        for end in ends:
            if end in part.lower():
                raise ValueError(f"{end!r} must not stand in a script or style of the page")
    text: str = rendered(
        "page.html.j2",
        title=title,
        lead=lead,
        sections=[section for section in sections if not section.is_bare],
        connects=connects,
        script=Markup(script),
        style=Markup(style),
        policy=_policy(script, style, connects=connects),
    )
    return without_controls(text.replace("\r\n", "\n"))


def rendered(template: str, **values: Any) -> Markup:
    """Return a template filled in; every value that is no `Markup` is escaped."""
    return Markup(_environment().get_template(template).render(values))


@cache
def asset(name: str) -> str:
    """Return the text of one of the package's own styles or scripts."""
    return (_HERE / "assets" / name).read_text(encoding="utf-8")


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader(_HERE / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=False,
    )
    environment.filters["attributes"] = _attributes
    environment.filters["with_code"] = _with_code
    return environment


def _with_code(text: str) -> Markup:
    """Return text with what stands between backticks as code."""
    parts = text.split("`")
    if len(parts) % 2 == 0:
        return escape(text)
    shown = (Markup("<code>{}</code>") if i % 2 else Markup("{}") for i in range(len(parts)))
    return Markup().join(markup.format(part) for markup, part in zip(shown, parts, strict=True))


def _attributes(values: Mapping[str, object]) -> Markup:
    """Return attributes of an element, those that are `None` or false left out."""
    parts = [
        Markup(" {}").format(Markup(name)) if value is True else _attribute(name, value)
        for name, value in values.items()
        if value is not None and value is not False
    ]
    return Markup("").join(parts)


def _attribute(name: str, value: object) -> Markup:
    return Markup(' {}="{}"').format(Markup(name), str(value))


def _each(sections: Sequence[Section], kind: str) -> list[str]:
    """Return the styles or scripts of the sections, each once, for two may share one."""
    return list(dict.fromkeys(text for section in sections if (text := getattr(section, kind))))


def _css_string(text: str) -> str:
    """Return text as a string of a style, in which nothing ends it, the line or the element."""
    plain = without_controls(" ".join(text.split()))
    kept = (
        char if char.isalnum() or char in " .,:;()/_-" else f"\\{ord(char):06x}" for char in plain
    )
    return f'"{"".join(kept)}"'


def _function_of(script: str) -> str:
    return f'(() => {{\n"use strict";\n{script.strip()}\n}})();'


def policy_of(text: str) -> str:
    """Return the policy that a page has in its head, for a server to send."""
    matched = _POLICY.search(text)
    assert matched is not None, "every page has one"
    return unescape(matched[1])


def _policy(script: str, style: str, *, connects: bool) -> str:
    asks = "; connect-src 'self'" if connects else ""
    # What a browser digests is the text of the element, line breaks around it among it.
    return (
        f"default-src 'none'; script-src '{_digest(script)}'; style-src '{_digest(style)}'; "
        f"img-src data:; base-uri 'none'; form-action 'none'{asks}"
    )


def _digest(text: str) -> str:
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"sha256-{base64.b64encode(digest).decode('ascii')}"
