"""Every result as a tidy table: one observation a row, for CSV files and the report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from coevo_manager.analysis.conditions import Condition, slug
from coevo_manager.analysis.measures import beyond, statistics
from coevo_manager.analysis.measures.cross import cross_values
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.analysis.play.probe import best_found, candidates_needed, while_searching
from coevo_manager.analysis.report import games, progress
from coevo_manager.analysis.runs import Replication
from coevo_manager.analysis.study import FACED, ConditionResults, Study
from coevo_manager.core.behaviour import MEASURES
from coevo_manager.core.evolution.files import write_whole
from coevo_manager.core.species import OTHER, SPECIES

Values = Callable[[ConditionResults, str], np.ndarray]
"""Curves (R, S) of a condition and species."""


@dataclass
class Table:
    """A result in rows.

    Attributes
    ----------
    kind : str
        What it holds, such as 'verdicts' or 'table1'.
    frame : pandas.DataFrame
    arena : str, optional
        Where all of it belongs to one arena.
    test : str, optional
        The test whose p-values it rests on, 'paper' or 'paired_holm'.
    """

    kind: str
    frame: pd.DataFrame
    arena: str | None = None
    test: str | None = None

    @property
    def name(self) -> str:
        """Name of its file."""
        parts = (self.kind, slug(self.arena) if self.arena else None, self.test)
        return '_'.join(part for part in parts if part)


def write(table: pd.DataFrame, path: Path) -> None:
    """Write a CSV file."""
    text = table.to_csv(index=False, float_format='%.6g', lineterminator='\n')
    write_whole(path, text.encode())


def runs(study: Study) -> pd.DataFrame:
    """What each run was and cost; `reproduced`: this kernel gives the fitness the run stored."""
    rows = []
    for each in study.conditions:
        for run, reproduced in zip(each.runs, each.reproduced, strict=True):
            cost = run.table('phases').iloc[-1]
            rows.append(
                _keys(each, run)
                | {
                    'run': run.name,
                    'population': run.configuration.population,
                    'selected': run.configuration.selected,
                    'generations': int(cost['generation']),
                    'episodes': int(cost['episodes']),
                    'ticks': int(cost['ticks']),
                    'reproduced': reproduced,
                    'never_evolved': ' and '.join(run.never_evolved),
                    'evolved_with': run.versions,
                }
            )
    return pd.DataFrame(rows)


def master_tournament(study: Study) -> pd.DataFrame:
    """Figs. 3 and 8: mean predator fitness of each pair of generations."""
    size = len(study.generations)
    rows, columns = np.indices((size, size)).reshape(2, -1)
    parts = []
    for each in study.conditions:
        for run, tournament in zip(each.runs, each.tournament, strict=True):
            part = pd.DataFrame(
                {
                    'predator_generation': study.generations[rows],
                    'prey_generation': study.generations[columns],
                    'predator_fitness': tournament[rows, columns],
                }
            )
            parts.append(part.assign(**_keys(each, run)))
    return _first(pd.concat(parts, ignore_index=True), 'arena', 'condition', 'seed')


def cross_experiment(study: Study) -> pd.DataFrame:
    """Fig. 4: predator fitness between the last generations of runs of one environment."""
    runs = {run.folder: (each, run) for each in study.conditions for run in each.runs}
    rows = []
    for (predators, prey), fitness in study.cross.items():
        (one, first), (other, second) = runs[predators], runs[prey]
        rows.append(
            {
                'arena': one.condition.arena,
                'predators_condition': one.condition.name,
                'predators_seed': first.seed,
                'prey_condition': other.condition.name,
                'prey_seed': second.seed,
                'predator_fitness': fitness,
            }
        )
    return pd.DataFrame(rows)


def cross_tests(study: Study) -> pd.DataFrame:
    """Fig. 4's tests: agents against another condition's opponents and against their own's.

    `opponents`: "all" counts a run's own opponents among its condition's, as the paper does;
    "held-out" leaves them out, since it co-evolved with them.
    """
    rows = []
    for members in study.arenas().values():
        for each in members:
            for other in members:
                if other is each:
                    continue
                ours, theirs = ([run.folder for run in group.runs] for group in (each, other))
                for species in SPECIES:
                    for opponents, own in (('all', True), ('held-out', False)):
                        tests = statistics.compare_paired(
                            [cross_values(ours, theirs, species, study.cross, own)],
                            [cross_values(ours, ours, species, study.cross, own)],
                        )
                        keys = {
                            'arena': each.condition.arena,
                            'agents': each.condition.name,
                            'against': other.condition.name,
                            'species': species,
                            'opponents': opponents,
                        }
                        rows.append(keys | tests.iloc[0].to_dict())
    table = pd.DataFrame(rows)
    for column in ('p_paired', 'p_sign_flip') if len(table) else ():
        table[f'{column}_holm'] = statistics.holm(table[column])
    return table


def complexity(study: Study) -> pd.DataFrame:
    """Fig. 6: mean complexity of each generation, rad/s per tick."""
    return _curves(study, 'complexity', lambda each, species: each.complexity[species])


def behaviour(study: Study) -> pd.DataFrame:
    """What a sample of each generation does, without sensor noise, see `play.behaviours`.

    `opponents`: the best of the same generation (contemporaries), or of the last generation of the
    run (fixed). `episodes`: those that no capture ended, over which the means are.
    """
    keys = ['arena', 'condition', 'seed', 'species', 'generation']
    parts = []
    for faced in FACED:
        columns = [
            _curves(study, name, _of_behaviour(faced, name)) for name in ('episodes', *MEASURES)
        ]
        part = columns[0]
        for column in columns[1:]:
            part = part.merge(column, on=keys)
        parts.append(part.assign(opponents=faced))
    return _first(pd.concat(parts, ignore_index=True), *keys, 'opponents')


def complexity_condition_tests(study: Study) -> pd.DataFrame:
    """Is the last generation of one condition more complex than another's? (section 4)."""
    rows = []
    for members in study.arenas().values():
        for each in members:
            for other in members:
                if other is each:
                    continue
                for species in SPECIES:
                    keys = {
                        'arena': each.condition.arena,
                        'more_complex': each.condition.name,
                        'than': other.condition.name,
                        'species': species,
                    }
                    tests = statistics.compare_groups(
                        each.complexity[species][:, -1], other.complexity[species][:, -1]
                    )
                    rows.append(keys | tests)
    table = pd.DataFrame(rows)
    if len(table):
        table['p_welch_holm'] = statistics.holm(table['p_welch'])
    return table


