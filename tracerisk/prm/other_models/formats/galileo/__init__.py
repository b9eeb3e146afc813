"""Dynamic fault trees as Galileo text, as Storm, DFTCalc and the FFORT benchmarks have it.

Sources: K. Sullivan, J. B. Dugan, "Galileo User's Manual & Design Overview", version 2.11-alpha,
University of Virginia (1998); the extensions of Storm (stormchecker.org, "DFT input formats") and
of FFORT (dftbenchmarks.utwente.nl, "FFORT fault trees input format").
"""

from tracerisk.prm.other_models.formats.galileo.galileo_reader import loads, parameter_names
from tracerisk.prm.other_models.formats.galileo.writer import dumps

__all__ = ["dumps", "loads", "parameter_names"]
