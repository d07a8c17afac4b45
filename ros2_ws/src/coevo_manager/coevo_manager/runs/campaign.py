"""`coevo_manager campaign`: many runs, conditions x environments x seeds, over Dask."""

import os
import sys
from collections.abc import Sequence

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from coevo_manager.cluster import connect, own_cluster
from coevo_manager.command_line import Parser, any_path, carry_out
from coevo_manager.outlet import Outlet, make_console


def make_parser() -> Parser:
    """The command line."""
    parser = Parser(
        prog='campaign',
        description='Run evolution for every condition, environment and seed of a campaign file. '
        'Finished runs are skipped, interrupted ones continue, failed ones are tried again.',
    )
    parser.add_argument(
        'file', metavar='FILE.yaml', type=any_path, help='the campaign, see docs/analysis.md'
    )
    parser.add_argument(
        '--dask',
        metavar='ADDRESS',
        help='scheduler of a Dask cluster, tls://HOST:PORT or tcp://HOST:PORT (default: one of '
        'its own, one worker process a core)',
    )
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run a campaign; 0 when all runs finished, 1 when some failed, 2 for bad input."""
    arguments = make_parser().parse_args(argv)
    from coevo_manager.runs.jobs import Job, execute, read_campaign

    console = make_console(sys.stderr)

    def work() -> int:
        campaign = read_campaign(arguments.file)
        cluster = (
            connect(arguments.dask)
            if arguments.dask
            else own_cluster(len(os.sched_getaffinity(0)))
        )
        columns = (TextColumn('Runs'), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        with cluster as client, Progress(*columns, console=console) as progress:
            task = progress.add_task('runs', total=len(campaign.jobs))

            def done(job: Job, error: str) -> None:
                progress.advance(task)
                progress.console.print(f'{job.folder.name}: {error or "finished"}', markup=False)

            table = execute(campaign, client, done)
        failed = int((table['state'] == 'failed').sum())
        print(
            f'{len(table) - failed} of {len(table)} runs finished, '
            f'see {campaign.out / "campaign.csv"}',
            file=Outlet(),
            flush=True,
        )
        return 1 if failed else 0

    return carry_out(
        'campaign', work, (ValueError, OSError), 'interrupted; the same command continues'
    )


if __name__ == '__main__':
    sys.exit(main())
