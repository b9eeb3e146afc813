"""`dataclasses` for what every command loads: a class costs next to nothing until it is used.

The library takes longer to import than a small command may take at all, and half a millisecond
more for each class. What stands here takes its place, with the same meaning, for classes with
slots that inherit no fields. `__dataclass_fields__` is what the library itself makes of the class
when somebody asks for it: what knows dataclasses knows these.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from operator import attrgetter, ge, gt, le, lt

_FIELDS, _OPTIONS = "__tracerisk_fields__", "__tracerisk_options__"
_ORDERS = (lt, le, gt, ge)
_OFTEN = 100


class _Missing:
    """Stands for a default that a field has not."""

    def __repr__(self) -> str:
        return "MISSING"


_MISSING: Any = _Missing()


class _Field:
    """A field: its name, and what `dataclasses.field` takes of it."""

    __slots__ = ("compare", "default", "default_factory", "init", "name", "repr")

    def __init__(
        self,
        *,
        default: Any = _MISSING,
        default_factory: Callable[[], Any] = _MISSING,
        init: bool = True,
        repr: bool = True,  # noqa: A002 - the library's name
        compare: bool = True,
    ) -> None:
        self.name = ""
        self.default = default
        self.default_factory = default_factory
        self.init = init
        self.repr = repr
        self.compare = compare

    @property
    def arguments(self) -> dict[str, Any]:
        """What the library's own function is to be called with."""
        given = {"default": self.default, "default_factory": self.default_factory}
        stated = {name: value for name, value in given.items() if value is not _MISSING}
        return {**stated, "init": self.init, "repr": self.repr, "compare": self.compare}

    @property
    def is_plain(self) -> bool:
        """Whether its default, if any, is all that was said of it."""
        plain = self.init and self.repr and self.compare
        return plain and self.default_factory is _MISSING


class _Made:
    """An attribute of a class that is made of the class when it is first looked up."""

    __slots__ = ("make", "name")

    def __init__(self, name: str, make: Callable[[type], Any]) -> None:
        self.name = name
        self.make = make

    def __get__(self, instance: object, owner: type) -> Any:
        of = next(each for each in owner.__mro__ if self.name in vars(each))
        made = self.make(of)
        setattr(of, self.name, made)
        return made.__get__(instance, owner) if hasattr(made, "__get__") else made


def _dataclass(
    *, slots: bool, frozen: bool = False, eq: bool = True, order: bool = False
) -> Callable[[type], type]:
    """Return what makes a dataclass of a class, as the library's decorator of these arguments."""
    if not slots:
        raise TypeError("a class without slots is for the dataclasses of the library")
    options = {"frozen": frozen, "eq": eq, "order": order}
    return lambda kind: _made_of(kind, options)


def _made_of(kind: type, options: Mapping[str, bool]) -> type:
    """Return the class anew, with slots and with the methods that it does not define itself."""
    if any(hasattr(base, "__dataclass_fields__") for base in kind.__bases__):
        raise TypeError(f"{kind.__name__} inherits fields: that is for the library's dataclasses")
    own = dict(kind.__dict__)
    fields = {}
    for name in kind.__annotations__:
        default = own.pop(name, _MISSING)
        fields[name] = default if isinstance(default, _Field) else _Field(default=default)
        fields[name].name = name
    for name in ("__dict__", "__weakref__"):
        own.pop(name, None)
    if own.get("__hash__", _MISSING) is None:  # Python says so of a class with an `__eq__`
        del own["__hash__"]
    body = {
        **_methods(fields, options),
        **own,
        **_MADE,
        _FIELDS: fields,
        _OPTIONS: options,
        "__slots__": tuple(fields),
        "__qualname__": kind.__qualname__,
    }
    made: type = type(kind)(kind.__name__, kind.__bases__, body)
    return made


def _methods(fields: Mapping[str, _Field], options: Mapping[str, bool]) -> dict[str, Any]:
    """Return the methods that `dataclasses` would give to a class."""
    names = tuple(fields)
    compared = _values_of([name for name, each in fields.items() if each.compare])
    shown = tuple(name for name, each in fields.items() if each.repr)
    given = tuple(name for name, each in fields.items() if each.init)
    methods: dict[str, Any] = {"__repr__": _repr_of(shown), "__match_args__": given}
    if options["eq"]:

        def equal(self: object, other: object) -> Any:
            if other.__class__ is self.__class__:
                return compared(self) == compared(other)
            return NotImplemented

        methods["__eq__"] = equal
        methods["__hash__"] = (lambda self: hash(compared(self))) if options["frozen"] else None
    if options["order"]:
        methods |= {f"__{each.__name__}__": _order_of(compared, each) for each in _ORDERS}
    if options["frozen"]:
        methods |= _methods_of_frozen(names, given)
    return methods


