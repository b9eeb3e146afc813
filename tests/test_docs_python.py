"""What docs/python.md shows is what happens, and what comes out."""

import doctest
import math
import re
from pathlib import Path

import pytest

TEXT = (Path(__file__).parent.parent / "docs" / "python.md").read_text(encoding="utf-8")
NUMBER = re.compile(r"[-+]?\b\d+\.?\d*(?:e[-+]?\d+)?")


class Numeric(doctest.OutputChecker):
    """Output that differs in the last digits of its numbers, as mathematical libraries do, is alike."""

    def check_output(self, want: str, got: str, optionflags: int) -> bool:
        shape = [" ".join(NUMBER.sub("#", text).split()) for text in (want, got)]
        if shape[0] != shape[1]:
            return False
        pairs = zip(NUMBER.findall(want), NUMBER.findall(got), strict=True)
        return all(math.isclose(float(a), float(b), rel_tol=1e-12, abs_tol=0.0) for a, b in pairs)


def test_every_example_of_the_python_guide_runs_with_the_output_that_it_shows():
    for package in ("pyagrum", "networkx"):
        pytest.importorskip(package, reason=f"{package} is not installed")
    blocks = re.findall(r"^```python\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    assert len(blocks) > 8
    names: dict[str, object] = {}
    for block in blocks:
        test = doctest.DocTestParser().get_doctest(block, names, "docs/python.md", None, 0)
        runner = doctest.DocTestRunner(Numeric(), verbose=False)
        reported: list[str] = []
        runner.run(test, out=reported.append, clear_globs=False)
        assert runner.failures == 0, "".join(reported)
        names = test.globs


def test_other_digits_or_words_are_reported_apart():
    assert Numeric().check_output("p=0.1234567890123456\n", "p=0.1234567890123459\n", 0)
    assert not Numeric().check_output("p=0.12345678\n", "p=0.12345679\n", 0)
    assert not Numeric().check_output("p=0.5\n", "q=0.5\n", 0)
    assert not Numeric().check_output("1e-300\n", "2e-300\n", 0)