def complexity_correlation(study: Study) -> pd.DataFrame:
    """Fig. 7: complexity against performance, of the mean over replications and of each."""
    rows = []
    for each in study.conditions:
        for species in SPECIES:
            fitness = performance(each.tournament, species)[:, :, -1]
            keys = {
                'arena': each.condition.arena,
                'condition': each.condition.name,
                'species': species,
            }
            pairs = [('mean', each.complexity[species].mean(axis=0), fitness.mean(axis=0))]
            for run, c, f in zip(each.runs, each.complexity[species], fitness, strict=True):
                pairs.append((str(run.seed), c, f))
            for seed, c, f in pairs:
                r, p, low, high = statistics.correlation(c, f)
                found = {'r': r, 'r_low': low, 'r_high': high, 'p_two_tailed': p}
                rows.append(keys | {'seed': seed, 'generations': len(c)} | found)
    return pd.DataFrame(rows)


def held_out(study: Study) -> pd.DataFrame:
    """Fitness of each generation against the elites of other runs' last generation."""
    parts = []
    for each in study.conditions:
        sources = {s.name: s for species in SPECIES for s in each.held_out[species]}
        for name, source in sources.items():
            part = _curves_of(study, each, 'fitness', _of_held_out(source))
            parts.append(part.assign(opponents=name))
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()


def exploitability(study: Study) -> pd.DataFrame:
    """What fresh opponents reached against each generation's champion of `species`."""
    if study.budget is None:
        return pd.DataFrame()
    table = _curves(study, 'best_found', lambda each, s: best_found(each.probes[s]))
    anytime = _curves(
        study, 'mean_while_searching', lambda each, s: while_searching(each.probes[s])
    )
    table['mean_while_searching'] = anytime['mean_while_searching']
    table['candidates_needed'] = _curves(
        study, 'candidates_needed', lambda each, s: candidates_needed(each.probes[s])
    )['candidates_needed']
    return table.assign(
        responder=table['species'].map(OTHER),
        candidates=study.budget.candidates,
        searches=study.budget.searches,
    )


