"""The executable replay: a bag back on topics, or as a picture."""

import sys
import time
from pathlib import Path

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.highlevel import AnyReader, AnyReaderError

from coevo_manager.command_line import Parser, add_option, new_path, refuse
from coevo_manager.recording.message_types import make_typestore, message_class
from coevo_manager.recording.recorder import GROUND_TRUTH, STATE
from marxbot_sim.core.fields import Option
from node_runner import make_executor, own_arguments, run_ros, stop_requested


class Bag:
    """An open bag of an episode; to be used as a context manager.

    Raises
    ------
    ValueError
        There is no readable bag.
    """

    def __init__(self, path):
        self._path = path
        if not path.is_dir():
            raise ValueError(f'{path} is not the folder of a bag')
        try:
            self.reader = AnyReader([path], default_typestore=make_typestore())
            self.reader.open()
        except (AnyReaderError, OSError, ValueError) as error:
            raise ValueError(f'{path} is not a readable bag: {error}') from None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.reader.close()

    def messages(self):
        """Yield topic, type name, simulated time in s and serialised message, in order."""
        for connection, nanoseconds, data in self.reader.messages():
            yield connection.topic, connection.msgtype, nanoseconds * 1e-9, bytes(data)

    def decoded(self, *topics):
        """Yield topic and decoded message, in order."""
        connections = [c for c in self.reader.connections if c.topic in topics]
        for connection, _, data in self.reader.messages(connections=connections):
            yield connection.topic, self.reader.deserialize(data, connection.msgtype)

    def track(self):
        """Return what is to be drawn of the episode, see `coevo_manager.recording.drawing.Track`.

        Raises
        ------
        ValueError
            The bag holds no episode.
        """
        from coevo_manager.recording.drawing import Track

        positions = {topic: [] for topic in GROUND_TRUTH}
        state = None
        for topic, message in self.decoded(*GROUND_TRUTH, STATE):
            if topic == STATE:
                state = message
            else:
                pose = message.pose.pose
                positions[topic].append(
                    (pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w)
                )
        if state is None or not all(positions.values()):
            raise ValueError(
                f'{self._path} holds no episode: {STATE} or {", ".join(GROUND_TRUTH)} is empty'
            )
        return Track.from_quaternions(
            list(positions.values()), state.size, state.obstacle, state.captured
        )


def play(bag, rate):
    """Publish a bag's messages at `rate` times their pace, with the QoS they came with."""
    node = rclpy.create_node('replay', start_parameter_services=False)
    executor = make_executor(node)
    try:
        publishers = {}
        for connection in bag.reader.connections:
            offered = connection.ext.offered_qos_profiles
            qos = QoSProfile(depth=100)
            if offered:
                qos.reliability = ReliabilityPolicy[offered[0].reliability.name]
                qos.durability = DurabilityPolicy[offered[0].durability.name]
            publishers[connection.topic] = node.create_publisher(
                message_class(connection.msgtype), connection.topic, qos
            )
        first, started = None, time.monotonic()
        for topic, _, when, data in bag.messages():
            first = when if first is None else first
            while not stop_requested.is_set():
                remaining = (when - first) / rate - (time.monotonic() - started)
                if remaining <= 0:
                    break
                executor.spin_once(timeout_sec=min(remaining, 0.1))
            if stop_requested.is_set():
                break
            publishers[topic].publish(data)
        else:
            for publisher in publishers.values():
                publisher.wait_for_all_acked()
    finally:
        executor.shutdown()
        node.destroy_node()
    return 0


def main(arguments=None):
    """Run the executable; return its exit code."""
    command_line = list(sys.argv if arguments is None else ['replay', *arguments])
    parser = Parser(
        prog='replay',
        description='Plays a bag of an episode back on its topics, /clock included, or draws it.',
    )
    parser.add_argument('bag', type=Path, metavar='BAG')
    add_option(parser, Option('rate', float, 1.0, 'pace, times real time', above=0.0))
    parser.add_argument(
        '--png', type=new_path, metavar='FILE', help='draw the trajectories instead'
    )
    parser.add_argument('--gif', type=new_path, metavar='FILE', help='draw an animation instead')
    options = parser.parse_args(own_arguments(command_line))
    if options.png is None and options.gif is None:

        def work():
            with Bag(options.bag) as bag:
                return play(bag, options.rate)

        return run_ros(work, command_line)
    try:
        with Bag(options.bag) as bag:
            track = bag.track()
    except ValueError as error:
        return refuse('replay', error)
    from coevo_manager.recording.drawing import draw_animation, draw_trajectories

    if options.png is not None:
        draw_trajectories(track, options.png)
    if options.gif is not None:
        draw_animation(track, options.gif, options.rate)
    return 0


if __name__ == '__main__':
    sys.exit(main())
