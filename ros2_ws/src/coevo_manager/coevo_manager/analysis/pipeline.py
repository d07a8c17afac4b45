"""From run folders to figures, tables and the report."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from coevo_manager import cluster
from coevo_manager.analysis.figures import beyond as figures_beyond
from coevo_manager.analysis.figures import draw
from coevo_manager.analysis.figures import games as figures_games
from coevo_manager.analysis.figures import paper as figures
from coevo_manager.analysis.figures.behaviours import CAPTION, behaviours
from coevo_manager.analysis.play.kernel import Kernel, source_hash
from coevo_manager.analysis.play.probe import SearchBudget
from coevo_manager.analysis.play.tournament import Evaluations, Store
from coevo_manager.analysis.report import player, tables
from coevo_manager.analysis.report.page import Picture, write_report
from coevo_manager.analysis.runs import AnalysisError, choose_generations, read_runs
from coevo_manager.analysis.study import Stage, Study, collect


def analyze(
    folders: Sequence[Path],
    out: Path,
    *,
    every: int | None = None,
    until: int | None = None,
    candidates: int = 500,
    opponents: int = 10,
    cache: Path | None = None,
    threads: int = 1,
    dask: str | None = None,
    stage: Stage = lambda title, total: lambda amount: None,
) -> Path:
    """Analyse runs and write everything to a folder; returns the path of its report.html.

    Parameters
    ----------
    folders : sequence of Path
        Run folders.
    out : Path
        Receives report.html, figures/*.png and *.svg, and tables/*.csv.
    every, until : int, optional
        Spacing and last of the generations compared, see `choose_generations`.
    candidates : int
        SearchBudget of each search for a best response; 0 for none.
    opponents : int
        Held-out opponents taken from each other run.
    cache : Path, optional
        Folder of stored episode results; `out`/cache without it.
    threads : int
        Threads or processes on this machine.
    dask : str, optional
        Address of a Dask scheduler whose workers evaluate instead of this process.
    stage : callable
        Told of each stage of work; see `study.collect`.

    Raises
    ------
    AnalysisError
        The runs cannot be analysed; nothing but stored results is written.

    Examples
    --------
    >>> from pathlib import Path
    >>> import red_queen as rq
    >>> report = rq.analyze(['runs/mine'], Path('results'))  # doctest: +SKIP
    """
    runs = read_runs(folders)
    generations = choose_generations(runs, every, until)
    kernel = Kernel()
    client = connect(dask, kernel.version) if dask else None
    try:
        evaluations = Evaluations(
            kernel, Store(cache or out / 'cache', kernel.version), threads, client
        )
        budget = SearchBudget(candidates) if candidates else None
        study = collect(runs, generations, evaluations, budget, opponents, stage)
        return write_all(study, out, stage)
    finally:
        if client is not None:
            client.close()


def write_all(study: Study, out: Path, stage: Stage) -> Path:
    """Write the figures, tables and report of a study."""
    for name in ('figures', 'tables'):
        (out / name).mkdir(parents=True, exist_ok=True)
    found = tables.all_tables(study)
    for name, table in found.items():
        tables.write(table.frame, out / 'tables' / f'{name}.csv')
    charts = [
        *figures.paper_figures(study),
        *figures_beyond.figures(study, found['verdicts'].frame),
        *figures_games.figures(study, {name: table.frame for name, table in found.items()}),
    ]
    advance = stage('Figures', len(charts) + len(study.conditions))
    drawn = draw.draw_all(charts, out / 'figures', advance)
    pictures = []
    for each in study.conditions:
        name = f'behaviours_{each.condition.slug}'
        svg = draw.save(behaviours(each, study.evaluations), out / 'figures' / name)[1]
        title = f'Representative behaviours, {each.condition.name}, {each.condition.arena}'
        pictures.append(Picture(name, title, CAPTION, svg, each.condition.arena))
        advance(1)
    shown = player.ranks(study.conditions)
    advance = stage('Episodes to watch', sum(player.size(c, shown) for c in study.conditions))
    kernel = study.evaluations.kernel
    recorded = [player.grid(each, shown, kernel, advance) for each in study.conditions]
    write_report(out / 'report.html', study, drawn, pictures, found, recorded)
    return out / 'report.html'


def connect(address: str, version: str) -> Any:
    """Connect to a Dask scheduler, as a distributed.Client.

    Raises
    ------
    AnalysisError, ClusterError
        Nothing answers there, it has no workers, or one has another version of the kernel.
    """
    client = cluster.connect(address)
    try:
        client.wait_for_workers(1, timeout=cluster.TIMEOUT)
        versions = client.run(source_hash)
    except TimeoutError:
        client.close()
        raise AnalysisError(f'dask is {address}: its scheduler has no workers') from None
    others = sorted(worker for worker, found in versions.items() if found != version)
    if others:
        client.close()
        raise AnalysisError(
            f'dask is {address}: its worker {others[0]} has another version of the episode kernel'
        )
    return client
