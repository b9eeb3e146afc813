"""What of a controller's sources is instrumented before its run."""

import pytest

from tracerisk.api import load_controller
from tracerisk.instrument.loader import source_key
from tracerisk.pipeline.run.controller_run import instrumented_ahead

SCRIPT = "import helper\n\n\ndef main():\n    helper.act()\n"
HELPER = "def act():\n    pass\n"


@pytest.mark.parametrize(
    ("helper", "ahead"),
    [
        (HELPER, {"c.py", "helper.py"}),
        ("def act(:\n", {"c.py"}),
        (f"x = {'(' * 5000}1{')' * 5000}\n", {"c.py"}),
        ("\N{LATIN SMALL LETTER E WITH ACUTE} = 1\n".encode("latin-1"), {"c.py"}),
        (f"{HELPER}x = [{'0.1, ' * 12_000}]\n", {"c.py"}),
        (HELPER + "x = 1\n" * 50_000, set()),
    ],
    ids=["plain", "broken", "nested", "not UTF-8", "long", "large"],
)
def test_what_can_be_is_instrumented_ahead_unless_it_is_much(tmp_path, helper, ahead):
    helper = helper if isinstance(helper, bytes) else helper.encode()
    (tmp_path / "c.py").write_text(SCRIPT)
    (tmp_path / "helper.py").write_bytes(helper)
    sources = {"c.py": SCRIPT.encode(), "helper.py": helper}
    texts = instrumented_ahead(load_controller(tmp_path / "c.py"))
    assert texts.keys() == {source_key(file, sources[file]) for file in ahead}
