"""Message types by name, for topics that are handled as bytes."""

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


def has_header(message_type):
    """Return whether a message type begins with a std_msgs/Header."""
    fields = list(message_type.get_fields_and_field_types().items())
    return bool(fields) and fields[0][1] == 'std_msgs/Header'


def make_typestore():
    """Return the types of ROS 2 Jazzy and of this workspace as rosbags knows them."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for package in OWN_PACKAGES:
        for path in sorted(Path(get_package_share_directory(package), 'msg').glob('*.msg')):
            store.register(
                get_types_from_msg(path.read_text(encoding='utf-8'), f'{package}/msg/{path.stem}')
            )
    return store
