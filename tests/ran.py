"""What a program left that a test ran on the twin."""

from dataclasses import dataclass
from typing import Any

from tracerisk.instrument.ownership import attribute
from tracerisk.instrument.recording import Recording


@dataclass
class Ran:
    """Its global names, the recording and the twin."""

    names: dict[str, Any]
    recording: Recording
    twin: Any

    def __getitem__(self, name: str) -> Any:
        return self.names[name]

    @property
    def findings(self) -> list[str]:
        return [finding.message for finding in self.recording.findings]

    @property
    def owners(self) -> list[str]:
        """The owner of each visit, in their order."""
        attribution = attribute(self.recording, end_ns=self.twin.time_ns)
        return [visit.function.name for visit in attribution.visits]