def _values_of(names: list[str]) -> Callable[[object], tuple[Any, ...]]:
    """Return what gives the values of some attributes as a tuple."""
    if len(names) > 1:
        return attrgetter(*names)
    return lambda value: tuple(getattr(value, name) for name in names)


def _repr_of(names: tuple[str, ...]) -> Callable[[object], str]:
    def shown(self: object) -> str:
        values = ", ".join(f"{name}={getattr(self, name)!r}" for name in names)
        return f"{self.__class__.__qualname__}({values})"

    return shown


def _order_of(
    compared: Callable[[object], tuple[Any, ...]], compare: Callable[[Any, Any], Any]
) -> Callable[[object, object], Any]:
    def ordered(self: object, other: object) -> Any:
        if other.__class__ is self.__class__:
            return compare(compared(self), compared(other))
        return NotImplemented

    return ordered


def _methods_of_frozen(names: tuple[str, ...], given: tuple[str, ...]) -> dict[str, Any]:
    """Return what keeps values as they were made, and lets them be copied and pickled.

    `given` are the names that a call gives, which mark the class itself, not one derived from it.
    """

    def refuse(self: object, name: str, doing: str) -> None:
        if name in names or vars(type(self)).get("__match_args__") is given:
            from dataclasses import FrozenInstanceError

            raise FrozenInstanceError(f"cannot {doing} field {name!r}")

    def set_attribute(self: Any, name: str, value: Any) -> None:
        refuse(self, name, "assign to")
        object.__setattr__(self, name, value)

    def delete_attribute(self: Any, name: str) -> None:
        refuse(self, name, "delete")
        object.__delattr__(self, name)

    def state(self: object) -> list[Any]:
        return [getattr(self, name) for name in names]

    def set_state(self: object, values: list[Any]) -> None:
        for name, value in zip(names, values, strict=True):
            object.__setattr__(self, name, value)

    return {
        "__setattr__": set_attribute,
        "__delattr__": delete_attribute,
        "__getstate__": state,
        "__setstate__": set_state,
    }


def _init_of(kind: type) -> Callable[..., None]:
    """Return the `__init__` of a class, which is compiled once it has been called often.

    To compile it takes as long as it saves in a hundred calls.
    """
    every: Mapping[str, _Field] = getattr(kind, _FIELDS)
    fields = {name: each for name, each in every.items() if each.init}
    puts = [vars(kind)[name].__set__ for name in fields]
    defaults = tuple(each.default for each in fields.values())
    required = sum(each.default is _MISSING for each in fields.values())
    has_factories = any(each.default_factory is not _MISSING for each in fields.values())
    constants = [
        (vars(kind)[name].__set__, each.default)
        for name, each in every.items()
        if not each.init and each.default is not _MISSING
    ]
    has_more = hasattr(kind, "__post_init__")
    count = len(puts)
    calls = 0

    def init(self: Any, /, *values: Any, **named: Any) -> None:
        nonlocal calls
        calls += 1
        if calls == _OFTEN:
            setattr(kind, "__init__", _compiled_init(kind))  # noqa: B010 - of any class
        if named or has_factories or len(values) > count:
            values = _arguments(self, fields, values, named)
        elif len(values) < count:
            if len(values) < required:
                _arguments(self, fields, values, named)  # it says what is missing
            values += defaults[len(values) :]
        for put, value in zip(puts, values, strict=False):
            put(self, value)
        for put, value in constants:
            put(self, value)
        if has_more:
            self.__post_init__()

    return init


def _compiled_init(kind: type) -> Callable[..., None]:
    """Return the `__init__` of a class as a function with the parameters that its fields are."""
    known: dict[str, Any] = {"_missing": _MISSING}
    parameters, lines = ["self"], []
    fields: Mapping[str, _Field] = getattr(kind, _FIELDS)
    for name, each in fields.items():
        parameter, value = name, name
        known[f"_put_{name}"] = vars(kind)[name].__set__
        if each.default is not _MISSING:
            known[f"_default_{name}"] = each.default
            parameter = f"{name}=_default_{name}"
        elif each.default_factory is not _MISSING:
            known[f"_make_{name}"] = each.default_factory
            parameter = f"{name}=_missing"
            value = f"_make_{name}() if {name} is _missing else {name}"
        if each.init:
            parameters.append(parameter)
        elif each.default is _MISSING:
            continue
        else:
            value = f"_default_{name}"
        lines.append(f"_put_{name}(self, {value})")
    if hasattr(kind, "__post_init__"):
        lines.append("self.__post_init__()")
    body = "\n ".join(lines or ["pass"])
    exec(f"def __init__({', '.join(parameters)}):\n {body}", known)
    made: Callable[..., None] = known["__init__"]
    made.__qualname__ = f"{kind.__qualname__}.__init__"
    return made


