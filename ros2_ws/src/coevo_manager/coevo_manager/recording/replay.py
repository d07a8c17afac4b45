"""The executable replay: a bag back on topics, or as a picture."""

import argparse
import sys
import time

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from coevo_manager.command_line import Parser, add_option, any_path, carry_out, new_path
from coevo_manager.core.evolution.files import write_whole
from coevo_manager.recording.bag_reader import BagReader
from coevo_manager.recording.message_types import message_class
from marxbot_sim.core.fields import Option
from marxbot_sim.core.parameters import FASTEST, SLOWEST
from node_runner import make_executor, own_arguments, run_ros, stop_requested

FILMS = ('.mp4', '.webm')


def play(bag, rate):
    """Publish a bag's messages at `rate` times their pace, with the QoS they came with."""
    node = rclpy.create_node('replay', start_parameter_services=False)
    executor = make_executor(node)
    try:
        publishers = {}
        for connection in bag.connections:
            offered = connection.ext.offered_qos_profiles
            qos = QoSProfile(depth=100)
            if offered:
                qos.reliability = ReliabilityPolicy[offered[0].reliability.name]
                qos.durability = DurabilityPolicy[offered[0].durability.name]
            publishers[connection.topic] = node.create_publisher(
                message_class(connection.msgtype), connection.topic, qos
            )
        first, started = None, time.monotonic()
        for topic, when, data in bag.messages():
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


def draw(bag, options):
    """Draw a bag's episode to the files that the options name."""
    from rich.console import Console
    from rich.progress import Progress

    from coevo_manager.recording.animation import Pace, make_film, make_gif
    from coevo_manager.recording.drawing import Track, draw_trajectories

    poses, state = bag.episode()
    track = Track.from_quaternions(poses, state.size, state.obstacle, state.captured)
    if options.png is not None:
        write_whole(options.png, draw_trajectories(track))
    pace = Pace.of(track, options.rate)
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for path in filter(None, (options.gif, options.film)):
            task = progress.add_task(path.name, total=len(pace.ticks))

            def advance(task=task):
                progress.advance(task)

            if path == options.gif:
                content = make_gif(track, pace, advance)
            else:
                content = make_film(track, pace, path.suffix, advance)
            write_whole(path, content)
    return 0


def _named(*suffixes):
    """Return an argparse type: a new path whose name ends in one of the suffixes."""

    def check(text):
        if not text.endswith(suffixes):
            raise argparse.ArgumentTypeError(
                f'{text} is no name of such a file, expected one that ends in '
                f'{" or ".join(suffixes)}'
            )
        return new_path(text)

    return check


def _film(text):
    from coevo_manager.recording.animation import find_ffmpeg

    if find_ffmpeg() is None:
        raise argparse.ArgumentTypeError('ffmpeg was not found, expected it to be installed')
    return _named(*FILMS)(text)


def main(arguments=None):
    """Run the executable; return its exit code."""
    command_line = list(sys.argv if arguments is None else ['replay', *arguments])
    parser = Parser(
        prog='replay',
        description='Plays a bag of an episode back on its topics, /clock included, or draws it.',
    )
    parser.add_argument('bag', type=any_path, metavar='BAG')
    add_option(
        parser,
        Option('rate', float, 1.0, 'pace, times real time', minimum=SLOWEST, maximum=FASTEST),
    )
    for name, kind, text in (
        ('png', _named('.png'), 'draw the trajectories instead'),
        ('gif', _named('.gif'), 'draw an animation instead'),
        ('film', _film, 'draw it as an MP4 or WebM film instead'),
    ):
        parser.add_argument(f'--{name}', type=kind, metavar='FILE', help=text)
    options = parser.parse_args(own_arguments(command_line))
    drawing = options.png or options.gif or options.film

    def work():
        with BagReader(options.bag) as bag:
            for line in bag.descriptions():
                print(line)
            return draw(bag, options) if drawing else play(bag, options.rate)

    def replay():
        return carry_out('replay', work, (ValueError, OSError))

    return replay() if drawing else run_ros(replay, command_line)


if __name__ == '__main__':
    sys.exit(main())
