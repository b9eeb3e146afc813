"""Which language a source is written in, by the suffix of its name."""

from __future__ import annotations

from pathlib import PurePath

C_SUFFIXES = frozenset({".c", ".h"})
CPP_SUFFIXES = frozenset({".cc", ".cpp", ".cxx", ".c++", ".hh", ".hpp", ".hxx", ".ino"})


def is_c(file: str) -> bool:
    """Return whether a file is C or C++ by its suffix."""
    return PurePath(file).suffix.lower() in C_SUFFIXES | CPP_SUFFIXES


def is_c_like(file: str) -> bool:
    """Return whether a file's suffix says that its comments are those of C, C++ and Java."""
    return is_c(file) or PurePath(file).suffix.lower() == ".java"
