import pytest

from tracerisk.errors import RobotError
from tracerisk.twin.urdf.xml_reader import read_xml


def test_comments_last_until_their_end_whatever_they_hold():
    text = "<robot>\n<!-- a -- b --!>\n<link name='none'/> -->\n<!----><link name='base'/></robot>"
    root = read_xml(text, "a.srdf")
    assert [(each.string("name"), each.location.line) for each in root.all("link")] == [("base", 4)]


@pytest.mark.parametrize("text", ["<robot><!-- a -- b --!></robot>", "<robot>\n<!-- -- --><link>"])
def test_what_is_no_xml_without_its_comments_is_an_error_with_its_line(text: str):
    with pytest.raises(RobotError, match=r"a\.srdf.*is not XML") as caught:
        read_xml(text, "a.srdf")
    assert caught.value.location is not None
    assert caught.value.location.line == text.count("\n") + 1
