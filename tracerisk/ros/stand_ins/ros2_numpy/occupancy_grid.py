"""Maps as masked arrays (height, width): unknown cells are masked."""

from __future__ import annotations

from typing import Any

import numpy as np
from nav_msgs.msg import MapMetaData, OccupancyGrid

from .registry import converts_from_numpy, converts_to_numpy

__all__ = ["numpy_to_occupancy_grid", "occupancygrid_to_numpy"]


@converts_to_numpy(OccupancyGrid)
def occupancygrid_to_numpy(msg: Any) -> Any:
    """Return a map as a masked array."""
    data = np.asarray(msg.data, dtype=np.int8).reshape(msg.info.height, msg.info.width)
    return np.ma.array(data, mask=data == -1, fill_value=-1)


@converts_from_numpy(OccupancyGrid)
def numpy_to_occupancy_grid(arr: Any, info: Any = None) -> Any:
    """Return an array (height, width) of int8 as a map.

    Raises:
        TypeError: the array is of another form.
    """
    if arr.ndim != 2:
        raise TypeError("Array must be 2D")
    if arr.dtype != np.int8:
        raise TypeError("Array must be of int8s")
    values = arr.filled(-1) if isinstance(arr, np.ma.MaskedArray) else arr
    grid = OccupancyGrid(info=info or MapMetaData())
    grid.data = [int(value) for value in values.ravel()]
    grid.info.height, grid.info.width = arr.shape
    return grid
