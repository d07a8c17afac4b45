"""Writing rosbag2 bags (MCAP, zstd) of serialised messages."""

import os
import shutil
import struct
from pathlib import Path

from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from coevo_manager.recording.message_types import has_header, make_typestore, message_class

_STAMP = struct.Struct('<iI')
_STAMP_OFFSET = 4
"""A serialised message begins with 4 bytes of encapsulation; a header with its stamp."""

_CLOCK = 'rosgraph_msgs/msg/Clock'
_INFINITE = QosTime(2147483647, 4294967295)


class BagWriter:
    """A bag that appears under its name when it is complete, and not before.

    Messages are filed under simulated time: that of their header, or else, and for diagnostics,
    which tell of real time, that of the last clock message.
    To be used as a context manager; an exception leaves no bag.

    Parameters
    ----------
    path : pathlib.Path
        Folder of the bag.

    Raises
    ------
    ValueError
        Something of that name exists.
    """

    def __init__(self, path):
        self._path = Path(path)
        if self._path.exists():
            raise ValueError(f'{self._path} exists, expected the name of a new bag')
        self._partial = self._path.with_name(f'.{self._path.name}.{os.getpid()}.partial')
        shutil.rmtree(self._partial, ignore_errors=True)
        self._types = make_typestore()
        self._connections = {}
        self._now = 0

    def __enter__(self):
        self._writer = Writer(self._partial, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        self._writer.open()
        return self

    def __exit__(self, error, *_):
        self._writer.close()
        if error is not None:
            shutil.rmtree(self._partial)
            return
        written = self._partial / f'{self._partial.name}.mcap'
        target = self._partial / f'{self._path.name}.mcap'
        written.rename(target)
        metadata = self._partial / 'metadata.yaml'
        metadata.write_text(
            metadata.read_text(encoding='utf-8').replace(written.name, target.name),
            encoding='utf-8',
        )
        self._partial.replace(self._path)

    def add_topic(self, topic, type_name, qos):
        """Add a topic.

        Parameters
        ----------
        topic : str
        type_name : str
            Such as ``sensor_msgs/msg/LaserScan``.
        qos : rclpy.qos.QoSProfile
            What its publisher offers.
        """
        connection = self._writer.add_connection(
            topic, type_name, typestore=self._types, offered_qos_profiles=[_bag_qos(qos)]
        )
        of_real_time = type_name.startswith('diagnostic_msgs/')
        with_header = has_header(message_class(type_name)) and not of_real_time
        stamped = type_name == _CLOCK or with_header
        self._connections[topic] = connection, stamped, type_name == _CLOCK

    def write(self, topic, data):
        """Append a serialised message (bytes)."""
        connection, stamped, is_clock = self._connections[topic]
        time = self._now
        if stamped:
            seconds, nanoseconds = _STAMP.unpack_from(data, _STAMP_OFFSET)
            time = seconds * 10**9 + nanoseconds
        if is_clock:
            self._now = time
        self._writer.write(connection, time, data)


def _bag_qos(qos):
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=qos.depth,
        reliability=QosReliability[qos.reliability.name],
        durability=QosDurability[qos.durability.name],
        deadline=_INFINITE,
        lifespan=_INFINITE,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_INFINITE,
        avoid_ros_namespace_conventions=False,
    )
