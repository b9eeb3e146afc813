"""What Python 2's library has under other names, or does in another way."""

from __future__ import annotations

import importlib
import types
from collections.abc import Callable, Mapping
from itertools import filterfalse, zip_longest
from typing import Any

from tracerisk.instrument.python_2.operators import divided, to_bytes, to_text, translated
from tracerisk.instrument.source.python_2 import RENAMED


def _of(module: str, name: str) -> Any:
    return getattr(importlib.import_module(module), name)


def _on_bytes(module: str, name: str) -> Callable[..., Any]:
    """Return a function that takes and returns bytes as one that takes and returns texts."""

    def function(*arguments: Any, **named: Any) -> Any:
        result = _of(module, name)(*map(to_bytes, arguments), **named)
        if isinstance(result, tuple):
            return tuple(map(to_text, result))
        return to_text(result)

    return function


def _floating(name: str) -> Callable[[float], float]:
    return lambda value: float(_of("math", name)(value))


def _math() -> dict[str, Any]:
    return {"floor": _floating("floor"), "ceil": _floating("ceil")}


def _string() -> dict[str, Any]:
    string = importlib.import_module("string")
    methods = (
        *("capitalize", "count", "expandtabs", "find", "index", "lower", "lstrip", "replace"),
        *("rfind", "rindex", "rstrip", "split", "rsplit", "strip", "swapcase", "upper", "zfill"),
        *("center", "ljust", "rjust"),
    )

    def method(name: str) -> Callable[..., Any]:
        return lambda text, *arguments: getattr(text, name)(*arguments)

    return {
        **{name: method(name) for name in methods},
        "atof": float,
        "atoi": int,
        "atol": int,
        "join": lambda words, separator=" ": separator.join(words),
        "joinfields": lambda words, separator=" ": separator.join(words),
        "letters": string.ascii_lowercase + string.ascii_uppercase,
        "lowercase": string.ascii_lowercase,
        "maketrans": str.maketrans,
        "translate": translated,
        "uppercase": string.ascii_uppercase,
    }


def _itertools() -> dict[str, Any]:
    return {
        "ifilter": filter,
        "ifilterfalse": filterfalse,
        "imap": map,
        "izip": zip,
        "izip_longest": zip_longest,
    }


def _os() -> dict[str, Any]:
    return {"getcwdu": lambda: _of("os", "getcwd")(), "errno": importlib.import_module("errno")}


def _types() -> dict[str, Any]:
    return {
        "BooleanType": bool,
        "ClassType": type,
        "ComplexType": complex,
        "DictType": dict,
        "DictionaryType": dict,
        "FileType": importlib.import_module("io").IOBase,
        "FloatType": float,
        "InstanceType": object,
        "IntType": int,
        "ListType": list,
        "LongType": int,
        "NoneType": type(None),
        "ObjectType": object,
        "SliceType": slice,
        "StringType": str,
        "StringTypes": (str,),
        "TupleType": tuple,
        "TypeType": type,
        "UnboundMethodType": types.FunctionType,
        "UnicodeType": str,
        "XRangeType": range,
    }


def _operator() -> dict[str, Any]:
    return {
        "div": divided,
        "isCallable": callable,
        "isSequenceType": lambda value: hasattr(value, "__getitem__"),
        "isMappingType": lambda value: hasattr(value, "keys"),
        "sequenceIncludes": lambda values, value: value in values,
    }


def _subprocess() -> dict[str, Any]:
    def popen(*arguments: Any, **options: Any) -> Any:
        if not {"encoding", "text", "errors"} & options.keys() and len(arguments) < 12:
            options |= {"encoding": "utf-8", "errors": "surrogateescape"}
        return _of("subprocess", "Popen")(*arguments, **options)

    def check_output(*arguments: Any, **options: Any) -> Any:
        return to_text(_of("subprocess", "check_output")(*arguments, **options))

    return {"Popen": popen, "check_output": check_output}


def _commands() -> dict[str, Any]:
    def status_and_output(command: str) -> Any:
        return _of("subprocess", "getstatusoutput")(command)

    return {"getstatusoutput": status_and_output}


def _struct() -> dict[str, Any]:
    def unpack_from(layout: Any, data: Any, offset: int = 0) -> Any:
        return tuple(map(to_text, _of("struct", "unpack_from")(layout, to_bytes(data), offset)))

    return {
        "pack": _on_bytes("struct", "pack"),
        "unpack": _on_bytes("struct", "unpack"),
        "unpack_from": unpack_from,
    }


def _all_on_bytes(module: str, *names: str) -> Callable[[], dict[str, Any]]:
    return lambda: {name: _on_bytes(module, name) for name in names}


