"""A recording is the controller's to write: what it says of a refusal names an error at most."""

import pytest

from tracerisk.errors import InputError, RobotError, TraceRiskError
from tracerisk.instrument.recording import Note, Recording
from tracerisk.pipeline.run.ended_run import _raise_failure


@pytest.mark.parametrize(
    ("data", "kind"),
    [
        ({"error": "RobotError", "message": "no arm", "location": ["c.py", 3, None]}, RobotError),
        ({"error": "Location", "message": "no arm", "location": None}, InputError),
        ({"error": "annotations", "message": 7, "location": [1, 2, 3, 4]}, InputError),
        ({"error": ["x"]}, InputError),
        ("no table", InputError),
    ],
)
def test_a_refusal_of_the_child_is_an_error_of_ours_whatever_it_says(data, kind):
    with pytest.raises(TraceRiskError) as raised:
        _raise_failure(Recording(notes=(Note("failed", data),)))
    assert type(raised.value) is kind
