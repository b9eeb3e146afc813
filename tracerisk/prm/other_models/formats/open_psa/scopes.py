"""Which element a name in a file stands for: its own home first, then all that are public."""

from __future__ import annotations

from tracerisk.prm.other_models.formats.open_psa.xml_elements import Element
from tracerisk.prm.other_models.logic.checks import suggestion


class Scope:
    """The names of one kind of elements: by full name, and by the path of where they stand."""

    def __init__(self, what: str) -> None:
        self._what = what
        self.kinds: dict[str, str] = {}
        self.elements: dict[str, Element] = {}
        self._paths: dict[str, str] = {}
        self.has_private = False

    def add(self, element: Element, kind: str, short: str, home: str, *, private: bool) -> str:
        """Add an element and return its full name.

        Raises ModelError when the name is taken.
        """
        path = f"{home}.{short}" if home else short
        name = path if private else short
        if name in self.kinds:
            first = self.elements[name].location
            element.fail(f"'{name}' is defined twice, first at {first}; rename or remove one")
        self.kinds[name] = kind
        self.elements[name] = element
        if home:
            self._paths[path] = name
        self.has_private = self.has_private or private
        return name

    def find(self, element: Element, home: str, kind: str | None) -> str:
        """Return the full name of what an element refers to from `home`, of the kind asked for.

        Raises ModelError when there is none.
        """
        short = element.attributes.get("name") or element.attribute("name")
        name: str | None = short if short in self.kinds else None
        if self.has_private or "." in short:
            name = self._inside(short, home) or name
        if name is None:
            element.fail(
                f"{kind or self._what} '{short}' is not defined; {suggestion(self.kinds, short)}"
            )
        text = self.kinds[name]
        if kind is not None and text != kind:
            element.fail(f"'{short}' is a {text}, not a {kind}; refer to it as a {text}")
        return name

    def _inside(self, short: str, home: str) -> str | None:
        while home:
            name = self._paths.get(f"{home}.{short}")
            if name is not None:
                return name
            home = home.rpartition(".")[0]
        return self._paths.get(short)