def _base64() -> dict[str, Any]:
    names = ("b64encode", "b64decode", "b16encode", "b16decode", "urlsafe_b64encode")
    return {
        **{name: _on_bytes("base64", name) for name in (*names, "urlsafe_b64decode")},
        "encodestring": _on_bytes("base64", "encodebytes"),
        "decodestring": _on_bytes("base64", "decodebytes"),
    }


class _Digest:
    """A digest that is fed with texts."""

    def __init__(self, digest: Any) -> None:
        self._digest = digest

    def __getattr__(self, name: str) -> Any:
        return getattr(self._digest, name)

    def update(self, data: Any) -> None:
        """Add what a text holds."""
        self._digest.update(to_bytes(data))

    def digest(self) -> str:
        """Return the digest, a character for each byte."""
        return str(to_text(self._digest.digest()))


def _hashes() -> dict[str, Any]:
    def made(name: str) -> Callable[..., _Digest]:
        return lambda data="": _Digest(_of("hashlib", name)(to_bytes(data)))

    names = ("md5", "sha1", "sha224", "sha256", "sha384", "sha512")
    return {
        **{name: made(name) for name in names},
        "new": lambda name="md5", data="": _Digest(_of("hashlib", "new")(name, to_bytes(data))),
    }


def _pickle() -> dict[str, Any]:
    def dumps(value: Any, protocol: int = 0) -> Any:
        return to_text(_of("pickle", "dumps")(value, protocol))

    def loads(text: Any) -> Any:
        return _of("pickle", "loads")(to_bytes(text), encoding="latin-1")

    def dump(value: Any, file: Any, protocol: int = 0) -> None:
        file.write(dumps(value, protocol))

    def load(file: Any) -> Any:
        return loads(file.read())

    return {"dump": dump, "dumps": dumps, "load": load, "loads": loads}


def _urllib() -> dict[str, Any]:
    names = ("quote", "quote_plus", "unquote", "unquote_plus", "urlencode")
    return {
        **{name: _of("urllib.parse", name) for name in names},
        **{
            name: _of("urllib.request", name) for name in ("urlopen", "urlretrieve", "url2pathname")
        },
    }


def _urllib2() -> dict[str, Any]:
    return {name: _of("urllib.parse", name) for name in ("quote", "unquote")}


def _time() -> dict[str, Any]:
    return {"clock": lambda: _of("time", "time")()}


def _sets() -> dict[str, Any]:
    return {"Set": set, "ImmutableSet": frozenset}


def _user_dict() -> dict[str, Any]:
    return {"IterableUserDict": _of("collections", "UserDict")}


def _string_io() -> dict[str, Any]:
    return {"StringIO": _of("io", "StringIO")}


def _configparser() -> dict[str, Any]:
    raw, safe = _of("configparser", "RawConfigParser"), _of("configparser", "ConfigParser")
    return {"SafeConfigParser": safe, "ConfigParser": safe, "RawConfigParser": raw}


def _yaml() -> dict[str, Any]:
    def load(stream: Any, Loader: Any = None) -> Any:  # noqa: N803 - as the library calls it
        return _of("yaml", "load")(stream, Loader or _of("yaml", "Loader"))

    def load_all(stream: Any, Loader: Any = None) -> Any:  # noqa: N803
        return _of("yaml", "load_all")(stream, Loader or _of("yaml", "Loader"))

    return {"load": load, "load_all": load_all}


def _exceptions() -> dict[str, Any]:
    return {"StandardError": Exception}


_NAMES: Mapping[str, Callable[[], dict[str, Any]]] = {
    "ConfigParser": _configparser,
    "StringIO": _string_io,
    "UserDict": _user_dict,
    "base64": _base64,
    "binascii": _all_on_bytes(
        "binascii", "hexlify", "unhexlify", "a2b_hex", "b2a_hex", "crc32", "a2b_base64"
    ),
    "cPickle": _pickle,
    "cStringIO": _string_io,
    "commands": _commands,
    "exceptions": _exceptions,
    "hashlib": _hashes,
    "itertools": _itertools,
    "math": _math,
    "md5": _hashes,
    "operator": _operator,
    "os": _os,
    "pickle": _pickle,
    "sets": _sets,
    "sha": _hashes,
    "string": _string,
    "struct": _struct,
    "subprocess": _subprocess,
    "time": _time,
    "types": _types,
    "urllib": _urllib,
    "urllib2": _urllib2,
    "yaml": _yaml,
    "zlib": _all_on_bytes("zlib", "compress", "decompress", "crc32", "adler32"),
}
CHANGED = frozenset(_NAMES) - RENAMED.keys()
"""The modules that Python 3 has by the same name, and without some names or with others."""


def changed_names(module: str) -> dict[str, Any]:
    """Return the names that differ in a module; those that are not there are left out."""
    made = _NAMES.get(module)
    return {} if made is None else made()
