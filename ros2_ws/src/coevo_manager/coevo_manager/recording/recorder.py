"""Receiving every message of an episode."""

from collections import Counter

from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message

from coevo_manager.recording.message_types import message_class
from marxbot_sim.core.simulation import ROBOTS

SENSORS = tuple(
    f'/{robot}/{s}' for robot in ROBOTS for s in ('proximity', 'camera', 'ground', 'traction')
)
COMMANDS = tuple(f'/{robot}/cmd_vel' for robot in ROBOTS)
GROUND_TRUTH = tuple(f'/{robot}/ground_truth' for robot in ROBOTS)
STATE = '/arena/state'
CLOCK = '/clock'

EVERY_TICK = (CLOCK, STATE, *GROUND_TRUTH, *(f'/{robot}/odom' for robot in ROBOTS))
"""Topics with one message for the start of an episode and one after each tick."""

LATCHED = (
    *(f'/{robot}/{topic}' for robot in ROBOTS for topic in ('leds', 'robot_description')),
    '/tf_static',
)
"""Topics with a message that was sent before the episode and holds for it."""

_IGNORED = ('/rosout', '/parameter_events', '/transition_event')
_DEPTH = 5000


class Recorder:
    """Keeps, serialised and in the order of arrival, what some nodes publish.

    Parameters
    ----------
    node : rclpy.node.Node
    prefix : str
        Namespace that is left out of the topics' names.

    Attributes
    ----------
    counts : collections.Counter
        Messages received since `clear`, by topic.
    state : marxbot_msgs.msg.ArenaState or None
        The last one since `clear`.
    """

    def __init__(self, node, prefix):
        self._node = node
        self._prefix = prefix
        self._topics = {}
        self._messages = []
        self.counts = Counter()
        self.state = None

    def subscribe(self, nodes):
        """Subscribe to what the nodes, pairs of name and namespace, publish.

        Returns
        -------
        bool
            Whether every topic that an episode needs is among that.
        """
        for name, namespace in nodes:
            known = self._node.get_node_names_and_namespaces()
            if (name, namespace) not in known:
                return False
            for topic, types in self._node.get_publisher_names_and_types_by_node(name, namespace):
                short = topic.removeprefix(self._prefix)
                if short not in self._topics and not short.endswith(_IGNORED):
                    self._add(topic, short, types[0])
        return self._topics.keys() >= {*SENSORS, *COMMANDS, *EVERY_TICK, *LATCHED}

    def _add(self, topic, short, type_name):
        publishers = self._node.get_publishers_info_by_topic(topic)
        if not publishers:
            return
        offered = publishers[0].qos_profile
        latched = short in LATCHED
        qos = QoSProfile(
            depth=_DEPTH,
            reliability=offered.reliability,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        self._topics[short] = type_name, offered
        self._node.create_subscription(
            message_class(type_name),
            topic,
            lambda data, short=short: self._take(short, data),
            qos,
            raw=True,
        )

    def _take(self, topic, data):
        self._messages.append((topic, data))
        self.counts[topic] += 1
        if topic == STATE:
            self.state = self._decode(topic, data)

    def _decode(self, topic, data):
        return deserialize_message(data, message_class(self._topics[topic][0]))

    def clear(self):
        """Forget everything but latched messages."""
        self._messages = [(topic, data) for topic, data in self._messages if topic in LATCHED]
        self.counts = Counter(topic for topic, _ in self._messages)
        self.state = None

    def begun(self):
        """Return whether the start of an episode has been received."""
        return (
            all(self.counts[topic] for topic in (*EVERY_TICK, *LATCHED)) and self.state.tick == 0
        )

    def complete(self, ticks, commands):
        """Return whether no message of an episode is missing.

        Parameters
        ----------
        ticks : int
            Ticks of the episode.
        commands : bool
            Whether each tick had commands of its own.
        """
        wanted = dict.fromkeys(EVERY_TICK, ticks + 1) | dict.fromkeys(SENSORS, ticks)
        if commands:
            wanted |= dict.fromkeys(COMMANDS, ticks)
        return all(self.counts[topic] >= count for topic, count in wanted.items())

    def decoded(self, *topics):
        """Return the messages of some topics, in order, as pairs of topic and message."""
        return [(t, self._decode(t, data)) for t, data in self._messages if t in topics]

    def last(self, topic):
        """Return the last message of a topic."""
        return self._decode(
            topic, next(data for t, data in reversed(self._messages) if t == topic)
        )

    def save(self, bag):
        """Write everything to a bag."""
        for topic, (type_name, qos) in sorted(self._topics.items()):
            bag.add_topic(topic, type_name, qos)
        for topic, data in self._messages:
            bag.write(topic, data)
