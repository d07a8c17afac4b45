"""Reading bags of episodes, their checksums first."""

import contextlib

import yaml
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader

from coevo_manager.recording.message_types import make_typestore
from coevo_manager.recording.recorder import GROUND_TRUTH, STATE

_MAX_METADATA = 1 << 20
_MAX_RECORD = 1 << 28
"""Most bytes of metadata.yaml and of one record, far more than any bag of an episode has."""

_MAX_DEPTH = 20


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
        with self._reading():
            _check_metadata(self._path / 'metadata.yaml')
            for path in sorted(self._path.glob('*.mcap')):
                _check_sums(path)
            self._reader = self._stack.enter_context(
                AnyReader([self._path], default_typestore=make_typestore())
            )
        return self

    def __exit__(self, *_):
        self._stack.close()

    @contextlib.contextmanager
    def _reading(self):
        try:
            yield
        except Exception as error:  # whatever damage makes of a bag
            what = f'{type(error).__name__} {error}'.splitlines()[0][:200]
            raise ValueError(f'{self._path} is damaged: {what}') from None

    @property
    def connections(self):
        """The bag's topics, see `rosbags.interfaces.Connection`."""
        return self._reader.connections

    def messages(self):
        """Yield topic, simulated time in s and serialised message, in order."""
        with self._reading():
            for connection, nanoseconds, data in self._reader.messages():
                yield connection.topic, nanoseconds * 1e-9, bytes(data)

    def attachment(self, name):
        """Return the content of an attached file, bytes; None if there is none."""
        with self._reading():
            for path in sorted(self._path.glob('*.mcap')):
                with path.open('rb') as file:
                    for attachment in make_reader(file, validate_crcs=True).iter_attachments():
                        if attachment.name == name:
                            return attachment.data
        return None

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
        with self._reading():
            topics = [c for c in self._reader.connections if c.topic in (*GROUND_TRUTH, STATE)]
            for connection, _, data in self._reader.messages(connections=topics):
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


def _check_metadata(path):
    """Refuse YAML that a reader could choke on."""
    if path.stat().st_size > _MAX_METADATA:
        raise ValueError(f'metadata.yaml has more than {_MAX_METADATA} bytes')
    depth = 0
    for event in yaml.parse(path.read_text(encoding='utf-8'), Loader=yaml.SafeLoader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > _MAX_DEPTH or isinstance(event, yaml.AliasEvent):
            raise ValueError(f'metadata.yaml has aliases or is nested more than {_MAX_DEPTH} deep')


def _check_sums(path):
    with path.open('rb') as file:
        for _ in StreamReader(file, validate_crcs=True, record_size_limit=_MAX_RECORD).records:
            pass
