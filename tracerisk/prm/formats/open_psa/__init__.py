"""The Open-PSA Model Exchange Format 2.0d, XML, as SCRAM 0.16 reads it."""

from tracerisk.prm.formats.open_psa.reader import loads_open_psa, read_open_psa
from tracerisk.prm.formats.open_psa.writer import dumps_open_psa, write_open_psa

__all__ = ["dumps_open_psa", "loads_open_psa", "read_open_psa", "write_open_psa"]
