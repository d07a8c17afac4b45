"""Command-line options that tell which robots play, and where."""

import argparse
from pathlib import Path

from coevo_manager.core.configuration import FIELDS, load_configuration
from coevo_manager.core.worlds import WORLDS
from neuro_controller.core.champions import select_champion
from neuro_controller.core.snapshot import SPECIES

GENOME_HELP = (
    'RUN[:GENERATION[:RANK]], a run folder or snapshot, the generation (default: last) and the '
    'rank in it (default: 0, the champion); or shipped/open or shipped/obstacle'
)


_OPTIONS = (
    'environment', 'motor_map', 'predator_speed', 'prey_speed', 'episode_ticks', 'wall_friction',
    'wall_contact', 'infrared_response', 'ground_coding', 'physics',
)  # fmt: skip


def add_environment_options(parser):
    """Add the options of an `Environment`."""
    group = parser.add_argument_group('environment')
    group.add_argument(
        '--world',
        choices=tuple(WORLDS),
        default='faithful',
        help=f'{FIELDS["world"].metadata["help"]} (default: %(default)s)',
    )
    for name in _OPTIONS:
        field = FIELDS[name]
        choices = tuple(field.metadata['choices'])
        group.add_argument(
            f'--{name.replace("_", "-")}',
            type=str if choices else int if name == 'episode_ticks' else float,
            choices=choices or None,
            metavar=None if choices else 'NUMBER',
            help=f'{field.metadata["help"]} (default: {field.default})',
        )


def read_environment(options):
    """Return the `Environment` that was asked for; ValueError if a number is out of its range."""
    given = {name: getattr(options, name) for name in _OPTIONS}
    given = {name: value for name, value in given.items() if value is not None}
    return load_configuration({'world': options.world, **given}).make_environment()


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
