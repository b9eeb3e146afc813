# ruff: noqa: F401 - what is imported here is what the module gives
"""Names of ROS 1, as in `rosgraph.names`, and those of resources of packages."""

from rosgraph.names import (
    ANYTYPE,
    GLOBALNS,
    PRIV_NAME,
    REMAP,
    SEP,
    canonicalize_name,
    get_ros_namespace,
    is_global,
    is_legal_base_name,
    is_legal_name,
    is_private,
    load_mappings,
    make_global_ns,
    namespace,
    ns_join,
    resolve_name,
    script_resolve_name,
)

from tracerisk.ros.imports.exported import exported as _exported

PRN_SEPARATOR = TYPE_SEPARATOR = "/"


def package_resource_name(name: str) -> tuple[str, str]:
    """Return the package and the name of `std_msgs/String`; the package may be empty.

    Raises:
        ValueError: there are more parts.
    """
    package, separator, own = name.partition(PRN_SEPARATOR)
    if PRN_SEPARATOR in own:
        raise ValueError(f"invalid name [{name}]")
    return (package, own) if separator else ("", name)


__all__ = _exported(globals())
