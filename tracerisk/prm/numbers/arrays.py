"""NumPy, for samples and large models, imported when one of its names is first used.

Most models are solved without it. Where it is not installed, the error names the extra.
"""

from __future__ import annotations

from tracerisk.common.dependencies import require_large

TYPE_CHECKING = False  # `typing` takes longer to import than a small tree to solve
if TYPE_CHECKING:
    import numpy as np
else:

    class _NumPy:
        """The names of NumPy, each of which is kept once it is used."""

        def __getattr__(self, name: str) -> object:
            require_large("numpy")

            import numpy as np

            value = getattr(np, name)
            setattr(self, name, value)
            return value

    np = _NumPy()

__all__ = ["np"]
