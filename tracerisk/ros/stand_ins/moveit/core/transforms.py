"""Fixed frames and where they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Transforms"]


class Transforms:
    """Transforms from fixed frames to one target frame, which is all that is known."""

    def __init__(self, target_frame: str) -> None:
        if not target_frame:
            raise RuntimeError("The target frame for MoveIt Transforms cannot be empty.")
        self._target_frame = target_frame

    def get_target_frame(self) -> str:
        """Return the target frame."""
        return self._target_frame

    def get_transform(self, from_frame: str) -> NDArray[np.float64]:
        """Return the transform (4, 4) of a frame; identity, as in the real library, if unknown."""
        return np.eye(4)

    def get_all_transforms(self) -> dict[str, NDArray[np.float64]]:
        """Return the transform (4, 4) of each frame."""
        return {self._target_frame: np.eye(4)}
