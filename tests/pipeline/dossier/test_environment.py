"""A dossier names what tracerisk itself was installed from, as far as pip noted it."""

import pytest

from tracerisk.pipeline.dossier.environment import Environment, origin_words


@pytest.mark.parametrize(
    ("noted", "words"),
    [
        ({}, ""),
        ({"url": "file:///home/me/tracerisk", "dir_info": {"editable": True}}, ""),
        ({"url": "u", "vcs_info": {"vcs": "git", "commit_id": "ab12"}}, "commit ab12"),
        (
            {"url": "file:///home/me/a.whl", "archive_info": {"hashes": {"sha256": "cd"}}},
            "archive with sha256 cd",
        ),
    ],
)
def test_the_origin_is_a_commit_or_a_digest_and_no_place(noted, words):
    assert origin_words(noted) == words


@pytest.mark.parametrize(
    ("version", "origin", "wanted", "why"),
    [
        ("1.2", "", "tracerisk[sim]==1.2", ""),
        ("1.2", "commit ab12", "tracerisk[sim]==1.2", ""),
        ("1.2.dev3", "commit ab12", "tracerisk[sim] @ git+REPOSITORY@ab12", "from its commit"),
        ("1.2.dev3", "archive with sha256 cd", "WHEEL[sim]", "from the archive with sha256 cd"),
        ("1.2.dev3", "", "SOURCE[sim]", "from its source, with `SOURCE` for the folder"),
    ],
)
def test_a_version_that_no_index_has_is_installed_from_what_it_was_made_of(
    version, origin, wanted, why
):
    made_with = Environment("3.12", "Linux", "x86_64", {}, installed_from=origin)
    said, words = made_with.wanted(version)
    assert said == wanted
    assert why in words
    assert bool(words) == bool(why)
