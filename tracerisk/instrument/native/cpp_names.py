"""What a C++ symbol is called in its source, as the reader of C and C++ sources calls it.

A source names a function by its scopes alone: `Cell::swing` is every overload and every instance
of a template. A lambda belongs to the function that holds it.
"""

from __future__ import annotations

import re

from tracerisk.common.function_ref import QualifiedName

_ALIASES = (
    (
        re.compile(r"std::(?:__cxx11|__1)::basic_string<char(?:, std::[^<>]*<char> ?)*>"),
        "std::string",
    ),
    (re.compile(r"\[abi:\w+\]"), ""),
    (re.compile(r"(?: \[clone [^\]]*\]| \(\.[\w.]+\))+$"), ""),
    (re.compile(r"(?:\(anonymous namespace\)|\{anonymous\})::"), ""),
)
_SIGNS = re.compile(
    r'operator(?:\(\)|\[\]|""\s*\w+|<=>|->\*?|(?:<<|>>|[-+*/%^&|=!<>])=|<<|>>|&&|\|\||\+\+|--'
    r"|[-+*/%^&|~!=<>,]| ?(?:new|delete)(?:\[\])?| co_await)"
)
_CONVERSION = re.compile(r"operator (?=[\w:(])")
_LAMBDA = re.compile(r"(?:::)?(?:\{lambda|<lambda|\$_\d)")
_PARAMETERS = re.compile(r"\([^()]*\)")
_QUALIFIERS = re.compile(r"(?: const\b| volatile\b| noexcept\b| ?&{1,2})*")
_CLOSING = {"(": ")", "<": ">", "{": "}", "[": "]"}
_LIBRARIES = frozenset(
    {
        *(
            "std",
            "boost",
            "__gnu_cxx",
            "__cxxabiv1",
            "ros",
            "actionlib",
            "class_loader",
            "pluginlib",
            "moveit",
        ),
        *("nodelet", "rclcpp", "rclcpp_action", "rclcpp_lifecycle", "rclcpp_components"),
    }
)
_FIRST_SCOPE = re.compile(r"_Z+(?:N[KVrRO]*)?(?:St|S[absiod]|(?<=[NKVrRO])(?P<length>\d+))")
"""`std` is `St` in a mangled name, and some of its classes have a letter; others have a length."""
_BY_COMPILER = ("__", "_start", "_init", "_fini", "_GLOBAL_")


def source_name(symbol: str) -> QualifiedName:
    """Return the name that the source gives the function of a demangled symbol.

    Parameters, results, template arguments, unnamed namespaces and the marks of a compiler's copies
    are left out.
    """
    for pattern, short in _ALIASES:
        symbol = pattern.sub(short, symbol)
    parts: list[str] = []
    at, begin = 0, 0
    while at < len(symbol):
        sign = symbol[at]
        if at == begin and (operator := _SIGNS.match(symbol, at)):
            parts.append(re.sub(r"\s", "", operator[0]))
            at = _after_parameters(symbol, operator.end())
            begin = -1
        elif at == begin and (operator := _CONVERSION.match(symbol, at)):
            at = _to(symbol, operator.end(), "(")
            parts.append("operator_" + _without_arguments(symbol[operator.end() : at]))
            at = _after_parameters(symbol, at)
            begin = -1
        elif at == begin and (sign == "{" or symbol.startswith("$_", at)):
            break  # a lambda, or another function without a name
        elif symbol.startswith("::", at):
            if begin >= 0:
                parts.append(_without_arguments(symbol[begin:at]))
            at += 2
            begin = at
        elif sign == "(" and at > begin >= 0:
            parts.append(_without_arguments(symbol[begin:at]))
            at = _after_parameters(symbol, at)
            begin = -1
        elif sign == " " and begin >= 0:
            parts, at, begin = [], at + 1, at + 1  # what stood before is the result
        elif begin < 0:
            break
        elif sign in _CLOSING:
            at = _closed(symbol, at)
        else:
            at += 1
    else:
        if 0 <= begin < at:
            parts.append(_without_arguments(symbol[begin:at]))
    return QualifiedName("::".join(part for part in parts if part))


def is_lambda(symbol: str) -> bool:
    """Whether a demangled symbol is a lambda, and none is merely an argument or a parameter."""
    text, before = _without_arguments(symbol), ""
    while text != before:
        text, before = _PARAMETERS.sub("", text), text
    return _LAMBDA.search(text) is not None


def lambda_owner(symbol: str) -> QualifiedName | None:
    """Return the function that holds the first lambda that a demangled symbol mentions."""
    symbol = re.sub(r"\) (?:const|volatile)::", ")::", symbol)
    at = _LAMBDA.search(symbol)
    if at is None:
        return None
    begin, depth = at.start(), 0
    while begin > 0:
        sign = symbol[begin - 1]
        if depth == 0 and sign in "(<{, ":
            break
        depth += (sign in ")>}") - (sign in "(<{")
        begin -= 1
    return source_name(symbol[begin : at.start()]) or None


def is_of_library(name: str) -> bool:
    """Whether a name in a source is that of a library of ROS or C++, or made by a compiler."""
    return name.partition("::")[0] in _LIBRARIES or name.startswith(_BY_COMPILER)


def is_mangled_of_library(symbol: str) -> bool:
    """Whether a mangled name surely is that of a library of ROS or C++, by its first scope.

    A node on rclcpp has tens of thousands of them: they are not worth demangling.
    """
    match = _FIRST_SCOPE.match(symbol)
    if match is None:
        return False
    length = match["length"]
    return length is None or symbol[match.end() :][: int(length)] in _LIBRARIES


def _after_parameters(symbol: str, at: int) -> int:
    """Return where a function's name, arguments of its template and parameters end."""
    while at < len(symbol) and symbol[at] in "<( ":
        if symbol[at] == " " and symbol[at : at + 2] not in (" <", " ("):
            break
        at = at + 1 if symbol[at] == " " else _closed(symbol, at)
    qualifiers = _QUALIFIERS.match(symbol, at)
    return at if qualifiers is None else qualifiers.end()


def _to(symbol: str, at: int, sign: str) -> int:
    """Return where a sign stands outside all brackets; the end if nowhere."""
    while at < len(symbol) and symbol[at] != sign:
        at = _closed(symbol, at) if symbol[at] in _CLOSING else at + 1
    return at


def _closed(symbol: str, at: int) -> int:
    """Return the place after the bracket that closes the one at a place."""
    closing = [_CLOSING[symbol[at]]]
    at += 1
    while at < len(symbol) and closing:
        if (operator := _SIGNS.match(symbol, at)) and not symbol[at - 1].isalnum():
            at = operator.end()
            continue
        sign = symbol[at]
        if sign == closing[-1]:
            closing.pop()
        elif sign in _CLOSING:
            closing.append(_CLOSING[sign])
        at += 2 if symbol.startswith("->", at) else 1
    return at


def _without_arguments(name: str) -> str:
    """Return a name without the arguments of its template, and without spaces."""
    at = name.find("<")
    while at >= 0:
        name = name[:at] + name[_closed(name, at) :]
        at = name.find("<")
    return re.sub(r"\s", "", name)
