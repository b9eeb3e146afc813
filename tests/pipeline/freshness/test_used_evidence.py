"""The evidence that is kept of controllers, as checks read it again and again."""

import os
from dataclasses import replace

from tests.pipeline.evidence.test_file import CELL, EVIDENCE
from tracerisk.common.evidence import file
from tracerisk.common.evidence.file import dump_evidence
from tracerisk.pipeline.freshness.used_evidence import kept_evidence
from tracerisk.pipeline.workspace.controller import load_controller


def test_the_file_is_read_once_for_all_controllers_until_it_changes(example, monkeypatch):
    read, texts = file.loads_evidence, []
    monkeypatch.setattr(file, "loads_evidence", lambda *given: texts.append(given) or read(*given))
    controllers = []
    for name in ("pick.py", "place.py"):
        example.write(name, "print()\n")
        controllers.append(load_controller(example.folder / name))
    told = {"pick.py": EVIDENCE, "place.py": replace(EVIDENCE, cells=(CELL,))}
    path = example.folder / "tracerisk.evidence"
    path.write_text(dump_evidence(told))
    os.utime(path, ns=(0, 1))
    for _ in range(3):
        assert [kept_evidence(controller) for controller in controllers] == list(told.values())
    assert len(texts) == 1
    later = {"pick.py": told["place.py"]}
    path.write_text(dump_evidence(later))
    assert [kept_evidence(controller) for controller in controllers] == [told["place.py"], None]
    assert len(texts) == 2
    path.unlink()
    assert kept_evidence(controllers[0]) is None
