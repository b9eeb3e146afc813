"""Messages whose arrays of numbers are numpy's."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np


@cache
def numpy_msg(msg_type: Any) -> Any:
    """Return a class like `msg_type` that receives its arrays as numpy's."""

    def deserialize(self: Any, str: bytes) -> Any:
        return msg_type.deserialize_numpy(self, str, np)

    body = {
        "__slots__": msg_type.__slots__,
        "__doc__": msg_type.__doc__,
        "deserialize": deserialize,
    }
    return type(f"Numpy_{msg_type._type.replace('/', '__')}", (msg_type,), body)
