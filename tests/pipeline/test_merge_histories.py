"""What the tool makes of random histories of branches, compared with what each branch typed."""

from __future__ import annotations

import pytest

from tests.pipeline.merge_histories import run_history


# The last one: ranks of another branch beside the first lines of this one, in a shallow clone.
@pytest.mark.parametrize("seed", [109, 130])
def test_a_history(seed: int, tmp_path) -> None:
    run_history(tmp_path / "r", seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(204))
def test_two_hundred_histories(seed: int, tmp_path) -> None:
    run_history(tmp_path / "r", seed)
