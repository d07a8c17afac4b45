"""The executable record: one episode over topics, into a bag."""

import sys

from coevo_manager.command_line import (
    Parser,
    add_environment_options,
    add_genome_options,
    carry_out,
    new_path,
    read_champions,
    read_environment,
)
from coevo_manager.recording.bag_writer import BagWriter
from coevo_manager.recording.episode_player import EpisodePlayer
from node_runner import own_arguments, run_ros


def _parser():
    parser = Parser(
        prog='record',
        description='Plays one episode over topics, with a simulator and two controllers in '
        'processes of their own, and writes every message to a rosbag2 bag (MCAP, zstd).',
    )
    parser.add_argument(
        'bag', type=new_path, metavar='BAG', help='folder of the bag, which must be new'
    )
    add_genome_options(parser)
    parser.add_argument(
        '--real-time-factor',
        type=float,
        default=0.0,
        metavar='X',
        help='simulated over real time; 0: lockstep, as fast as possible (default: 0)',
    )
    parser.add_argument(
        '--namespace',
        metavar='NS',
        help='of all topics while it runs; / to watch it with the layouts of the demo '
        '(default: one of its own)',
    )
    add_environment_options(parser)
    return parser


def main(arguments=None):
    """Run the executable; return its exit code."""
    command_line = list(sys.argv if arguments is None else ['record', *arguments])
    options = _parser().parse_args(own_arguments(command_line))

    def play():
        champions = read_champions(options)
        environment = read_environment('record', options, champions)
        pace, namespace = options.real_time_factor, options.namespace
        with EpisodePlayer(environment, pace, namespace) as player, BagWriter(options.bag) as bag:
            episode = player.play(*(champion.genome for champion in champions), bag)
            bag.attach_record(environment, champions)
        outcome = 'prey captured' if episode.captured else 'prey got away'
        print(
            f'{outcome} at tick {episode.ticks} of {environment.episode_ticks}: fitness '
            f'{1 - episode.ticks / environment.episode_ticks:.3f} of the predator, '
            f'{episode.ticks / environment.episode_ticks:.3f} of the prey; '
            f'{episode.ticks / episode.seconds:.0f} ticks/s; bag {options.bag}'
        )
        return 0

    def record():
        return carry_out('record', play, ValueError, 'interrupted, there is no bag')

    return run_ros(record, command_line)


if __name__ == '__main__':
    sys.exit(main())
