"""Written values that a refresh keeps: noise of another processor, and nothing else."""

import json
import random

import pytest

CONTROLLER = "controller.py"
DISTURBANCE = 1e-3


def disturbed(value, noise):
    """Return plain data with each fraction off by up to one part in a thousand."""
    if isinstance(value, dict):
        return {key: disturbed(item, noise) for key, item in value.items()}
    if isinstance(value, list):
        return [disturbed(item, noise) for item in value]
    if isinstance(value, float):
        return value * (1.0 + noise.uniform(-DISTURBANCE, DISTURBANCE))
    return value


def on_another_machine(example, seed=None, longer=1.0):
    """Annotate from the last run as another processor has it; `longer` is how long all takes."""
    data = json.loads(example.read("trace.json"))
    if seed is not None:
        data = disturbed(data, random.Random(seed))
    for visit in data["visits"]:
        visit["exposures"] = scaled(visit["exposures"], longer)
    example.write("other.json", json.dumps(data))
    outcome = example.run("annotate", CONTROLLER, "--trace", "other.json", "--json")
    assert outcome.code == 0, outcome.err
    return outcome.json


def scaled(value, by):
    if isinstance(value, dict):
        return {key: scaled(item, by) for key, item in value.items()}
    return value * by if isinstance(value, float) else value


def written(example):
    return {name: example.read(name) for name in (CONTROLLER, "tracerisk.lock")}


def lock(example):
    return json.loads(example.read("tracerisk.lock"))["controllers"][CONTROLLER]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("form", ["published", "compact"])
def test_the_noise_of_other_processors_writes_the_same_bytes(annotated, form):
    assert annotated.run("annotate", CONTROLLER, "--form", form).code == 0
    before = written(annotated)
    for seed in range(5):
        assert on_another_machine(annotated, seed)["changed"] is False
        assert written(annotated) == before
    annotated.write("pyproject.toml", "[tool.tracerisk]\ntolerance = 0\n")
    assert on_another_machine(annotated, 0)["changed"] is True
    assert written(annotated)[CONTROLLER] != before[CONTROLLER]


def probabilities(example):
    """The motors' probability in each function's block, as it is written."""
    blocks = lock(example)["blocks"][CONTROLLER]
    return {
        name: block["components"]["electric_motor"]["probability"] for name, block in blocks.items()
    }


def change(example, old, new):
    source = example.read(CONTROLLER).decode()
    assert old in source
    example.write(CONTROLLER, source.replace(old, new, 1))


def test_only_the_values_behind_which_code_changed_are_written_anew(annotated):
    before = probabilities(annotated)
    change(annotated, 'set_named_target("ready")', 'set_named_target("ready"); print()')
    on_another_machine(annotated, longer=1.004)
    after = probabilities(annotated)
    assert after["act"] == before["act"]
    assert float(after["home"]) == pytest.approx(1.004 * float(before["home"]), rel=1e-3)
    (computed,) = lock(annotated)["kept"][CONTROLLER]["act"].values()
    assert float(computed) == pytest.approx(1.004 * float(before["act"]), rel=1e-3)
    assert list(lock(annotated)["kept"][CONTROLLER]) == ["act"]
    assert annotated.run("check", CONTROLLER).code == 0
    again = written(annotated)
    for seed in range(3):
        on_another_machine(annotated, seed, longer=1.004)
        assert written(annotated) == again


def test_a_change_beside_the_functions_is_behind_all_of_them(annotated):
    before = probabilities(annotated)
    change(annotated, "import os", "LIMIT = 1\nimport os")
    on_another_machine(annotated, longer=1.004)
    after = probabilities(annotated)
    assert all(after[name] != text for name, text in before.items())
    assert "kept" not in lock(annotated)


def test_other_hardware_data_are_never_taken_for_noise(annotated, hardware):
    two = (
        hardware
        + """\
  power:
    quantity: 1
    probability: {value: 1e-08, per: minute}
    active: always
"""
    )
    annotated.write("hardware.yaml", two)
    annotated.write("pyproject.toml", '[tool.tracerisk]\nhardware = "hardware.yaml"\n')
    on_another_machine(annotated)
    before = lock(annotated)["blocks"]
    annotated.write("hardware.yaml", two.replace("1e-08", "1.002e-08"))
    on_another_machine(annotated, longer=1.002)
    for name, block in lock(annotated)["blocks"][CONTROLLER].items():
        was = before[CONTROLLER][name]["components"]
        now = block["components"]
        assert now["electric_motor"] == was["electric_motor"]
        assert now["power"]["probability"] != was["power"]["probability"]


def test_a_change_of_a_comment_alone_keeps_the_values(annotated):
    before = probabilities(annotated)
    change(annotated, "import os", "# What follows is needed.\nimport os")
    on_another_machine(annotated, longer=1.004)
    assert probabilities(annotated) == before


def test_kept_values_do_not_creep(annotated):
    before = probabilities(annotated)["act"]
    for step, longer in enumerate((1.003, 1.0045, 1.006)):
        change(annotated, 'target("ready")', f'target("ready"); print({step})')
        on_another_machine(annotated, longer=longer)
        is_kept = probabilities(annotated)["act"] == before
        assert is_kept == (longer < 1.005)
    assert "kept" not in lock(annotated)


def test_check_and_diff_use_what_was_computed(annotated, repository):
    for name, data in annotated.files().items():
        if not name.startswith(".tracerisk_cache"):
            repository.write(name, data)
    repository.commit()
    change(repository, 'set_named_target("ready")', 'set_named_target("ready"); print()')
    on_another_machine(repository, longer=1.004)
    figure = repository.run("solve", CONTROLLER, "--json").json["assessment"]["mission"]
    low = figure["geometric_cycles"]
    (compared,) = repository.run("diff", "--json").json["controllers"]
    after = compared["after"]["cycle_failure_probability"]
    assert after > low * 1.0005
    limit = (low + after) / 2.0
    fine = repository.run("solve", CONTROLLER, "--max-failure-probability", repr(limit))
    assert fine.code == 0
    repository.write("pyproject.toml", f"[tool.tracerisk]\nmax_failure_probability = {limit!r}\n")
    checked = repository.run("check", CONTROLLER)
    assert checked.code == 1
    assert "above the max_failure_probability" in checked.out


def test_an_edit_counts_and_not_what_was_kept_in_its_place(annotated, repository):
    for name, data in annotated.files().items():
        repository.write(name, data)
    change(repository, 'set_named_target("ready")', 'set_named_target("ready"); print()')
    on_another_machine(repository, longer=1.004)
    repository.commit()
    text = probabilities(repository)["act"]
    change(repository, f"probability = {text}", "probability = 1e-3")
    (controller,) = repository.run("diff", "--json").json["controllers"]
    assert controller["after"]["cycle_failure_probability"] > 9e-4
