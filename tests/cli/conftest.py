import pytest

HARDWARE = """\
components:
  electric_motor:
    quantity: 7
    probability: {value: 9.5e-08, per: minute}
    twin: {joints: "*"}
"""


@pytest.fixture(scope="session")
def hardware() -> str:
    return HARDWARE


@pytest.fixture(scope="session")
def two_steps(quick) -> str:
    """A controller of two steps, `act` and `home`."""
    return quick().replace("    act(arm)\n", "    act(arm)\n    home(arm)\n")


@pytest.fixture(scope="session")
def annotated_run(tmp_path_factory, example_in, two_steps):
    """One run of a small controller, with its trace and model beside it."""
    example = example_in(tmp_path_factory.mktemp("quick"))
    example.write("controller.py", two_steps)
    outcome = example.run(
        "run", "controller.py", "--json", "--trace", "trace.json", "--model", "model.json"
    )
    assert outcome.code == 0, outcome.err
    return example, outcome


@pytest.fixture
def annotated(annotated_run, example):
    """A copy of that folder, for a test to work in."""
    run, _ = annotated_run
    for name, data in run.files().items():
        example.write(name, data)
    return example
