import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

SCRAM_INPUTS = Path("/usr/share/scram/input")


@dataclass(frozen=True)
class ScramReport:
    """What SCRAM found: tops and sequences with their probabilities, to six digits.

    `products` are the cut sets of each top, as the events that happen and those that do not.
    """

    tops: dict[str, float]
    sequences: dict[tuple[str, str], float] = field(default_factory=dict)
    importance: dict[str, dict[str, dict[str, float]]] = field(default_factory=dict)
    products: dict[str, set[tuple[frozenset[str], frozenset[str]]]] = field(default_factory=dict)


@pytest.fixture(scope="session")
def scram() -> Callable[..., ScramReport]:
    """Run SCRAM on files and return its report."""
    command = shutil.which("scram")
    if command is None:
        pytest.skip("SCRAM is not installed")

    def named(product: ET.Element, path: str) -> frozenset[str]:
        return frozenset(event.get("name") for event in product.findall(path))

    def run(*files: Path, options: tuple[str, ...] = ()) -> ScramReport:
        done = subprocess.run(
            [command, "--bdd", "--probability", "true", *options, *map(str, files)],
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert done.returncode == 0, done.stderr
        results = ET.fromstring(done.stdout).find("results")
        tops, sequences, importance, products = {}, {}, {}, {}
        for each in results:
            name = each.get("name")
            if each.tag == "initiating-event":
                for sequence in each.iter("sequence"):
                    sequences[name, sequence.get("name")] = float(sequence.get("value"))
            elif "initiating-event" in each.attrib:
                continue
            elif each.tag == "sum-of-products":
                tops[name] = float(each.get("probability"))
                products[name] = {
                    (named(product, "basic-event"), named(product, "not/basic-event"))
                    for product in each.iter("product")
                }
            elif each.tag == "importance":
                importance[name] = {
                    event.get("name"): {
                        key: float(value) for key, value in event.attrib.items() if key != "name"
                    }
                    for event in each
                    if event.tag == "basic-event"
                }
        return ScramReport(tops, sequences, importance, products)

    return run


@pytest.fixture(scope="session")
def scram_inputs() -> Path:
    """The models that SCRAM ships."""
    if not SCRAM_INPUTS.is_dir():
        pytest.skip("SCRAM's input files are not installed")
    return SCRAM_INPUTS
