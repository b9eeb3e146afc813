"""The Open-PSA Model Exchange Format 2.0d, XML, as SCRAM 0.16 reads it."""

from tracerisk.common.on_demand import on_demand
from tracerisk.prm.other_models.formats.open_psa.open_psa_reader import (
    loads_open_psa,
    read_open_psa,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.other_models.formats.open_psa.writer import dumps_open_psa, write_open_psa

__all__ = ["dumps_open_psa", "loads_open_psa", "read_open_psa", "write_open_psa"]
# What writes a model knows models of every kind; who only reads one does not load it.
__getattr__ = on_demand(__name__, {"writer": "dumps_open_psa write_open_psa"})
