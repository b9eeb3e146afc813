"""What a function returns in a process of its own, which may then be contained for good."""

import json
import os
import traceback
from collections.abc import Callable
from typing import Any


def in_child(work: Callable[[], Any]) -> Any:
    """Return what `work` returns in a forked process, as JSON tells it; or what it raised."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        told = "could not be made"
        try:
            os.close(reading)
            told = work()
        except BaseException:  # noqa: BLE001 - the parent reports it
            told = traceback.format_exc()
        finally:
            os.write(writing, json.dumps(told).encode())
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as stream:
        text = stream.read()
    os.waitpid(child, 0)
    return json.loads(text)
