"""Complexity of behaviour over generations and against performance (section 4, Figs. 6 and 7)."""

import numpy as np

from coevo_manager.analysis.figures.charts import MARKERS, Chart, Panel, Points
from coevo_manager.analysis.figures.marks import condition_line, in_rows
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.analysis.study import Replications, Study
from coevo_manager.core.species import COLOURS, PLURAL, SPECIES


def complexity_figure(name: str, arena: str, members: list[Replications], study: Study) -> Chart:
    """Draw Fig. 6: complexity over generations."""
    panels = []
    for species in SPECIES:
        marks = []
        for each in members:
            values = each.complexity[species]
            line = condition_line(study.generations, values, each, members)
            if len(each.runs) > 1:
                error = values.std(axis=0, ddof=1) / np.sqrt(len(values))
                line.low, line.high = line.y - error, line.y + error
            marks.append(line)
        panels.append(
            Panel(
                PLURAL[species].capitalize(), 'Generation', 'Complexity c (rad/s per tick)', marks
            )
        )
    return Chart(
        name,
        f'Behavioural complexity, {arena}',
        'Mean complexity c of the behaviour of all agents against all opponents of the same '
        'generation (Fig. 6): half the mean, over the ticks of an episode, of the change of '
        'desired translational plus rotational wheel speed. Bands: standard errors over '
        'replications.',
        [panels],
    )


def correlation_figure(name: str, arena: str, members: list[Replications], study: Study) -> Chart:
    """Draw Fig. 7: complexity and performance."""
    panels = []
    for each in members:
        marks = []
        for species in SPECIES:
            fitness = performance(each.tournament, species)[:, :, -1].mean(axis=0)
            complexity = each.complexity[species].mean(axis=0)
            marks.append(
                Points(
                    complexity,
                    fitness,
                    PLURAL[species].capitalize(),
                    COLOURS[species],
                    MARKERS[species],
                    [f'{species}, generation {g}' for g in study.generations],
                )
            )
        panels.append(
            Panel(
                each.condition.name,
                'Complexity c (rad/s per tick)',
                'Fitness vs last opponents',
                marks,
            )
        )
    return Chart(
        name,
        f'Performance and complexity, {arena}',
        'Each point is one generation, averaged over replications: complexity of its behaviour '
        'and performance against the last generation (Fig. 7). Generations of a run are not '
        'independent: see the table for correlations within each replication.',
        in_rows(panels),
    )
