"""Figures that go past the paper: verdicts, held-out opponents, probes, ratings, diversity."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from coevo_manager.analysis.figures.charts import MARKERS, Chart, Mark, Panel, Points
from coevo_manager.analysis.figures.marks import condition_line, interval_note, species_line
from coevo_manager.analysis.measures import beyond
from coevo_manager.analysis.play.probe import (
    WINS,
    SearchBudget,
    candidates_needed,
    while_searching,
)
from coevo_manager.analysis.study import ConditionResults, Study
from coevo_manager.core.species import COLOURS, OTHER, PLURAL, SPECIES

Members = Sequence[ConditionResults]


def figures(study: Study, verdicts: pd.DataFrame) -> Iterator[Chart]:
    """Charts of the gains, and per arena of everything beyond the paper."""
    for arena, members in study.arenas().items():
        yield _gains(arena, members, verdicts[verdicts['arena'] == arena])
        if any(each.held_out['predator'] for each in members):
            yield _held_out(arena, members, study)
        if study.budget is not None:
            yield _probes(arena, members, study, study.budget)
        yield _ratings(arena, members, study)
        yield _diversity(arena, members, study)


def _gains(arena: str, members: Members, table: pd.DataFrame) -> Chart:
    conditions = list(dict.fromkeys(table['condition']))
    panels = []
    for measure in dict.fromkeys(table['measure']):
        marks: list[Mark] = []
        for species, shift in zip(SPECIES, (-0.12, 0.12), strict=True):
            part = table[(table['measure'] == measure) & (table['species'] == species)]
            points = Points(
                [conditions.index(c) + shift for c in part['condition']],
                part['difference'].to_numpy(),
                PLURAL[species].capitalize(),
                COLOURS[species],
                MARKERS[species],
                [
                    f'{c}, {species}: {v}'
                    for c, v in zip(part['condition'], part['verdict'], strict=True)
                ],
            )
            if part['bootstrap_low'].notna().all():
                points.low = part['bootstrap_low'].to_numpy()
                points.high = part['bootstrap_high'].to_numpy()
            marks.append(points)
        panels.append(
            Panel(
                measure.capitalize(),
                '',
                'Gain in fitness',
                marks,
                zero=True,
                categories=conditions,
            )
        )
    return Chart(
        'gains',
        f'Did they make progress? {arena.capitalize()}',
        'A point is the gain of the second half of the run. Historical is the gain against '
        'opponents of the first half rather than its own. Global is the gain over the first '
        'half, against all generations. Held-out is the same against the best of other runs, '
        'which were never met. The random genomes of generation 0 are left out.',
        [panels],
        arena,
        interval_note(members, 'Bars'),
    )


def _held_out(arena: str, members: Members, study: Study) -> Chart:
    row = []
    for each in members:
        means = {species: each.held_out_mean(species) for species in SPECIES}
        marks = [
            species_line(study.generations, mean, species)
            for species, mean in means.items()
            if mean is not None
        ]
        row.append(Panel(each.condition.name, 'Generation', 'Fitness vs held-out', marks, (0, 1)))
    return Chart(
        'held_out',
        f'Performance against held-out opponents, {arena}',
        f'Each generation meets the {study.opponents} best of the last generation of every other '
        'run of the arena: opponents with which it never co-evolved.',
        [row],
        arena,
        interval_note(members),
    )


def _probes(arena: str, members: Members, study: Study, budget: SearchBudget) -> Chart:
    rows: list[list[Panel]] = []
    for reduce, label in (
        (candidates_needed, f'Candidates until {WINS:g}'),
        (while_searching, 'Fitness while searching'),
    ):
        row = []
        for species in SPECIES:
            marks = [
                condition_line(study.generations, reduce(each.probes[species]), each, members)
                for each in members
            ]
            title = f'{PLURAL[OTHER[species]].capitalize()} searched for' if not rows else ''
            row.append(Panel(title, f'Generation of the {species} champion', label, marks))
        rows.append(row)
    return Chart(
        'exploitability',
        f'Exploitability of the champions, {arena}',
        'Fresh opponents are searched for against the frozen champion of each generation, in '
        f'{budget.searches} searches of {budget.candidates} candidates. Above are the '
        f'candidates tried until one scores {WINS:g}, {budget.candidates} where none does; more '
        'is harder to exploit. Below is the best fitness so far, averaged over the course of '
        'the searches; lower is harder to exploit. The table has the best found in the end: '
        'nearly every champion falls to some opponent.',
        rows,
        arena,
        interval_note(members),
        height=1.9,
    )


def _ratings(arena: str, members: Members, study: Study) -> Chart:
    marks = []
    shares = []
    for each in members:
        found = [beyond.hodge(tournament) for tournament in each.tournament]
        ratings = np.stack([f[0] for f in found])
        marks.append(condition_line(study.generations, ratings, each, members))
        shares.append(f'{each.condition.name} {np.nanmean([f[2] for f in found]):.0%}')
    panel = Panel('Rating', 'Generation', 'Rating (fitness)', marks, zero=True)
    return Chart(
        'ratings',
        f'Transitive and cyclic parts of the tournament, {arena}',
        'The rating of a generation that plays both roles against all others is the transitive '
        'part of the Hodge decomposition of the tournament. Progress lifts it. The rest is '
        'cyclic (rock-paper-scissors), and no rating can express it. Its share of the '
        f'tournament: {"; ".join(shares)}.',
        [[panel]],
        arena,
        interval_note(members),
    )


def _diversity(arena: str, members: Members, study: Study) -> Chart:
    rows: list[list[Panel]] = []
    for of, label in (
        ('paths', 'Distance of paths (m)'),
        ('profiles', 'Distance of profiles'),
    ):
        row = []
        for species in SPECIES:
            marks = [
                condition_line(study.generations, getattr(each, of)[species], each, members)
                for each in members
            ]
            row.append(Panel(PLURAL[species].capitalize(), 'Generation', label, marks))
        rows.append(row)
    return Chart(
        'diversity',
        f'Diversity of behaviour, {arena}',
        'Above is the mean distance between the paths of individuals that meet the same '
        'champion. Below is the mean distance between their fitness against each opponent, the '
        'distance by which the generalist algorithm tells opponents apart. 0 is a population of '
        'one behaviour.',
        rows,
        arena,
        interval_note(members),
        height=1.9,
    )
