"""The names of states that are one instance of several."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.adder.blocks.values import is_function_name, read_transition
from tracerisk.common.instance_name import instance_name, is_name_at, name_at, places, plain_label
from tracerisk.instrument.source.function_definitions import normal_name


@given(st.text())
def test_a_block_holds_every_label_and_gives_it_back(text: str) -> None:
    label = plain_label(text)
    if not label:
        return
    for is_only in (True, False):
        name = instance_name("Pick.execute", label, is_only_method=is_only)
        assert is_function_name(name)
        assert read_transition(f"{name} 1/2").target == name
        assert normal_name(name) == name
        assert is_name_at(name, "Pick.execute")
        assert not is_name_at(name, "Place.execute")


def test_labels_lose_what_separates_names_in_blocks() -> None:
    assert plain_label(" Pick: (left), 1/2;\n{x}=!@ ") == "Pick left 1 2 x"
    assert plain_label("\x00()") == ""
    assert len(plain_label("long " * 50)) <= 40


@pytest.mark.parametrize(
    "name", ["Pick (tray", "Pick tray)", "Pick ()", "Pick (a) (b)", "Pick (a/b)", "a b"]
)
def test_what_is_no_name_of_an_instance_is_refused(name: str) -> None:
    assert not is_function_name(name)


def test_the_class_stands_for_the_only_method() -> None:
    assert instance_name("Pick.execute", "tray", is_only_method=True) == "Pick (tray)"
    assert instance_name("Pick.update", "tray", is_only_method=False) == "Pick.update (tray)"
    assert instance_name("main", "tray", is_only_method=True) == "main (tray)"


def test_a_renamed_class_or_method_keeps_the_form() -> None:
    assert name_at("Pick (tray)", "Grab.execute") == "Grab (tray)"
    assert name_at("Pick.update (tray)", "Grab.update") == "Grab.update (tray)"
    assert name_at("pick", "grab") == "grab"


def test_blocks_stand_at_any_method_of_the_class_or_at_the_method() -> None:
    functions = [("Pick.__init__", 3), ("Pick.execute", 9), ("Place.execute", 20)]
    assert places("Pick (tray)", functions) == [3, 9]
    assert places("Pick.execute (tray)", functions) == [9]
    assert places("Place.execute", functions) == [20]
