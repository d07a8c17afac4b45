"""`coevo_manager analyze`: figures, tables and a report from run folders."""

import argparse
import os
import sys
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn


def make_parser() -> argparse.ArgumentParser:
    """Make the command line."""
    parser = argparse.ArgumentParser(
        prog='coevo_manager analyze',
        description='Turn run folders (replications, conditions, environments) into figures, '
        'tables and one self-contained report.html.',
    )
    parser.add_argument('runs', nargs='+', metavar='RUN', type=Path, help='run folders to compare')
    parser.add_argument(
        '--out', required=True, metavar='DIR', type=Path, help='folder for the results'
    )
    parser.add_argument(
        '--every',
        type=_positive,
        metavar='GENERATIONS',
        help='spacing of the generations to compare (default: 16 of those with snapshots)',
    )
    parser.add_argument(
        '--until',
        type=_positive,
        metavar='GENERATION',
        help='last generation to compare (default: the last that every run has reached)',
    )
    parser.add_argument(
        '--probe',
        type=_count,
        default=500,
        metavar='CANDIDATES',
        help='budget of each search for a best response to a champion, 0 for none (default: 500)',
    )
    parser.add_argument(
        '--held-out',
        type=_positive,
        default=10,
        metavar='OPPONENTS',
        help='held-out opponents taken from each other run (default: 10)',
    )
    parser.add_argument(
        '--cache',
        type=Path,
        metavar='DIR',
        help='folder of stored episode results (default: OUT/cache)',
    )
    parser.add_argument(
        '--threads',
        type=_positive,
        metavar='N',
        help='threads and processes on this machine (default: all cores)',
    )
    parser.add_argument(
        '--dask', metavar='ADDRESS', help='scheduler of a Dask cluster to use instead'
    )
    return parser


def main(argv=None) -> int:
    """Analyse; returns the exit code: 0, 2 for bad input, 130 when interrupted."""
    arguments = make_parser().parse_args(argv)
    from coevo_manager.analysis.pipeline import analyze
    from coevo_manager.analysis.runs import AnalysisError

    console = Console(stderr=True)
    threads = arguments.threads or os.cpu_count()
    columns = (
        TextColumn('{task.description}'),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    try:
        with Progress(*columns, console=console) as progress:

            def stage(title: str, total: int):
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
                threads=threads,
                dask=arguments.dask,
                stage=stage,
            )
    except AnalysisError as error:
        print(f'coevo_manager analyze: {error}', file=sys.stderr)
        return 2
    except OSError as error:
        print(
            f'coevo_manager analyze: {error.filename or arguments.out}: {error.strerror or error}',
            file=sys.stderr,
        )
        return 2
    except KeyboardInterrupt:
        print(
            'coevo_manager analyze: interrupted; the same command continues where it was',
            file=sys.stderr,
        )
        return 130
    print(report)
    return 0


def _positive(text: str) -> int:
    value = _count(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f'{text} is not a whole number of at least 1')
    return value


def _count(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = -1
    if value < 0:
        raise argparse.ArgumentTypeError(f'{text} is not a whole number of at least 0')
    return value


if __name__ == '__main__':
    sys.exit(main())
