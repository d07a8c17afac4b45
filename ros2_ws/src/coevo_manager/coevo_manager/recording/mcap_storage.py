"""MCAP files with checksums and attachments, as storage of rosbag2 bags."""

from contextlib import suppress

from mcap.writer import CompressionType, Writer


class McapStorage:
    """What `rosbags.rosbag2.Writer` writes a bag's messages to.

    Each chunk and the whole data section get their checksum, which rosbags' own storage leaves
    out.

    Parameters
    ----------
    path : pathlib.Path
        Folder of the bag.
    compression : rosbags.rosbag2.CompressionMode
        Not looked at: chunks are compressed with zstd.
    """

    def __init__(self, path, compression):
        self.path = path / f'{path.name}.mcap'
        self._file = self.path.open('xb')
        self._writer = Writer(
            self._file, compression=CompressionType.ZSTD, enable_crcs=True, enable_data_crcs=True
        )
        self._writer.start(profile='ros2', library='red-queen')
        self._schemas = {}
        self._channels = {}

    def attach(self, name, media_type, data):
        """Add a file (bytes) to the bag."""
        self._writer.add_attachment(
            create_time=0, log_time=0, name=name, media_type=media_type, data=data
        )

    def add_msgtype(self, connection):
        """Add a message type."""
        self._schemas[connection.msgtype] = self._writer.register_schema(
            connection.msgtype, 'ros2msg', connection.msgdef.data.encode()
        )

    def add_connection(self, connection, offered_qos_profiles):
        """Add a topic, with its QoS profiles as text."""
        self._channels[connection.id] = self._writer.register_channel(
            connection.topic,
            connection.ext.serialization_format,
            self._schemas[connection.msgtype],
            {'offered_qos_profiles': offered_qos_profiles},
        )

    def write(self, connection, timestamp, data):
        """Append a serialised message; ns."""
        self._writer.add_message(self._channels[connection.id], timestamp, data, timestamp)

    def close(self, version, metadata):
        """Write the bag's metadata (YAML text) and what is buffered, and close the file."""
        self._writer.add_metadata('rosbag2', {'serialized_metadata': metadata})
        self._writer.finish()
        self._file.close()

    def abort(self):
        """Close the file, whatever is in it."""
        with suppress(OSError):
            self._file.close()
