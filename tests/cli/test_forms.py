"""Blocks in the compact form: converted there and back, and at work in every verb."""

import re

import pytest

CONTROLLER = "controller.py"


@pytest.fixture
def compact(annotated):
    outcome = annotated.run("annotate", CONTROLLER, "--form", "compact")
    assert outcome.code == 0, outcome.err
    assert "controller.py: converted to the compact form" in outcome.err
    return annotated


def text(example) -> str:
    return example.read(CONTROLLER).decode()


def model(example) -> object:
    return example.run("build", CONTROLLER, "--json").json["model"]


def test_a_conversion_there_and_back_gives_the_same_bytes_model_and_lock(annotated):
    before, model_before = annotated.files(), model(annotated)
    assert annotated.run("annotate", CONTROLLER, "--form", "compact").code == 0
    assert "@Function" not in text(annotated)
    assert re.search(r"# \| act 1 -> home 1\n", text(annotated))
    assert len(text(annotated)) < 0.6 * len(before[CONTROLLER])
    assert model(annotated) == model_before
    changed = {name for name, data in annotated.files().items() if data != before.get(name)}
    assert {name for name in changed if not name.startswith(".tracerisk_cache")} == {CONTROLLER}
    assert annotated.run("check", CONTROLLER).code == 0
    assert annotated.run("annotate", CONTROLLER, "--form", "published").code == 0
    assert annotated.files() == before


def test_a_reason_typed_on_a_long_line_comes_back_as_it_was_typed(annotated):
    reason = "! computed 1e-07; service log of the cell, 2026, sheet 3: the belt of the finger"
    stated = f"probability := 2e-07  {reason}"
    typed = re.sub(r"probability = [\d.e-]+", stated, text(annotated), count=1)
    annotated.write(CONTROLLER, typed)
    laid_out = []
    for form in ("compact", "published", "compact", "published"):
        assert annotated.run("annotate", CONTROLLER, "--form", form).code == 0
        laid_out.append(text(annotated))
    assert laid_out[:2] == laid_out[2:]
    assert laid_out[1] == typed


def test_check_and_diff_write_nothing(annotated):
    before = annotated.files()
    outcome = annotated.run("annotate", CONTROLLER, "--form", "compact", "--check", "--diff")
    assert outcome.code == 1
    assert "+    # | act 1 -> home 1" in outcome.out
    assert "would be converted to the compact form" in outcome.err
    again = annotated.run("annotate", CONTROLLER, "--form", "published", "--check", "--json")
    assert (again.code, again.json["changed"], again.json["files"]) == (0, False, [])
    assert annotated.files() == before


def test_a_refresh_keeps_the_form_and_accepts_edits_in_it(compact):
    value = re.search(r"# \| \w+ +(\d\.\d+e-\d+) ", text(compact))[1]
    compact.write(CONTROLLER, text(compact).replace(value, "2e-07    ", 1))
    outcome = compact.run("check", CONTROLLER)
    assert outcome.code == 3
    assert f".probability is 2e-07, was written as {value}" in outcome.out
    assert compact.run("refresh", CONTROLLER).code == 3
    assert compact.run("refresh", CONTROLLER, "--accept-edits").code == 0
    assert re.search(rf"# \| \w+ +:= 2e-07 +\d.* +! computed {value}\n", text(compact))
    assert "@Function" not in text(compact)
    overrides = compact.run("overrides", CONTROLLER, "--json").json["overrides"]
    assert [(each["value"], each["computed"]) for each in overrides] == [("2e-07", value)]
    assert compact.run("refresh", CONTROLLER, "--discard-edits", "--fresh").code == 0
    assert compact.run("check", CONTROLLER).code == 0


def test_a_file_may_hold_both_forms(annotated):
    published, figure = text(annotated), model(annotated)
    assert annotated.run("annotate", CONTROLLER, "--form", "compact").code == 0
    at = "def act"
    assert published.index("def home") < published.index(at)
    both = published.partition(at)[0] + at + text(annotated).partition(at)[2]
    annotated.write(CONTROLLER, both)
    assert "@Function {" in both
    assert "# | act 1 -> home 1" in both
    assert model(annotated) == figure
    assert annotated.run("check", CONTROLLER).code == 0
    outcome = annotated.run("refresh", CONTROLLER)
    assert outcome.code == 0
    assert text(annotated) == both


def test_strip_takes_out_either_form(annotated):
    published = annotated.files()
    assert annotated.run("strip", CONTROLLER).code == 0
    stripped = text(annotated)
    for name, data in published.items():
        annotated.write(name, data)
    assert annotated.run("annotate", CONTROLLER, "--form", "compact").code == 0
    assert annotated.run("strip", CONTROLLER).code == 0
    assert text(annotated) == stripped


def test_new_blocks_have_the_form_of_the_setting(annotated):
    compact = annotated.files()
    assert annotated.run("annotate", CONTROLLER, "--form", "compact").code == 0
    wanted = text(annotated)
    for name, data in compact.items():
        annotated.write(name, data)
    assert annotated.run("strip", CONTROLLER).code == 0
    annotated.write("pyproject.toml", '[tool.tracerisk]\nblocks = "compact"\n')
    outcome = annotated.run("annotate", CONTROLLER, "--trace", "trace.json")
    assert outcome.code == 0, outcome.err
    assert text(annotated) == wanted


def test_a_renamed_function_keeps_its_compact_block(compact):
    compact.write(CONTROLLER, text(compact).replace("home(arm)", "rest(arm)"))
    outcome = compact.run("check", CONTROLLER)
    assert "the function of the block `home` is called `rest` now" in outcome.out
    assert compact.run("refresh", CONTROLLER).code == 0
    assert "# | act 1 -> rest 1" in text(compact)
    assert "# | rest 2 -> done 1" in text(compact)


def test_a_misplaced_compact_block_says_what_to_write(compact):
    compact.write(CONTROLLER, text(compact).replace("# | act 1", "# | home 1"))
    outcome = compact.run("build", CONTROLLER)
    assert outcome.code == 2
    assert "the risk block of `home` stands at `act`; write `act` for its name" in outcome.err


def test_the_setting_is_one_of_the_two_forms(annotated):
    annotated.write("pyproject.toml", '[tool.tracerisk]\nblocks = "short"\n')
    outcome = annotated.run("check", CONTROLLER)
    assert outcome.code == 2
    assert "blocks: 'short' is not allowed; allowed: compact, published" in outcome.out
