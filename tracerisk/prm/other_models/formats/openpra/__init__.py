"""The JSON that the OpenPRA engine takes: fault trees, common cause groups and event trees.

Read and written as `types/model.d.ts` of the engine has it in openpra-monorepo of 2025-12-24
(commit 1fd869ea), see docs/formats.md.
"""

from tracerisk.prm.other_models.formats.openpra.openpra_reader import loads_openpra, read_openpra
from tracerisk.prm.other_models.formats.openpra.writer import dumps_openpra, write_openpra

__all__ = ["dumps_openpra", "loads_openpra", "read_openpra", "write_openpra"]
