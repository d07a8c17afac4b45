"""The executable export: a genome as a controller's parameters, or as a C header."""

import os
import sys
from pathlib import Path

from coevo_manager.command_line import (
    GENOME_HELP,
    Parser,
    add_environment_options,
    carry_out,
    read_environment,
)
from coevo_manager.core.environment import NETWORK_SETTINGS
from neuro_controller.core.c_header import c_header
from neuro_controller.core.champions import select_champion
from neuro_controller.core.snapshot import SPECIES


def parameters_yaml(genome, settings):
    """Return a parameter file for any controller node, for its ``--params-file``.

    Parameters
    ----------
    genome : array_like, float32, shape (442,)
    settings : dict
        Parameters of the controller node by name, numbers or text.
    """
    genes = ', '.join(repr(float(gene)) for gene in genome)
    lines = [f'    {name}: {value}' for name, value in settings.items()]
    return '\n'.join(['/**:', '  ros__parameters:', *lines, f'    genome: [{genes}]', ''])


def _write(path, text):
    """Write a file beside `path`, then rename it."""
    partial = path.with_name(f'.{path.name}.{os.getpid()}.partial')
    try:
        partial.write_text(text, encoding='utf-8')
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise ValueError(f'{path} cannot be written: {error.strerror}') from None
    print(path)


def main(arguments=None):
    """Run the executable; return its exit code."""
    parser = Parser(prog='export', description='Writes a genome for a robot.')
    parser.add_argument('genome', metavar='GENOME', help=GENOME_HELP)
    parser.add_argument('--species', choices=SPECIES, required=True)
    parser.add_argument(
        '--yaml', type=Path, metavar='FILE', help='parameters, for --params-file of the controller'
    )
    parser.add_argument(
        '--header', type=Path, metavar='FILE', help='C99 header with weights and step function'
    )
    parser.add_argument('--name', help='prefix of what the header defines (default: the species)')
    add_environment_options(
        parser, ('environment', 'predator_speed', 'prey_speed', *NETWORK_SETTINGS)
    )
    options = parser.parse_args(arguments)
    if options.yaml is None and options.header is None:
        parser.error('nothing to write, expected --yaml FILE, --header FILE or both')

    def write():
        environment = read_environment(options)
        genome = select_champion(options.genome, options.species).genome
        speed = environment.max_wheel_speeds[SPECIES.index(options.species)]
        settings = {'max_wheel_speed': float(speed), **environment.network_settings}
        header = c_header(genome, options.name or options.species, **settings)
        if options.yaml is not None:
            _write(options.yaml, parameters_yaml(genome, settings))
        if options.header is not None:
            _write(options.header, header)
        return 0

    return carry_out('export', write, ValueError)


if __name__ == '__main__':
    sys.exit(main())
