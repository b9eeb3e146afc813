"""What to write instead of names and calls that newer Pythons and libraries have removed.

Controllers were written for the Python and the libraries of their robot. The error stays theirs;
a hint says the line that mends it. Sources: "What's New in Python" 3.0 to 3.13, and the change logs
of PyYAML 6.0, NumPy 1.23 and SciPy 1.6.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

_OF_COLLECTIONS = (
    "Awaitable|ByteString|Callable|Collection|Container|Coroutine|Generator|Hashable|ItemsView"
    "|Iterable|Iterator|KeysView|Mapping|MappingView|MutableMapping|MutableSequence|MutableSet"
    "|Reversible|Sequence|Set|Sized|ValuesView"
)
_NAME_OF_MODULE = re.compile(
    r"module '(?P<module>[\w.]+)' has no attribute '(?P<name>\w+)'"
    r"|cannot import name '(?P<imported>\w+)' from '(?P<source>[\w.]+)'"
)
_INSTEAD = {
    "time.clock": "time.perf_counter()",
    "string.maketrans": "str.maketrans(...)",
    "string.letters": "string.ascii_letters",
    "string.lowercase": "string.ascii_lowercase",
    "string.uppercase": "string.ascii_uppercase",
    "string.join": "separator.join(parts)",
    "string.split": "text.split(separator)",
    "string.replace": "text.replace(old, new)",
    "string.strip": "text.strip()",
    "string.atoi": "int(text)",
    "string.atof": "float(text)",
    "fractions.gcd": "math.gcd",
    "inspect.getargspec": "inspect.getfullargspec",
    "itertools.izip": "zip",
    "itertools.imap": "map",
    "itertools.ifilter": "filter",
    "itertools.izip_longest": "itertools.zip_longest",
    "sys.maxint": "sys.maxsize",
    "os.getcwdu": "os.getcwd()",
    "os.errno": "import errno",
    "base64.encodestring": "base64.encodebytes",
    "base64.decodestring": "base64.decodebytes",
    "cgi.escape": "html.escape",
    "platform.linux_distribution": "platform.freedesktop_os_release()",
    "platform.dist": "platform.freedesktop_os_release()",
    "asyncio.async": "asyncio.ensure_future(...)",
    "asyncio.coroutine": "async def",
    "numpy.asscalar": "array.item()",
}
_PATTERNS: tuple[tuple[str, str], ...] = (
    (
        r"^load(_all)?\(\) missing 1 required positional argument: 'Loader'",
        "write yaml.safe_load(file), or yaml.load(file, Loader=yaml.FullLoader): PyYAML 6 needs a "
        "loader",
    ),
    (r"'Thread' object has no attribute 'isAlive'", "write is_alive()"),
    (r"object has no attribute 'getchildren'", "write list(element)"),
    (r"object has no attribute 'getiterator'", "write element.iter()"),
    (r"'array\.array' object has no attribute 'tostring'", "write tobytes()"),
    (r"'array\.array' object has no attribute 'fromstring'", "write frombytes(data)"),
    (r"Rotation'? (object )?has no attribute 'as_dcm'", "write as_matrix(): SciPy renamed it"),
    (
        r"Rotation'? (object )?has no attribute 'from_dcm'",
        "write Rotation.from_matrix(matrix): SciPy renamed it",
    ),
    (
        r"'dict_(keys|values|items)' object is not subscriptable",
        "write list(...)[index]: in Python 3 it is a view and no list",
    ),
    (
        r"'(map|filter|zip)' object is not subscriptable",
        "write list(...)[index]: in Python 3 it is an iterator and no list",
    ),
    (
        r"object of type '(map|filter|zip)' has no len\(\)",
        "write len(list(...)): in Python 3 it is an iterator and no list",
    ),
    (
        r"'float' object cannot be interpreted as an integer",
        "write // for a division of whole numbers, or int(...): in Python 3 `/` gives a float",
    ),
    (
        r"^Population must be a sequence",
        "write random.sample(sorted(values), count): Python 3.11 takes no sets",
    ),
    (
        r"__init__\(\) got an unexpected keyword argument 'encoding'$",
        "open the file with the encoding: the functions of json take none since Python 3.9",
    ),
    (
        r"^a bytes-like object is required, not 'str'",
        "write text.encode(): in Python 3 bytes and texts differ",
    ),
    (
        r"^(MoveIt2|MoveIt2Gripper|Gripper(Command|Interface))\.\w+\(\) got an unexpected keyword "
        r"|^'(MoveIt2|MoveIt2Gripper|Gripper(Command|Interface))' object has no attribute ",
        "put the sources of the release of pymoveit2 for which the program was written into the "
        "workspace: without them, the release of the package index runs",
    ),
)
REMOVED_MODULES = {
    "imp": "Python 3.12 has removed it: write importlib in its place",
    "distutils": "Python 3.12 has removed it: install setuptools, which brings it, or write "
    "setuptools or shutil in its place",
    "asyncore": "Python 3.12 has removed it: write asyncio in its place",
    "cgi": "Python 3.13 has removed it: write html or urllib.parse in its place",
    "pipes": "Python 3.13 has removed it: write shlex or subprocess in its place",
    "telnetlib": "Python 3.13 has removed it: install telnetlib3, or write socket in its place",
}
"""Modules that Python has removed, each with what to do."""


def removed_name_hint(error: BaseException) -> str:
    """Return what to write instead of what an error says is not there, empty for nothing known."""
    if not isinstance(error, AttributeError | ImportError | TypeError):
        return ""
    text = str(error)
    matched = _NAME_OF_MODULE.search(text)
    if matched is not None:
        module = matched["module"] or matched["source"]
        name = matched["name"] or matched["imported"]
        if module == "collections" and re.fullmatch(_OF_COLLECTIONS, name):
            return f"write collections.abc.{name}: Python 3.10 has removed it from collections"
        instead = _INSTEAD.get(f"{module}.{name}")
        return f"write {instead} in place of {module}.{name}, which is removed" if instead else ""
    return next(_matching(text), "")


def _matching(text: str) -> Iterator[str]:
    return (hint for pattern, hint in _PATTERNS if re.search(pattern, text))
