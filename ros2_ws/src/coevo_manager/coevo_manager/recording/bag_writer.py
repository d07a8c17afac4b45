"""Writing rosbag2 bags (MCAP, zstd) of serialised messages."""

import os
import shutil
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

from coevo_manager.recording.message_types import make_typestore, stamp_reader

_INFINITE = QosTime(2147483647, 4294967295)


class BagWriter:
    """A bag that appears under its name when it is complete, and not before.

    Messages are filed under simulated time: that of their stamp, or, where they have none, that of
    the message before.
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
        self._connections[topic] = connection, stamp_reader(type_name)

    def write(self, topic, data):
        """Append a serialised message (bytes)."""
        connection, stamp = self._connections[topic]
        if stamp is not None:
            self._now = stamp(data)
        self._writer.write(connection, self._now, data)


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
