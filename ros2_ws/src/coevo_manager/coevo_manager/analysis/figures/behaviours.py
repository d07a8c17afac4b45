"""Fig. 5: representative behaviours, from the simplest to the most complex."""

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from coevo_manager.analysis.figures.draw import STYLE
from coevo_manager.analysis.measures.paper import representative
from coevo_manager.analysis.study import Replications, tournament_block
from coevo_manager.core.species import COLOURS, SPECIES
from marxbot_sim.core.parameters import BODY_RADIUS, OBSTACLE_RADIUS, TICK

TITLES = ('simplest', 'simple', 'median', 'complex', 'most complex')
CAPTION = (
    'Episodes of the last generation of the first replication at the 0th, 25th, 50th, 75th and '
    '100th '
    "percentile of the predator's (A) and of the prey's (B) complexity (Fig. 5). Light disc: "
    'start; dark '
    'disc: end. Below each: translational (above) and rotational (below) wheel speed over time, '
    'rad/s. '
    "Solid: predator; dashed: prey. Numbers: each robot's complexity c, rad/s per tick."
)


def behaviours(each: Replications, evaluations) -> Figure:
    """Draw the five representative episodes by the complexity of each species."""
    run, last = each.runs[0], each.snapshots[0][-1]
    complexity = evaluations[tournament_block(run, last, last)].complexity
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.0, 5.6), layout='constrained')
        for part, species in zip(figure.subfigures(2, 1), SPECIES, strict=True):
            letter = 'AB'[SPECIES.index(species)]
            part.suptitle(
                f'{letter}  By the complexity of the {species}',
                x=0.01,
                ha='left',
                fontsize=8.5,
                weight='bold',
            )
            axes = part.subplots(3, 5, height_ratios=[4, 1, 1])
            for column, (i, j) in enumerate(
                representative(complexity[..., SPECIES.index(species)])
            ):
                trace = evaluations.kernel.trace(last.predators[i], last.prey[j], run.environment)
                _arena(axes[0, column], trace, run.environment.arena)
                c = complexity[i, j]
                axes[0, column].set_title(
                    f'{TITLES[column]}\n{c[0]:.2f} | {c[1]:.2f}', fontsize=7, weight='normal'
                )
                _speeds(axes[1:, column], trace, first=column == 0)
    return figure


def _arena(axes, trace, arena) -> None:
    half = arena.size / 2
    axes.add_patch(Rectangle((-half, -half), arena.size, arena.size, fill=False, linewidth=1))
    if arena.obstacle:
        axes.add_patch(Circle((0, 0), OBSTACLE_RADIUS, color='#555555'))
    poses = np.asarray(trace.poses)
    for robot, species in enumerate(SPECIES):
        path = poses[:, robot, :2]
        dashes = '-' if species == 'predator' else (0, (3, 1.2))
        axes.plot(*path.T, color=COLOURS[species], linestyle=dashes, linewidth=0.7)
        for place, alpha in ((path[0], 0.3), (path[-1], 1.0)):
            axes.add_patch(
                Circle(place, BODY_RADIUS, color=COLOURS[species], alpha=alpha, linewidth=0)
            )
    margin = half * 1.03
    axes.set(xlim=(-margin, margin), ylim=(-margin, margin), aspect='equal')
    axes.axis('off')


def _speeds(axes, trace, first: bool) -> None:
    wheels = np.asarray(trace.wheels)
    time = np.arange(1, len(wheels) + 1) * TICK
    for robot, species in enumerate(SPECIES):
        left, right = wheels[:, robot].T
        dashes = '-' if species == 'predator' else (0, (3, 1.2))
        for axis, speed in zip(axes, ((left + right) / 2, (right - left) / 2), strict=True):
            axis.plot(time, speed, color=COLOURS[species], linestyle=dashes, linewidth=0.5)
    for axis, name in zip(axes, ('trans.', 'rot.'), strict=True):
        axis.set_ylim(-10.5, 10.5)
        axis.set_yticks([-10, 0, 10], ['-10', '0', '10'] if first else [])
        axis.set_ylabel(name if first else '')
        axis.tick_params(labelsize=6, length=2)
    axes[0].set_xticklabels([])
    axes[1].set_xlabel('s', fontsize=7)
