"""What the tool makes of random histories of branches, compared with what each branch typed."""

import re

import pytest

from tests.pipeline.history.merge_histories import History, calls_of, run_history, with_calls
from tests.pipeline.history.renaming_histories import run_renaming_history
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.errors import EditInTheWayError


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


def without_section(history: History, component: str) -> None:
    """Take out the last section of a component, as a person does, or who resolves a conflict."""
    begin, _, rest = history.read().rpartition(
        f"    # | @Component {{\n    # |   name = {component}\n"
    )
    history.write(history.main, begin + rest.partition("    # | }\n")[2])


def said_of(history: History) -> tuple[str, str]:
    """Return what a refresh says of a person's edits, and of those of unknown author."""
    with pytest.raises(EditInTheWayError) as caught:
        history.annotated(MergePolicy())
    certain, _, doubtful = str(caught.value).partition("it is unknown who wrote these values")
    return certain, doubtful


@pytest.mark.parametrize("is_mixed", [False, True])
def test_what_is_missing_where_blocks_are_of_two_versions_may_be_a_merge_s(
    is_mixed: bool, tmp_path
) -> None:
    """A conflict was resolved line by line, and the lock lost."""
    history = History(tmp_path / "r", seed=1)
    ours = history.read()
    history.hardware()
    history.refresh()
    history.commit()
    if is_mixed:
        place = "def place(arm):"
        history.write(
            history.main, ours.partition(place)[0] + "".join(history.read().partition(place)[1:])
        )
    (history.folder / "tracerisk.lock").unlink()
    without_section(history, "camera")
    certain, doubtful = said_of(history)
    assert "leave.camera was removed" in (doubtful if is_mixed else certain)
    assert certain == "" or not is_mixed


@pytest.mark.parametrize("is_mixed", [False, True])
def test_a_lock_that_does_not_know_a_block_of_its_own_file_is_of_another_branch(
    is_mixed: bool, tmp_path
) -> None:
    history = History(tmp_path / "r", seed=1)
    block = re.search(r"(?:    # \|.*\n)+(?=    motor\(arm\)\n\n)", history.read())
    assert block is not None
    history.write(history.main, with_calls(history.read(), ["home", "leave"]))
    history.refresh()
    text = history.read()
    if is_mixed:
        text = text.replace("def place(arm):\n", f"def place(arm):\n{block[0]}")
    history.write(history.main, re.sub(r"quantity = .", "quantity = 8", text, count=1))
    (history.folder / ".git").rename(tmp_path / "git")
    certain, doubtful = said_of(history)
    assert "home.camera.quantity is 8" in (doubtful if is_mixed else certain)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(204))
def test_two_hundred_histories(seed: int, tmp_path) -> None:
    run_history(tmp_path / "r", seed)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("language", ["python", "cpp"])
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 50))]
)
def test_histories_with_renamed_functions_and_files(seed: int, language: str, tmp_path) -> None:
    run_renaming_history(tmp_path / "r", seed, language)
