"""Figures that go past the paper: verdicts, held-out opponents, probes, ratings, diversity."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from coevo_manager.analysis.figures.charts import MARKERS, Chart, Line, Panel, Points
from coevo_manager.analysis.figures.marks import INTERVAL, condition_line, slug_of, species_line
from coevo_manager.analysis.measures import beyond
from coevo_manager.analysis.play.exploit import best_found, while_searching
from coevo_manager.analysis.study import Replications, Study
from coevo_manager.core.species import COLOURS, OTHER, PLURAL, SPECIES


def figures(study: Study, verdicts: pd.DataFrame) -> Iterator[Chart]:
    """Charts of the gains, and per environment of everything beyond the paper."""
    for arena, members in study.arenas().items():
        slug = slug_of(arena)
        yield _gains(f'gains_{slug}', arena, verdicts[verdicts['arena'] == arena])
        if any(each.held_out['predator'] for each in members):
            yield _held_out(f'held_out_{slug}', arena, members, study)
        if study.budget is not None:
            yield _probes(f'exploitability_{slug}', arena, members, study)
        yield _ratings(f'ratings_{slug}', arena, members, study)
        yield _diversity(f'diversity_{slug}', arena, members, study)


def _gains(name: str, arena: str, table: pd.DataFrame) -> Chart:
    conditions = list(dict.fromkeys(table['condition']))
    panels = []
    for measure in dict.fromkeys(table['measure']):
        marks = []
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
        name,
        f'Did they make progress? {arena.capitalize()}',
        'Gain of the second half of the run. Historical: against opponents of the first half '
        'rather than its own. Global: over the first half, against all generations. '
        'Held-out: the same against '
        f'the best of other runs, never met. Random genomes of generation 0 are left out. '
        f'{INTERVAL}',
        [panels],
    )


def _held_out(name: str, arena: str, members: list[Replications], study: Study) -> Chart:
    row = []
    for each in members:
        marks = [
            species_line(study.generations, each.held_out_mean(species), species)
            for species in SPECIES
            if each.held_out[species]
        ]
        row.append(
            Panel(each.condition.name, 'Generation', 'Fitness vs held-out', marks, ylim=(0, 1))
        )
    return Chart(
        name,
        f'Performance against held-out opponents, {arena}',
        f'Each generation against the {study.opponents} best of the last generation of every '
        f'other run of the environment: opponents it never co-evolved with. {INTERVAL}',
        [row],
    )


def _probes(name: str, arena: str, members: list[Replications], study: Study) -> Chart:
    rows = []
    for reduce, what in ((best_found, 'Best found'), (while_searching, 'While searching')):
        row = []
        for species in SPECIES:
            marks = [
                condition_line(study.generations, reduce(each.probes[species]), each, members)
                for each in members
            ]
            title = f'{what}: {OTHER[species]}'
            row.append(
                Panel(
                    title,
                    f'Generation of the {species} champion',
                    'Fitness found',
                    marks,
                    ylim=(0, 1.02),
                )
            )
        rows.append(row)
    budget = study.budget
    return Chart(
        name,
        f'Exploitability of the champions, {arena}',
        f"Fresh opponents searched for against each generation's frozen champion, "
        f'{budget.searches} '
        f'searches of {budget.candidates} candidates. Above: fitness of the best one found, a '
        'lower '
        'bound on exploitability. Below: best fitness so far, averaged over the course of the '
        f'searches; lower is harder to exploit. {INTERVAL}',
        rows,
        height=1.9,
    )


def _ratings(name: str, arena: str, members: list[Replications], study: Study) -> Chart:
    marks = []
    shares = []
    for each in members:
        found = [beyond.hodge(tournament) for tournament in each.tournament]
        marks.append(
            condition_line(study.generations, np.stack([f[0] for f in found]), each, members)
        )
        shares.append(f'{each.condition.name} {np.nanmean([f[2] for f in found]):.0%}')
    panel = Panel('Rating', 'Generation', 'Rating (fitness)', marks, zero=True)
    return Chart(
        name,
        f'Transitive and cyclic parts of the tournament, {arena}',
        'Rating of each generation, playing both roles against all others: the transitive part '
        'of the Hodge decomposition of the tournament. Progress lifts it. Share of the '
        'tournament that is '
        f'cyclic (rock-paper-scissors, no rating can express it): {"; ".join(shares)}. {INTERVAL}',
        [[panel]],
    )


def _diversity(name: str, arena: str, members: list[Replications], study: Study) -> Chart:
    rows = []
    for values, ylabel, limits in (
        ('paths', 'Distance of paths (m)', None),
        ('profiles', 'Distance of profiles', None),
    ):
        row = []
        for species in SPECIES:
            marks: list[Line] = [
                condition_line(study.generations, getattr(each, values)[species], each, members)
                for each in members
            ]
            row.append(
                Panel(PLURAL[species].capitalize(), 'Generation', ylabel, marks, ylim=limits)
            )
        rows.append(row)
    return Chart(
        name,
        f'Diversity of behaviour, {arena}',
        'Above: mean distance between the paths of individuals that meet the same champion. '
        'Below: mean distance between their fitness against each opponent, the distance by which '
        'the generalist '
        f'algorithm tells opponents apart. 0 is a population of one behaviour. {INTERVAL}',
        rows,
        height=1.9,
    )