def diversity(study: Study) -> pd.DataFrame:
    """Distances within a population: of paths (m) and of fitness profiles (0 to 1)."""
    table = _curves(study, 'path_distance', lambda each, species: each.paths[species])
    profiles = _curves(study, 'profile_distance', lambda each, species: each.profiles[species])
    return table.merge(profiles, on=['arena', 'condition', 'seed', 'species', 'generation'])


def retrogression(study: Study) -> pd.DataFrame:
    """How often and how much steps between generations lose ground, of each run."""
    rows = []
    for each in study.conditions:
        for species in SPECIES:
            rates, losses = beyond.retrogression(each.tournament, species)
            for run, rate, loss in zip(each.runs, rates, losses, strict=True):
                rows.append(
                    _keys(each, run)
                    | {'species': species, 'rate_of_retrogression': rate, 'share_lost': loss}
                )
    return pd.DataFrame(rows)


def cyclicity(study: Study) -> pd.DataFrame:
    """Rating of each generation and the cyclic share of the tournament, of each run."""
    parts = []
    for each in study.conditions:
        for run, tournament in zip(each.runs, each.tournament, strict=True):
            rating, _, share = beyond.hodge(tournament)
            part = pd.DataFrame({'generation': study.generations, 'rating': rating})
            parts.append(part.assign(**_keys(each, run), cyclic_share=share))
    return _first(pd.concat(parts, ignore_index=True), 'arena', 'condition', 'seed')


def all_tables(study: Study) -> dict[str, Table]:
    """Every table by the name of its file; empty ones left out."""
    functions = (
        runs,
        master_tournament,
        cross_experiment,
        cross_tests,
        complexity,
        complexity_condition_tests,
        complexity_correlation,
        behaviour,
        held_out,
        exploitability,
        diversity,
        retrogression,
        cyclicity,
        games.nash_averaging,
        games.alpha_rank,
        games.meta_exploitability,
        games.effective_diversity,
        games.league,
    )
    tests = progress.generation_tests(study)
    tables = [
        *(Table(function.__name__, function(study)) for function in functions),
        Table('verdicts', progress.verdicts(study)),
        Table('generation_tests', tests),
        Table('durations', progress.durations(study, tests)),
    ]
    for arena in study.arenas():
        for kind, measure in (('table1', 'historical'), ('table2', 'global')):
            for column, test in (('p_paper', 'paper'), ('p_paired_holm', 'paired_holm')):
                frame = progress.progress_table(tests, arena, measure, column)
                tables.append(Table(kind, frame, arena, test))
    return {table.name: table for table in tables if len(table.frame)}


def _of_behaviour(faced: str, measure: str) -> Values:
    return lambda each, species: each.behaviour[faced][species][measure]


def _of_held_out(source: Condition) -> Values:
    return lambda each, species: each.held_out[species][source]


def _keys(each: ConditionResults, run: Replication) -> dict[str, Any]:
    return {'arena': each.condition.arena, 'condition': each.condition.name, 'seed': run.seed}


def _curves(study: Study, column: str, values: Values) -> pd.DataFrame:
    parts = [_curves_of(study, each, column, values) for each in study.conditions]
    return pd.concat(parts, ignore_index=True)


def _curves_of(study: Study, each: ConditionResults, column: str, values: Values) -> pd.DataFrame:
    """Curves (R, S) of both species of a condition, one row a generation and run."""
    parts = []
    for species in SPECIES:
        for run, curve in zip(each.runs, values(each, species), strict=True):
            part = pd.DataFrame({'generation': study.generations, column: curve})
            parts.append(part.assign(**_keys(each, run), species=species))
    return _first(pd.concat(parts, ignore_index=True), 'arena', 'condition', 'seed', 'species')


def _first(table: pd.DataFrame, *columns: str) -> pd.DataFrame:
    rest = [column for column in table.columns if column not in columns]
    return table[[*columns, *rest]]
