"""`coevo_manager transfer`: champions under other physics and with imperfect robots."""

import os
import sys
from collections.abc import Sequence

from coevo_manager.command_line import Parser, add_option, any_path, carry_out
from marxbot_sim.core.fields import Option


def make_parser() -> Parser:
    """Make the command line."""
    parser = Parser(
        prog='transfer',
        description='Let the champions of runs play under the kernel they evolved in, under rigid '
        'bodies (pymunk), and with each perturbation of the robots and all of them; write '
        'transfer.csv, transfer.md, transfer.png and transfer.svg.',
    )
    parser.add_argument('runs', nargs='+', metavar='RUN', type=any_path, help='run folders')
    parser.add_argument(
        '--out', required=True, metavar='DIR', type=any_path, help='folder for the results'
    )
    for name, default, maximum, text in (
        ('champions', 10, 1024, 'fittest individuals of each species and run'),
        ('draws', 5, 1000, 'draws of each perturbation that is random'),
        ('threads', len(os.sched_getaffinity(0)), 1024, 'threads; they change no result'),
    ):
        add_option(parser, Option(name, int, default, text, minimum=1, maximum=maximum))
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the executable; return 0, 2 for bad input, 1 for a full disk, 130 when interrupted."""
    options = make_parser().parse_args(argv)
    from rich.progress import Progress

    from coevo_manager.analysis.figures.draw import save
    from coevo_manager.analysis.report.tables import write
    from coevo_manager.analysis.runs import read_run
    from coevo_manager.analysis.transfer.measure import measure_transfer, targets
    from coevo_manager.analysis.transfer.report import draw_transfer, to_markdown
    from coevo_manager.core.evolution.files import write_whole
    from coevo_manager.outlet import Outlet, make_console

    def work() -> int:
        runs = [read_run(folder) for folder in options.runs]
        options.out.mkdir(parents=True, exist_ok=True)
        with Progress(console=make_console(sys.stderr), transient=True) as progress:
            task = progress.add_task('conditions', total=len(targets()))
            table = measure_transfer(
                runs,
                options.champions,
                options.draws,
                options.threads,
                lambda: progress.advance(task),
            )
        text = to_markdown(table, options.champions, options.draws)
        write(table, options.out / 'transfer.csv')
        write_whole(options.out / 'transfer.md', text.encode())
        save(draw_transfer(table), options.out / 'transfer')
        print(options.out / 'transfer.md', file=Outlet(), flush=True)
        return 0

    return carry_out('transfer', work, (ValueError, OSError))


if __name__ == '__main__':
    sys.exit(main())
