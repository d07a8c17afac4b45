"""The executable export: a genome as a controller's parameters, or as a C header."""

import sys

from coevo_manager.command_line import (
    GENOME_HELP,
    Parser,
    add_environment_options,
    any_path,
    carry_out,
    read_environment,
)
from coevo_manager.core.environment import NETWORK_SETTINGS
from coevo_manager.core.evolution.files import write_whole
from coevo_manager.core.provenance import describe
from neuro_controller.core.c_header import c_header
from neuro_controller.core.champions import select_champion
from neuro_controller.core.snapshot import SPECIES


def parameters_yaml(genome, settings, provenance):
    """Return a parameter file for any controller node, for its ``--params-file``.

    Parameters
    ----------
    genome : array_like, float32, shape (genes,)
    settings : dict
        Parameters of the controller node by name, numbers or text.
    provenance : str
        Where the genome comes from, a line.
    """
    genes = ', '.join(repr(float(gene)) for gene in genome)
    lines = [f'    {name}: {value}' for name, value in settings.items()]
    return '\n'.join(
        [f'# {provenance}', '/**:', '  ros__parameters:', *lines, f'    genome: [{genes}]', '']
    )


def _provenance(champion, settings):
    """Return where a champion comes from, and which of its settings were replaced."""
    own = champion.settings
    replaced = [f'{name} {value}' for name, value in settings.items() if value != own[name]]
    return describe(champion) + (f'; exported with {", ".join(replaced)}' if replaced else '')


def main(arguments=None):
    """Run the executable; return its exit code."""
    parser = Parser(prog='export', description='Writes a genome for a robot.')
    parser.add_argument('genome', metavar='GENOME', help=GENOME_HELP)
    parser.add_argument('--species', choices=SPECIES, required=True)
    parser.add_argument(
        '--yaml',
        type=any_path,
        metavar='FILE',
        help='parameters, for --params-file of the controller',
    )
    parser.add_argument(
        '--header', type=any_path, metavar='FILE', help='C99 header with weights and step function'
    )
    parser.add_argument('--name', help='prefix of what the header defines (default: the species)')
    add_environment_options(
        parser, ('environment', 'predator_speed', 'prey_speed', *NETWORK_SETTINGS)
    )
    options = parser.parse_args(arguments)
    if options.yaml is None and options.header is None:
        parser.error('nothing to write, expected --yaml FILE, --header FILE or both')

    def write():
        champion = select_champion(options.genome, options.species)
        environment = read_environment('export', options, [champion])
        speed = environment.max_wheel_speeds[SPECIES.index(options.species)]
        settings = {'max_wheel_speed': float(speed), **environment.network_settings}
        provenance = _provenance(champion, settings)
        name = options.name or options.species
        header = c_header(champion.genome, name, provenance=provenance, **settings)
        files = {}
        if options.yaml is not None:
            files[options.yaml] = parameters_yaml(champion.genome, settings, provenance)
        if options.header is not None:
            files[options.header] = header
        for path, text in files.items():
            write_whole(path, text.encode())
            print(path)
        return 0

    return carry_out('export', write, (ValueError, OSError))


if __name__ == '__main__':
    sys.exit(main())
