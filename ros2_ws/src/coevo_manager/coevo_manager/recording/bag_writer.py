"""Writing rosbag2 bags (MCAP, zstd) of serialised messages."""

import contextlib
import json
import shutil
import tempfile
from pathlib import Path

from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer

from coevo_manager.core.provenance import EPISODE, episode_record
from coevo_manager.recording.mcap_storage import McapStorage
from coevo_manager.recording.message_types import make_typestore, stamp_reader

_INFINITE = QosTime(2147483647, 4294967295)


class _Writer(Writer):
    STORAGE_PLUGINS = {StoragePlugin.MCAP: McapStorage}  # noqa: RUF012  as its parent has it


class BagWriter:
    """A bag that appears under its name when it is complete, and not before.

    Messages are filed under simulated time: that of their stamp, or, where they have none, that of
    the message before. It is used as a context manager; an exception leaves no bag.

    Parameters
    ----------
    path : pathlib.Path
        Folder of the bag.

    Raises
    ------
    ValueError
        Something of that name exists.
    RuntimeError
        The bag cannot be written whole.
    """

    def __init__(self, path):
        self._path = Path(path)
        if self._path.exists():
            raise ValueError(f'{self._path} exists, expected the name of a new bag')
        self._types = make_typestore()
        self._connections = {}
        self._now = 0

    def __enter__(self):
        with self._writing():
            self._partial = Path(
                tempfile.mkdtemp(
                    prefix=f'.{self._path.name}.', suffix='.partial', dir=self._path.parent
                )
            )
            self._writer = _Writer(
                self._partial / self._path.name, version=9, storage_plugin=StoragePlugin.MCAP
            )
            self._writer.open()
        return self

    def __exit__(self, error, *_):
        try:
            if error is None:
                with self._writing():
                    self._writer.close()
                    self._writer.path.replace(self._path)
        finally:
            self._writer.abort()
            shutil.rmtree(self._partial, ignore_errors=True)

    @contextlib.contextmanager
    def _writing(self):
        try:
            yield
        except OSError as error:
            raise RuntimeError(f'{self._path} cannot be written: {error.strerror}') from None

    def attach_record(self, environment, players):
        """Keep in what an episode was played, and by whom, as `episode_record` takes them."""
        record = episode_record(environment, players)
        self.attach(EPISODE, 'application/json', json.dumps(record).encode())

    def attach(self, name, media_type, data):
        """Add a file (bytes) to the bag."""
        with self._writing():
            self._writer.storage.attach(name, media_type, data)

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
        with self._writing():
            connection = self._writer.add_connection(
                topic, type_name, typestore=self._types, offered_qos_profiles=[_bag_qos(qos)]
            )
        self._connections[topic] = connection, stamp_reader(type_name)

    def write(self, topic, data):
        """Append a serialised message (bytes)."""
        connection, stamp = self._connections[topic]
        if stamp is not None:
            self._now = stamp(data) or self._now  # zero means no time in ROS
        with self._writing():
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
