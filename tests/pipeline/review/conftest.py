import pytest


@pytest.fixture(scope="session")
def two_steps(annotated_source):
    """Make a controller of two steps; the figures of each may be given."""

    def make(motor="2e-8", gripper="= 2e-07", power="1e-5 of2"):
        return annotated_source(
            pick=("place 1", f"motor = {motor} x7; power = {power}"),
            place=("pick 9/10, done 1/10", f"gripper {gripper}"),
        )

    return make
