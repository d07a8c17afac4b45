"""Reading bags of episodes, their checksums first."""

import contextlib

from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader

from coevo_manager.core.documents import read_document
from coevo_manager.core.provenance import EPISODE
from coevo_manager.core.species import SPECIES
from coevo_manager.recording.message_types import make_typestore
from coevo_manager.recording.recorder import GROUND_TRUTH, STATE
from neuro_controller.core.reading import opened, parse_json, reading

_RECORD_LIMIT = 2**28
"""Bytes that a record may have, far more than those of an episode."""


class BagReader:
    """An open bag of an episode; to be used as a context manager.

    Raises
    ------
    ValueError
        There is no bag, or it is damaged: one sentence.
    """

    def __init__(self, path):
        self._path = path
        self._stack = contextlib.ExitStack()

    def __enter__(self):
        if not self._path.is_dir():
            raise ValueError(f'{self._path} is not the folder of a bag')
        if not (self._path / 'metadata.yaml').is_file():
            raise ValueError(f'{self._path} is not a bag: it has no metadata.yaml')
        with reading(self._path):
            _check_places(self._path)
            read_document(self._path / 'metadata.yaml')  # a file that asks for too much is refused
            for path in sorted(self._path.glob('*.mcap')):
                _check_sums(path)
            self._reader = self._stack.enter_context(
                AnyReader([self._path], default_typestore=make_typestore())
            )
        return self

    def __exit__(self, *_):
        self._stack.close()

    @property
    def connections(self):
        """The bag's topics, see `rosbags.interfaces.Connection`."""
        return self._reader.connections

    def messages(self):
        """Yield topic, simulated time in s and serialised message, in order."""
        with reading(self._path):
            for connection, nanoseconds, data in self._reader.messages():
                yield connection.topic, nanoseconds * 1e-9, bytes(data)

    def attachment(self, name):
        """Return the content of an attached file, bytes; None if there is none."""
        with reading(self._path):
            for path in sorted(self._path.glob('*.mcap')):
                with opened(path) as file:
                    for attachment in make_reader(file, validate_crcs=True).iter_attachments():
                        if attachment.name == name:
                            return attachment.data
        return None

    def descriptions(self):
        """Return a line about each champion that plays, as far as the bag tells of them."""
        content = self.attachment(EPISODE)
        if content is None:
            return []
        with reading(self._path):
            record = parse_json(content.decode())
            return [str(record[species]['description']) for species in SPECIES]

    def episode(self):
        """Return the poses of predator and prey and the last state of the arena.

        Returns
        -------
        poses : list of two lists
            Of each robot x and y in m and z and w of its quaternion, for each tick.
        state : marxbot_msgs/ArenaState

        Raises
        ------
        ValueError
            The bag holds no episode.
        """
        poses = {topic: [] for topic in GROUND_TRUTH}
        state = None
        with reading(self._path):
            for connection, _, data in self._reader.messages():
                if connection.topic not in (*GROUND_TRUTH, STATE):
                    continue
                message = self._reader.deserialize(data, connection.msgtype)
                if connection.topic == STATE:
                    state = message
                else:
                    place, turn = message.pose.pose.position, message.pose.pose.orientation
                    poses[connection.topic].append((place.x, place.y, turn.z, turn.w))
        if state is None or not all(poses.values()):
            raise ValueError(
                f'{self._path} holds no episode: {STATE} or {", ".join(GROUND_TRUTH)} is empty'
            )
        return list(poses.values()), state


def _check_places(folder):
    """Refuse pipes and devices: rosbags opens what the metadata name, and would wait for them."""
    for path in sorted(folder.iterdir()):
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise ValueError(f'{path.name} is not a regular file')


def _check_sums(path):
    with opened(path) as file:
        for _ in StreamReader(file, validate_crcs=True, record_size_limit=_RECORD_LIMIT).records:
            pass
