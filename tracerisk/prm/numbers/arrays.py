"""NumPy, for samples and large models; where it is not installed, the error names the extra."""

from tracerisk.common.dependencies import require_large

require_large("numpy")

import numpy as np  # noqa: E402

__all__ = ["np"]
