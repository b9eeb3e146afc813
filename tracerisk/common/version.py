"""The version of tracerisk: that of the installed distribution.

Nothing is imported that a start does without: `importlib.metadata` takes as long as all of `check`.
"""

import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable

UNKNOWN = "0.dev0"
"""The version of code that nobody installed, such as a checkout on PYTHONPATH."""

_NAME = "tracerisk-"
_ENDING = ".dist-info"


def installed_version(home: str, folders: "Iterable[str]") -> str:
    """Return the version of the distribution in `folders` whose package is in the folder `home`.

    Its metadata are in a folder `tracerisk-VERSION.dist-info`, beside the package or, in an
    editable installation, where there is none. Metadata beside another package are those of that.
    """
    for folder in folders:
        try:
            names = os.listdir(folder or ".")
        except OSError:
            continue  # not there, or no folder
        if "tracerisk" in names and os.path.realpath(folder) != os.path.realpath(home):
            continue
        for name in names:
            if name.startswith(_NAME) and name.endswith(_ENDING):
                return name[len(_NAME) : -len(_ENDING)]
    return UNKNOWN


__version__ = installed_version(os.path.dirname(__file__).rsplit(os.sep, 2)[0], sys.path)
