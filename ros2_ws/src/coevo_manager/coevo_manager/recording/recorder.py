"""Receiving every message of an episode."""

from collections import Counter, defaultdict

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from coevo_manager.recording.message_types import message_class, stamp_reader
from marxbot_sensors import MARXBOT
from marxbot_sim.core.parameters import ROBOTS, TICK


def _of_robots(*names):
    return tuple(f'/{robot}/{name}' for robot in ROBOTS for name in names)


SENSORS = _of_robots(*(sensor.topic for sensor in MARXBOT.sensors))
COMMANDS = _of_robots('cmd_vel')
NEURONS = _of_robots('neurons')
GROUND_TRUTH = _of_robots('ground_truth')
STATE = '/arena/state'
CLOCK = '/clock'

EVERY_TICK = (
    CLOCK,
    STATE,
    '/arena/markers',
    '/tf',
    *_of_robots('odom', 'ground_truth', 'joint_states'),
)
"""Topics with a message for the start of an episode and one after each tick."""

LATCHED = (*_of_robots('leds', 'robot_description'), '/tf_static')
"""Topics with a message that was sent before the episode and holds for it."""

_IGNORED = ('/rosout', '/parameter_events', '/transition_event')
_DEPTH = 5000
_TICK_NANOSECONDS = round(TICK * 1e9)


class Recorder:
    """Keeps, serialised and in the order of arrival, what some nodes publish.

    Parameters
    ----------
    node : rclpy.node.Node
    prefix : str
        Namespace that is left out of the topics' names.

    Attributes
    ----------
    state : marxbot_msgs.msg.ArenaState or None
        The last one since `clear`.
    """

    def __init__(self, node, prefix):
        self._node = node
        self._prefix = prefix
        self._topics = {}
        self._messages = []
        self._ticks = defaultdict(set)
        self._whole = Counter()
        self._episode = 0
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
        needed = {*SENSORS, *COMMANDS, *NEURONS, *EVERY_TICK, *LATCHED}
        return self._topics.keys() >= needed

    def _add(self, topic, short, type_name):
        publishers = self._node.get_publishers_info_by_topic(topic)
        if not publishers:
            return
        offered = publishers[0].qos_profile
        if offered.reliability != ReliabilityPolicy.RELIABLE:
            raise RuntimeError(f'{topic} is offered without reliability, nothing to record')
        latched = short in LATCHED
        qos = QoSProfile(
            depth=_DEPTH,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        self._topics[short] = type_name, offered
        stamp = stamp_reader(type_name)
        self._node.create_subscription(
            message_class(type_name),
            topic,
            lambda data: self._take(short, data, stamp),
            qos,
            raw=True,
        )

    def _take(self, topic, data, stamp):
        if topic == STATE:
            state = self._decode(topic, data)
            if state.episode < self._episode:
                return
            if state.episode > self._episode:
                self._begin(state.episode)
            self.state = state
        self._messages.append((topic, data))
        self._ticks[topic].add(_tick(stamp(data)) if stamp and topic not in LATCHED else 0)

    def _decode(self, topic, data):
        return deserialize_message(data, message_class(self._topics[topic][0]))

    def _begin(self, episode):
        """Keep no state of another episode."""
        self._episode = episode
        self._messages = [(topic, data) for topic, data in self._messages if topic != STATE]
        self._ticks[STATE].clear()
        self._whole[STATE] = 0

    def clear(self):
        """Forget everything but latched messages, before the simulator is reset.

        States of former episodes are left out from now on. Late messages of other topics may be
        among what is kept.
        """
        self._episode += 1
        self._messages = [(topic, data) for topic, data in self._messages if topic in LATCHED]
        self._ticks = defaultdict(set, {topic: {0} for topic, _ in self._messages})
        self._whole.clear()
        self.state = None

    def lacking(self, ticks, commands):
        """Return what has not come: topics, each with the first tick that it lacks.

        Parameters
        ----------
        ticks : int
            Ticks made in the episode.
        commands : bool
            Whether each tick had commands of its own.
        """
        wanted = dict.fromkeys(EVERY_TICK, ticks + 1) | dict.fromkeys(SENSORS, ticks)
        wanted |= dict.fromkeys(LATCHED, 1)
        if commands:
            wanted |= dict.fromkeys((*COMMANDS, *NEURONS), ticks)
        firsts = {topic: self._first_missing(topic) for topic in wanted}
        lacking = {topic: tick for topic, tick in firsts.items() if tick < wanted[topic]}
        if not commands:
            for topics in zip(COMMANDS, NEURONS, strict=True):
                lacking |= self._differing(*topics)  # each step of a controller leads to both
        return lacking

    def _first_missing(self, topic):
        tick = self._whole[topic]
        while tick in self._ticks[topic]:
            tick += 1
        self._whole[topic] = tick
        return tick

    def _differing(self, one, other):
        ones, others = self._ticks[one], self._ticks[other]
        pairs = ((one, others - ones), (other, ones - others))
        return {topic: min(missing) for topic, missing in pairs if missing}

    def by_tick(self, topic):
        """Return the decoded messages of a topic, by the tick of their stamp."""
        messages = (self._decode(t, data) for t, data in self._messages if t == topic)
        return {_tick(_nanoseconds(message.header.stamp)): message for message in messages}

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


def _nanoseconds(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


def _tick(nanoseconds):
    """Return the tick of a stamp; the simulator's clock starts at one tick."""
    return round(nanoseconds / _TICK_NANOSECONDS) - 1
