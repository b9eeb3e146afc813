"""Functions of one name in several files keep apart in the model."""

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.common.function_ref import FunctionRef, QualifiedName


def names(*functions: tuple[str, str]) -> list[str]:
    return list(model_names([FunctionRef(f, QualifiedName(n)) for f, n in functions]).values())


def test_a_name_of_its_own_stays_as_it_is():
    assert names(("a.py", "go"), ("b.py", "stop")) == ["go", "stop"]


def test_a_shared_name_gets_its_module():
    assert names(("a.py", "Arm.go"), ("lib/b.py", "Arm.go")) == ["a.Arm.go", "b.Arm.go"]


def test_a_shared_stem_gets_its_folders():
    assert names(("p/a/x.py", "go"), ("p/b/x.py", "go")) == ["a.x.go", "b.x.go"]
    assert names(("p/x.py", "go"), ("p/a/x.py", "go")) == ["x.go", "a.x.go"]


def test_it_does_not_matter_from_where_paths_are_reported():
    below = names(("x.py", "go"), ("a/x.py", "go"))
    assert below == names(("/home/me/x.py", "go"), ("/home/me/a/x.py", "go"))


def test_what_is_no_identifier_is_made_one_and_a_package_is_its_folder():
    assert names(("left-arm.py", "go"), ("right/__init__.py", "go")) == ["left_arm.go", "right.go"]


def test_a_function_called_as_the_missions_end_gets_its_module():
    assert names(("a.py", "done"), ("a.py", "go")) == ["a.done", "go"]
    assert names(("p/a.py", "done"), ("q/a.py", "done")) == ["p.a.done", "q.a.done"]
    assert names(("a.py", "Arm.done")) == ["Arm.done"]
