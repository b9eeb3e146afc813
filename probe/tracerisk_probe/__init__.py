"""Which function of a robot's controller issued each command, recorded while it runs."""

from tracerisk_probe.recording import watch
from tracerisk_probe.starting import start

__all__ = ["start", "watch"]
__version__ = "0.1.0"
