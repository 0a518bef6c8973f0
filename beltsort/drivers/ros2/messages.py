"""Classes of ROS 2 interfaces by name, and messages from plain values.

Imported in the node's process only; needs the standard library and the packages of the messages.
"""

import re
from collections.abc import Mapping
from importlib import import_module
from typing import Any

SEQUENCE = re.compile(r"(?:sequence<)?([\w/]+)")
"""The type of a field, or of its items, as rosidl names it: "sequence<std_msgs/Header>", "float64[9]"."""


def interface_class(kind: str, group: str = "msg") -> Any:
    """Return the class of an interface, as "std_msgs/Int32", of a group: "msg", "srv" or "action"."""
    package, *_, name = kind.split("/")
    return getattr(import_module(f"{package}.{group}"), name)


def filled(message: Any, values: Mapping[str, Any]) -> Any:
    """Set fields of a message, dictionaries being messages, and return it."""
    kinds = message.get_fields_and_field_types()
    for name, value in values.items():
        if isinstance(value, Mapping):
            filled(getattr(message, name), value)
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            item = SEQUENCE.match(kinds[name])
            assert item is not None
            setattr(message, name, [filled(interface_class(item[1])(), each) for each in value])
        elif kinds[name] == "octet":
            setattr(message, name, bytes([value]))
        else:
            setattr(message, name, value)
    return message
