"""A dossier names what tracerisk itself was installed from, as far as pip noted it."""

import pytest

from tracerisk.pipeline.dossier.environment import origin_words


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
