"""Message types by name, for topics that are handled as bytes."""

import struct
from importlib import import_module
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

OWN_PACKAGES = ('marxbot_msgs', 'coevo_msgs')
"""Packages of this workspace whose messages a bag may hold."""


def message_class(type_name):
    """Return the class of a message type such as ``sensor_msgs/msg/LaserScan``.

    Raises
    ------
    ValueError
        It is not installed.
    """
    package, _, name = type_name.split('/')
    try:
        return getattr(import_module(f'{package}.msg'), name)
    except (ImportError, AttributeError):
        raise ValueError(f'message type {type_name} is not installed') from None


_STAMP = struct.Struct('<iI')
_ENCAPSULATION = 4
"""Bytes before the first field of a serialised message."""

_SEQUENCE_LENGTH = 4


def stamp_reader(type_name):
    """Return a function that reads the stamp of a serialised message, or None.

    Types that bear simulated time have a stamp: those that begin with it or with a header, or with
    a sequence (of one element at least) of what begins so. Diagnostics tell of real time.

    Returns
    -------
    callable
        From bytes to ns.
    """
    package, _, _ = type_name.split('/')
    offset = None if package == 'diagnostic_msgs' else _stamp_offset(message_class(type_name))
    if offset is None:
        return None

    def read(data):
        seconds, nanoseconds = _STAMP.unpack_from(data, offset)
        return seconds * 10**9 + nanoseconds

    return read


def _stamp_offset(message_type, offset=_ENCAPSULATION):
    first = next(iter(message_type.get_fields_and_field_types().values()), '')
    if first in ('std_msgs/Header', 'builtin_interfaces/Time'):
        return offset
    if first.startswith('sequence<') and '/' in first:
        package, name = first.removeprefix('sequence<').rstrip('>').split('/')
        return _stamp_offset(message_class(f'{package}/msg/{name}'), offset + _SEQUENCE_LENGTH)
    return None


def make_typestore():
    """Return the types of ROS 2 Jazzy and of this workspace as rosbags knows them."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for package in OWN_PACKAGES:
        for path in sorted(Path(get_package_share_directory(package), 'msg').glob('*.msg')):
            store.register(
                get_types_from_msg(path.read_text(encoding='utf-8'), f'{package}/msg/{path.stem}')
            )
    return store
