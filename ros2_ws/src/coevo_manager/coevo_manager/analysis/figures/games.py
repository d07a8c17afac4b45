"""Figures of what game theory says of the tournaments."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from coevo_manager.analysis.figures.charts import CONDITION_COLOURS, MARKERS, Chart, Panel, Points
from coevo_manager.analysis.figures.marks import condition_line, interval_note
from coevo_manager.analysis.study import ConditionResults, Study
from coevo_manager.core.species import PLURAL, SPECIES


def figures(study: Study, tables: Mapping[str, pd.DataFrame]) -> Iterator[Chart]:
    """Charts of each arena: the generations' shares and exploitability, and the league."""
    for arena, members in study.arenas().items():
        rows = [
            [_panel(study, members, tables[name], column, species, title) for species in SPECIES]
            for name, column, title in (
                ('nash_averaging', 'probability', 'Nash probability'),
                ('alpha_rank', 'share_of_time', 'Alpha-rank, share of time'),
            )
        ]
        exploited = _panel(
            study, members, tables['meta_exploitability'], 'exploitability', None,
            'Exploitability',
        )  # fmt: skip
        rows.append([exploited, _diversity(members, tables['effective_diversity'])])
        yield Chart(
            'games',
            f'The tournament as a game, {arena}',
            'Above are the most even Nash equilibrium of the tournament (Nash averaging), and '
            'how long evolution stays with each generation (alpha-rank). Progress moves both to '
            'the end. Below are what the best other generations gain against each, both species '
            'added, and the effective diversity, which is 0 where one generation beats all '
            'others.',
            rows,
            arena,
            interval_note(members),
            height=1.9,
        )
        league = tables.get('league')
        if league is not None and (league['arena'] == arena).any():
            yield _league(arena, league[league['arena'] == arena])


def _panel(
    study: Study,
    members: list[ConditionResults],
    table: pd.DataFrame,
    column: str,
    species: str | None,
    label: str,
) -> Panel:
    marks = []
    for each in members:
        values = [_of(table, each, run.seed, species)[column].to_numpy() for run in each.runs]
        marks.append(condition_line(study.generations, np.array(values), each, members))
    title = PLURAL[species].capitalize() if species else 'Both'
    return Panel(title, 'Generation', label, marks, (0, 1) if species else None)


def _of(
    table: pd.DataFrame, each: ConditionResults, seed: int, species: str | None
) -> pd.DataFrame:
    own = table[
        (table['arena'] == each.condition.arena)
        & (table['condition'] == each.condition.name)
        & (table['seed'] == seed)
    ]
    return own[own['species'] == species] if species else own


def _diversity(members: list[ConditionResults], table: pd.DataFrame) -> Panel:
    names = [each.condition.name for each in members]
    own = table[(table['arena'] == members[0].condition.arena)]
    points = Points(
        [names.index(name) for name in own['condition']],
        own['effective_diversity'].to_numpy(),
        'Run',
        CONDITION_COLOURS[0],
        MARKERS['prey'],
        [f'{c}, seed {s}' for c, s in zip(own['condition'], own['seed'], strict=True)],
    )
    return Panel('Both', '', 'Effective diversity', [points], zero=True, categories=names)


def _league(arena: str, table: pd.DataFrame) -> Chart:
    names = table['condition'].tolist()
    points = Points(
        np.arange(len(names)),
        table['rating'].to_numpy(),
        'Rating',
        CONDITION_COLOURS[0],
        MARKERS['prey'],
        [f'{row.won} won, {row.drawn} drawn, {row.lost} lost' for row in table.itertuples()],
        (table['rating'] - 3 * table['deviation']).to_numpy(),
        (table['rating'] + 3 * table['deviation']).to_numpy(),
    )
    return Chart(
        'league',
        f'League of conditions, {arena}',
        'The last generation of every run plays that of every run of another condition, with both '
        'species. Bars: three standard deviations.',
        [[Panel('', '', 'OpenSkill rating', [points], categories=names)]],
        arena,
    )
