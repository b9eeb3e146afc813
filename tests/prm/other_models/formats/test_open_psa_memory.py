"""What was read of Open-PSA is freed with the model, with no work for the garbage collector."""

import gc

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.formats.open_psa import loads_open_psa

WHOLE = """\
<opsa-mef><define-fault-tree name="f"><define-gate name="g"><label>a</label><or>
<and><basic-event name="a"/><not><basic-event name="b"/></not></and></or></define-gate>
<define-basic-event name="a"><float value="0.1"/></define-basic-event>
<define-basic-event name="b"><float value="0.1"/></define-basic-event>
</define-fault-tree></opsa-mef>
"""


def read(text: str) -> bool:
    try:
        loads_open_psa(text, "m.xml")
    except ModelError:
        return False
    return True


@pytest.mark.parametrize(
    ("text", "is_read"),
    [
        (WHOLE, True),
        (WHOLE.replace("</label>", "</label"), False),
        (WHOLE.replace("</or>", "</or><or/>"), False),
        (WHOLE.replace('"0.1"', '"2.0"'), False),
        (WHOLE.replace('event name="b"/>', 'event name="c"/>'), False),
    ],
)
def test_no_cycle_is_left(text, is_read):
    read(text)
    # What is there before is looked through no more.
    gc.freeze()
    gc.disable()
    try:
        assert read(text) is is_read
        assert gc.collect() == 0
    finally:
        gc.enable()
