"""What is set for nodes of ROS 2 is written into a file that real ones read, and we too."""

from tracerisk.ros.graph.parameter_files import (
    EVERY_NODE,
    Parameter,
    overrides_of,
    read_parameters,
    write_overrides,
)


def test_what_is_written_is_read_again(tmp_path):
    given = (
        Parameter("/left/arm", "speed", 0.5),
        Parameter(EVERY_NODE, "names", ["a", "b"]),
        Parameter(EVERY_NODE, "text", "yes"),
        Parameter("/arm", "gain.first", 2),
    )
    path = tmp_path / "parameters.yaml"
    assert write_overrides(given, path) == str(path)
    assert set(map(repr, overrides_of(read_parameters(path)))) == set(
        map(repr, overrides_of(given))
    )


def test_what_is_everybodys_stands_first_for_the_last_counts(tmp_path):
    given = (Parameter("/arm", "speed", 1), Parameter(None, "speed", 2))
    write_overrides(given, tmp_path / "parameters.yaml")
    nodes = (tmp_path / "parameters.yaml").read_text()
    assert nodes.index(EVERY_NODE) < nodes.index("/arm")


def test_what_has_no_type_is_left_out(tmp_path):
    given = (Parameter(EVERY_NODE, "nothing", None), Parameter(EVERY_NODE, "empty", []))
    assert write_overrides(given, tmp_path / "parameters.yaml") is None
    assert not (tmp_path / "parameters.yaml").exists()
