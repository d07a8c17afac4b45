"""`coevo_manager analyze`: figures, tables and a report from run folders."""

import os
import sys
from collections.abc import Callable, Sequence

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from coevo_manager.command_line import Parser, add_option, any_path, carry_out
from marxbot_sim.core.fields import Option

_NUMBERS = (
    Option(
        'every',
        int,
        None,
        'spacing of the generations to compare (default: 16 of those with snapshots)',
        'generations',
        minimum=1,
    ),
    Option(
        'until',
        int,
        None,
        'last generation to compare (default: the last that every run has reached)',
        minimum=1,
    ),
    Option(
        'probe',
        int,
        500,
        'budget of each search for a best response to a champion, 0 for none',
        'candidates',
        minimum=0,
        maximum=1_000_000,
    ),
    Option(
        'held_out',
        int,
        10,
        'held-out opponents taken from each other run',
        minimum=1,
        maximum=1024,
    ),
    Option(
        'threads',
        int,
        len(os.sched_getaffinity(0)),
        'threads and processes on this machine; they change no result',
        minimum=1,
        maximum=1024,
    ),
)


def make_parser() -> Parser:
    """Make the command line."""
    parser = Parser(
        prog='analyze',
        description='Turn run folders (replications, conditions, environments) into figures, '
        'tables and one self-contained report.html.',
    )
    parser.add_argument(
        'runs', nargs='+', metavar='RUN', type=any_path, help='run folders to compare'
    )
    parser.add_argument(
        '--out', required=True, metavar='DIR', type=any_path, help='folder for the results'
    )
    for option in _NUMBERS:
        add_option(parser, option)
    parser.add_argument(
        '--cache',
        type=any_path,
        metavar='DIR',
        help='folder of stored episode results (default: OUT/cache)',
    )
    parser.add_argument(
        '--dask',
        metavar='ADDRESS',
        help='scheduler of a Dask cluster to use instead, tls://HOST:PORT or tcp://HOST:PORT',
    )
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Analyse; returns 0, 2 for bad input, 1 for a full disk, 130 when interrupted."""
    arguments = make_parser().parse_args(argv)
    from coevo_manager.analysis.pipeline import analyze
    from coevo_manager.outlet import Outlet, make_console

    console = make_console(sys.stderr)
    columns = (
        TextColumn('{task.description}'),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )

    def work() -> int:
        with Progress(*columns, console=console) as progress:

            def stage(title: str, total: int) -> Callable[[int], None]:
                task = progress.add_task(title, total=total)
                return lambda amount: progress.advance(task, amount)

            report = analyze(
                arguments.runs,
                arguments.out,
                every=arguments.every,
                until=arguments.until,
                candidates=arguments.probe,
                opponents=arguments.held_out,
                cache=arguments.cache,
                threads=arguments.threads,
                dask=arguments.dask,
                stage=stage,
            )
        print(report, file=Outlet(), flush=True)
        return 0

    return carry_out(
        'analyze',
        work,
        (ValueError, OSError),
        'interrupted; the same command continues where it was',
    )


if __name__ == '__main__':
    sys.exit(main())
