"""Digests of bytes, without what `hashlib` loads.

It loads OpenSSL, which takes longer than all that a check of one file has to digest. Python's own
functions give the same digests.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

_SMALL = 1 << 20  # bytes from which on OpenSSL is the faster one


def _own(names: tuple[str, ...], function: str) -> Callable[..., Any]:
    """Return a function of Python's own modules; that of `hashlib` where it was built without."""
    for name in (*names, "hashlib"):
        try:
            result: Callable[..., Any] = getattr(import_module(name), function)
        except (ImportError, AttributeError):
            continue
        return result
    raise ImportError(f"this Python has no {function}")


blake2b = _own(("_blake2",), "blake2b")
_sha256 = _own(("_sha2", "_sha256"), "sha256")  # the first since Python 3.12


def sha256(data: bytes) -> str:
    """Return the SHA-256 digest of bytes, in hexadecimal digits."""
    if len(data) < _SMALL:
        return str(_sha256(data).hexdigest())
    import hashlib

    return hashlib.sha256(data).hexdigest()


def short_digest(text: str) -> str:
    """Return a digest of a text in 12 hexadecimal digits, to compare versions of it."""
    return str(blake2b(text.encode(errors="surrogatepass"), digest_size=6).hexdigest())
