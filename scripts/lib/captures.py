"""What scripts/captures does; see there."""

import sys

import numpy as np
import pandas as pd
from marked_pages import MarkedPage, make_parser, markdown

from coevo_manager.analysis.runs import by_condition, read_runs
from coevo_manager.core.episodes.traces import trace_pairs
from marxbot_sim.core.parameters import BODY_RADIUS, TICK, WHEEL_RADIUS

BEST = 10
"""Individuals of each species and generation that meet."""

AT_A_WALL = 0.05
"""Distance of a rim from a wall, m, up to which a robot is at the wall."""

BEFORE = round(1 / TICK)
"""Ticks before a capture that are looked at."""

MEETINGS = {
    'early predators, early prey': (0, 0),
    'late predators, early prey': (1, 0),
    'early predators, late prey': (0, 1),
    'late predators, late prey': (1, 1),
}
COLUMNS = {
    'caught': 'caught',
    'seconds': 'after, s (median)',
    'at_wall': 'at a wall',
    'away': 'prey moving away',
    'from_behind': 'from behind',
    'prey_speed': 'prey, m/s',
    'predator_speed': 'predator, m/s',
    'prey_backward': 'prey backward',
    'predator_backward': 'predator backward',
    'walls': 'prey at a wall in all ticks',
}


def wall_distance(positions, size):
    """Return how far the rim of a robot is from the nearest wall, m."""
    return size / 2 - BODY_RADIUS - np.abs(positions).max(axis=-1)


def describe(trace, size):
    """Return what happened in an episode, and how it ended if in a capture."""
    prey = trace.poses[:, 1, :2]
    found = {
        'caught': trace.captured,
        'walls': (wall_distance(prey, size) <= AT_A_WALL).mean(),
    }
    if not trace.captured:
        return found
    before = max(trace.ticks - BEFORE, 0)
    offset = trace.poses[before, 0, :2] - trace.poses[before, 1, :2]
    moved = prey[-1] - prey[before]
    heading = trace.poses[before, 1, 2]
    ahead = offset @ [np.cos(heading), np.sin(heading)]
    translation = trace.wheels[before:].mean(axis=(0, 2)) * WHEEL_RADIUS
    return found | {
        'seconds': trace.ticks * TICK,
        'at_wall': wall_distance(prey[-1], size) <= AT_A_WALL,
        'away': moved @ offset < 0,
        'from_behind': ahead < 0,
        'predator_speed': abs(translation[0]),
        'prey_speed': abs(translation[1]),
        'predator_backward': translation[0] < 0,
        'prey_backward': translation[1] < 0,
    }


def meet(run, early):
    """Return a table of the episodes of a run, with the column `meeting`."""
    generations = [max(g for g in run.snapshots if g <= early), max(run.snapshots)]
    snapshots = [run.snapshot(generation) for generation in generations]
    environment = run.environment
    rows = []
    for meeting, (hunter, hunted) in MEETINGS.items():
        predators = snapshots[hunter].best('predator', BEST)
        prey = snapshots[hunted].best('prey', BEST)
        pairs = np.indices((len(predators), len(prey))).reshape(2, -1)
        for trace in trace_pairs(predators, prey, *pairs, environment):
            rows.append({'meeting': meeting, **describe(trace, environment.arena.size)})
    return pd.DataFrame(rows)


def summarise(episodes):
    """Return the means over runs of each measure's mean within a run, by meeting."""
    numbers = episodes.astype({name: float for name in COLUMNS if name != 'seconds'})
    groups = numbers.groupby(['meeting', 'run'], sort=False)
    means = groups[[name for name in COLUMNS if name != 'seconds']].mean()
    means['seconds'] = groups.seconds.median()
    return means.groupby('meeting', sort=False).mean()[list(COLUMNS)]


def cell(name, value):
    """Return a number as text."""
    if np.isnan(value):
        return ''
    if name in ('prey_speed', 'predator_speed'):
        return f'{value:.2f}'
    return f'{value:.1f}' if name == 'seconds' else f'{value:.0%}'


def main():
    """Run the script."""
    parser = make_parser('captures')
    parser.add_argument('--early', type=int, default=10_000)
    options = parser.parse_args()
    try:
        page = MarkedPage(options.page, 'captures')
        text = ''
        for condition, members in by_condition(read_runs(options.runs)).items():
            episodes = pd.concat(
                [meet(run, options.early).assign(run=number) for number, run in enumerate(members)]
            )
            table = summarise(episodes)
            rows = [
                [meeting, *(cell(name, row[name]) for name in COLUMNS)]
                for meeting, row in table.iterrows()
            ]
            seeds = f'{len(members)} {"seed" if len(members) == 1 else "seeds"}'
            text += f'{condition.name}, {condition.arena}, {seeds}:\n\n'
            text += markdown(['who meets', *COLUMNS.values()], rows) + '\n'
        page.fill(text)
    except (ValueError, OSError) as error:
        print(f'captures: {error}', file=sys.stderr)
        return 2
    return 0


if __name__ == '__main__':
    sys.exit(main())