def _arguments(
    of: object, fields: Mapping[str, _Field], values: tuple[Any, ...], named: Mapping[str, Any]
) -> tuple[Any, ...]:
    """Return a value for each field from the arguments of a call; raises TypeError as Python."""
    name = f"{type(of).__name__}()"
    if len(values) > len(fields):
        raise TypeError(f"{name} takes {len(fields)} arguments but {len(values)} were given")
    given = dict(zip(fields, values, strict=False))
    for key, value in named.items():
        if key not in fields or key in given:
            what = "multiple values for" if key in given else "an unexpected keyword"
            raise TypeError(f"{name} got {what} argument '{key}'")
        given[key] = value
    for key, each in fields.items():
        if key not in given:
            if each.default is _MISSING and each.default_factory is _MISSING:
                raise TypeError(f"{name} missing a required argument: '{key}'")
            is_made = each.default is _MISSING
            given[key] = each.default_factory() if is_made else each.default
    return tuple(given[key] for key in fields)


def _of_library(kind: type) -> Any:
    """Return a class with the same fields that the library has made."""
    import dataclasses

    body: dict[str, Any] = {
        name: each.default
        if each.default is not _MISSING and each.is_plain
        else dataclasses.field(**each.arguments)
        for name, each in getattr(kind, _FIELDS).items()
    }
    body |= {"__annotations__": kind.__annotations__, "__module__": kind.__module__}
    options = getattr(kind, _OPTIONS)
    return dataclasses.dataclass(**options)(type(kind.__name__, (), body))


def _is_dataclass(of: Any) -> bool:
    """Return whether something is a dataclass, of here or of the library, or a value of one."""
    return hasattr(of, _FIELDS) or hasattr(of, "__dataclass_fields__")


def _signature_of(kind: type) -> Any:
    from inspect import signature

    return signature(_of_library(kind))


_MADE: Mapping[str, _Made] = {
    name: _Made(name, make)
    for name, make in {
        "__init__": _init_of,
        "__signature__": _signature_of,
        "__dataclass_fields__": lambda kind: _of_library(kind).__dataclass_fields__,
        "__dataclass_params__": lambda kind: _of_library(kind).__dataclass_params__,
    }.items()
}


def _fields(of: Any) -> tuple[Any, ...]:
    """Return the fields of a class or a value of it."""
    found = getattr(of, _FIELDS, None)
    if found is None:
        from dataclasses import fields

        return fields(of)
    return tuple(found.values())


def _replace(value: Any, /, **changes: Any) -> Any:
    """Return a value like another, some fields but changed."""
    found: Mapping[str, _Field] | None = getattr(value, _FIELDS, None)
    if found is None:
        from dataclasses import replace

        return replace(value, **changes)
    given = [name for name, each in found.items() if each.init and name not in changes]
    return value.__class__(**{name: getattr(value, name) for name in given}, **changes)


def _asdict(value: Any) -> Any:
    """Return the values of all fields by their names, and so on within them."""
    if _is_dataclass(value) and not isinstance(value, type):
        return {each.name: _asdict(getattr(value, each.name)) for each in _fields(value)}
    if isinstance(value, (list, tuple)):
        return type(value)(map(_asdict, value))
    if isinstance(value, dict):
        return {_asdict(name): _asdict(each) for name, each in value.items()}
    return value


def picked(value: Any, *names: str) -> dict[str, Any]:
    """Return some fields or properties of a value as plain data, by their names."""
    return {name: _asdict(getattr(value, name)) for name in names}


TYPE_CHECKING = False
if TYPE_CHECKING:
    from dataclasses import MISSING as MISSING
    from dataclasses import asdict as asdict
    from dataclasses import dataclass as dataclass
    from dataclasses import field as field
    from dataclasses import fields as fields
    from dataclasses import is_dataclass as is_dataclass
    from dataclasses import replace as replace
    from typing import Any
else:
    MISSING, asdict, dataclass, field = _MISSING, _asdict, _dataclass, _Field
    fields, is_dataclass, replace = _fields, _is_dataclass, _replace
