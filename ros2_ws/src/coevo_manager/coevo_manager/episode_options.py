"""Command-line options that tell which robots play, and where."""

import argparse
from pathlib import Path

from coevo_manager.core.environment import Environment
from neuro_controller.core.champions import select_champion
from neuro_controller.core.controller import MOTOR_MAPS
from neuro_controller.core.snapshot import SPECIES

GENOME_HELP = (
    'RUN[:GENERATION[:RANK]], a run folder or snapshot, the generation (default: last) and the '
    'rank in it (default: 0, the champion); or shipped/open or shipped/obstacle'
)


def add_environment_options(parser):
    """Add the options of an `Environment`."""
    default = Environment()
    group = parser.add_argument_group('environment')
    group.add_argument(
        '--environment', choices=('open', 'obstacle'), default='open', help='(default: open)'
    )
    group.add_argument(
        '--motor-map',
        choices=sorted(MOTOR_MAPS),
        default=default.motor_map,
        help='(default: %(default)s)',
    )
    group.add_argument(
        '--predator-speed',
        type=float,
        metavar='RAD/S',
        help='highest wheel speed (default: 8.5, or 10 with the obstacle)',
    )
    group.add_argument(
        '--prey-speed',
        type=float,
        metavar='RAD/S',
        default=default.prey_speed,
        help='(default: %(default)s)',
    )
    group.add_argument(
        '--episode-ticks',
        type=int,
        metavar='N',
        default=default.episode_ticks,
        help='of 0.1 s (default: %(default)s)',
    )
    group.add_argument(
        '--wall-friction',
        type=float,
        metavar='MU',
        default=default.wall_friction,
        help='(default: %(default)s)',
    )
    group.add_argument(
        '--physics',
        choices=('kinematic', 'pymunk'),
        default='kinematic',
        help='(default: %(default)s)',
    )


def read_environment(options):
    """Return the `Environment` that was asked for; ValueError if a number is out of its range."""
    return Environment(
        obstacle=options.environment == 'obstacle',
        motor_map=options.motor_map,
        predator_speed=options.predator_speed,
        prey_speed=options.prey_speed,
        episode_ticks=options.episode_ticks,
        wall_friction=options.wall_friction,
        physics=options.physics,
    )


def add_genome_options(parser):
    """Add the options --predator and --prey."""
    for species in SPECIES:
        parser.add_argument(
            f'--{species}',
            default='shipped/open',
            metavar='GENOME',
            help=f'{GENOME_HELP} (default: %(default)s)',
        )


def read_genomes(options):
    """Return the genomes of predator and prey; ValueError if there are none such."""
    return [select_champion(getattr(options, species), species).genome for species in SPECIES]


def new_path(text):
    """Return a path where nothing is yet and whose folder exists (argparse type)."""
    path = Path(text)
    if path.exists():
        raise argparse.ArgumentTypeError(f'{path} exists, expected a new name')
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f'{path.parent} is not a folder')
    return path
