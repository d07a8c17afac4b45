"""The executable export: a genome as a controller's parameters, or as a C header."""

import os
import sys
from pathlib import Path

from coevo_manager.episode_options import GENOME_HELP, add_environment_options, read_environment
from coevo_manager.runs.options import Parser
from neuro_controller.core.c_header import c_header
from neuro_controller.core.champions import select_champion
from neuro_controller.core.snapshot import SPECIES


def parameters_yaml(genome, max_wheel_speed, motor_map, episode_ticks):
    """Return a parameter file for any controller node, for its ``--params-file``.

    Parameters
    ----------
    genome : array_like, float32, shape (442,)
    max_wheel_speed, motor_map, episode_ticks
        See `neuro_controller.core.controller.Controller`.
    """
    genes = ', '.join(repr(float(gene)) for gene in genome)
    return (
        '/**:\n'
        '  ros__parameters:\n'
        f'    max_wheel_speed: {float(max_wheel_speed)!r}\n'
        f'    motor_map: {motor_map}\n'
        f'    episode_ticks: {episode_ticks}\n'
        f'    genome: [{genes}]\n'
    )


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
    add_environment_options(parser)
    options = parser.parse_args(arguments)
    if options.yaml is None and options.header is None:
        parser.error('nothing to write, expected --yaml FILE, --header FILE or both')
    try:
        environment = read_environment(options)
        genome = select_champion(options.genome, options.species).genome
        speed = environment.max_wheel_speeds[SPECIES.index(options.species)]
        settings = speed, environment.motor_map, environment.episode_ticks
        header = c_header(genome, options.name or options.species, *settings)
        if options.yaml is not None:
            _write(options.yaml, parameters_yaml(genome, *settings))
        if options.header is not None:
            _write(options.header, header)
    except ValueError as error:
        print(f'export: {error}', file=sys.stderr)
        return 2
    return 0


if __name__ == '__main__':
    sys.exit(main())
