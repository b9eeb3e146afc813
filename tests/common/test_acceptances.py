"""What a user accepts of a verdict, as it stands in settings and scenarios."""

import pytest

from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.common.verdict import Acceptance, Reason
from tracerisk.errors import SettingsError


def settings(folder, entry: str):
    (folder / "pyproject.toml").write_text(f"[tool.tracerisk]\naccept = [{entry}]\n")
    return ProjectSettings(folder).of()


def test_an_entry_names_code_function_object_and_words(tmp_path):
    entry = '{code = "lookup-failed", function = "locate", object = "part", words = "may be gone"}'
    (accepted,) = settings(tmp_path, entry).accept
    assert accepted == Acceptance("lookup-failed", "locate", "part", "may be gone")


@pytest.mark.parametrize("thing", ["compute_cartesian_path", 'a "quoted" name', ""])
def test_the_entry_that_a_reason_prints_accepts_it_once_it_has_words(tmp_path, thing):
    reason = Reason("distro-assumed", "partial", "x", "Cell.linear", thing)
    entry = reason.accept_entry
    assert entry.endswith('words = "WHY"}')
    (accepted,) = settings(tmp_path, entry).accept
    assert accepted.key == reason.key


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ('"never-ran"', "entry 1 is not a table; expected code, function, object and words"),
        ('{code = "never-run", words = "x"}', "'never-run' cannot be accepted; did you mean"),
        ('{code = "run-deadlock", words = "x"}', "'run-deadlock' cannot be accepted"),
        ('{code = "never-ran", function = "f"}', "words are missing; say why never-ran"),
        ('{code = "never-ran", function = "*", words = "x"}', "wildcards are not allowed"),
        ('{code = "never-ran", line = 3, words = "x"}', "unknown key 'line'"),
        ('{code = "never-ran", function = 3, words = "x"}', "function is 3; expected a string"),
        (
            '{code = "never-ran", words = "x"}, {code = "never-ran", words = "y"}',
            "entry 2 is a duplicate",
        ),
    ],
)
def test_a_bad_entry_is_an_error_with_its_line(tmp_path, entry, message):
    with pytest.raises(SettingsError, match="accept: ") as caught:
        settings(tmp_path, entry)
    assert message in caught.value.message
    assert caught.value.location.line == 2
