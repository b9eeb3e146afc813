"""Nodes are replaced as xacro replaces them, in one pass."""

from xml.dom.minidom import Element, parseString

import pytest
from xacrodoc.xacrodoc import xacro

from tracerisk.twin.urdf.xacro_child import replace_node

REPLACE = xacro.xmlutils.replace_node
TEXT = "<r>a<b/><old x='1'>c</old><d/>e</r>"


def result(replace, given: list[str] | None, content_only: bool) -> list[object]:
    document = parseString(TEXT)
    root = document.documentElement
    (old,) = root.getElementsByTagName("old")
    by = None if given is None else [parseString(each).documentElement for each in given]
    replace(old, by[0] if by and len(by) == 1 else by, content_only)
    row = root.childNodes
    beside = [(each.previousSibling, each.nextSibling) for each in row]
    assert beside == list(zip([None, *row[:-1]], [*row[1:], None], strict=True))
    assert all(each.parentNode is root for each in row)
    assert (old.parentNode, old.previousSibling, old.nextSibling) == (None, None, None)
    left = [] if by is None else [each.toxml() for each in by if each.parentNode is not root]
    return [root.toxml(), left]


@pytest.mark.parametrize("content_only", [False, True])
@pytest.mark.parametrize(
    "given",
    [None, ["<n/>"], ["<n>text<m/><m k='1'><o/></m></n>"], ["<n><m/></n>", "<p/>"], []],
)
def test_nodes_are_replaced_as_xacro_replaces_them(given, content_only):
    assert result(replace_node, given, content_only) == result(REPLACE, given, content_only)


def test_the_place_is_looked_for_once(monkeypatch):
    def refused(*_: object) -> None:
        raise AssertionError("each node looks for its place")

    monkeypatch.setattr(Element, "insertBefore", refused)
    assert result(replace_node, ["<n><m/><m/></n>"], True)[0] == "<r>a<b/><m/><m/><d/>e</r>"
