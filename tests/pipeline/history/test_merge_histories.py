"""What the tool makes of random histories of branches, compared with what each branch typed."""

import pytest

from tests.pipeline.history.merge_histories import calls_of, run_history, with_calls
from tests.pipeline.history.renaming_histories import run_renaming_history

MIXED = pytest.mark.xfail(
    reason="a block whose conflict was resolved line by line counts as edited", strict=True
)
"""The known limit of docs/blocks.md."""


@pytest.mark.parametrize(
    "source",
    [
        'const char* CALLS =\n    "home "\n    "leave home";\n',
        'CALLS = (\n    "home leave home"\n)\n',
    ],
    ids=["clang-format", "black"],
)
def test_calls_are_found_where_a_formatter_broke_their_line(source: str) -> None:
    assert calls_of(source) == ["home", "leave", "home"]
    ends = source[source.rindex('"') + 1 :]
    assert with_calls(source, ["leave"]) == source[: source.index('"')] + '"leave"' + ends


def test_a_history(tmp_path) -> None:
    """Ranks of another branch beside the first lines of this one, in a shallow clone."""
    run_history(tmp_path / "r", seed=130)


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [pytest.param(seed, marks=[MIXED] * (seed in (109, 157))) for seed in range(204)]
)
def test_two_hundred_histories(seed: int, tmp_path) -> None:
    run_history(tmp_path / "r", seed)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("language", ["python", "cpp"])
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 50))]
)
def test_histories_with_renamed_functions_and_files(
    seed: int, language: str, request, tmp_path
) -> None:
    if (seed, language) == (28, "cpp"):
        request.applymarker(MIXED)
    run_renaming_history(tmp_path / "r", seed, language)
