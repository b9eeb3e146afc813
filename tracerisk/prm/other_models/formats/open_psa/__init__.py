"""The Open-PSA Model Exchange Format 2.0d, XML, as SCRAM 0.16 reads it.

`writer.py` writes it: that knows models of every kind, and who only reads one does not load it.
"""

from tracerisk.prm.other_models.formats.open_psa.open_psa_reader import (
    loads_open_psa,
    read_open_psa,
)

__all__ = ["loads_open_psa", "read_open_psa"]
