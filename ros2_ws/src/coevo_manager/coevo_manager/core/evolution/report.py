"""The short report at the end of a run."""

from __future__ import annotations

import numpy as np

from coevo_manager.core.configuration import Configuration
from coevo_manager.core.evolution.loading import remarks
from coevo_manager.core.evolution.state import State


def write_report(
    configuration: Configuration,
    state: State,
    first: np.ndarray,
    predators_against_first: np.ndarray,
    prey_against_first: np.ndarray,
) -> str:
    """Say what a run achieved, what it cost and where it lies.

    Parameters
    ----------
    configuration : Configuration
    state : State
        At the end.
    first, predators_against_first, prey_against_first : int32 (N, N)
        Capture ticks of the random predators of generation 0 against the prey of generation 0,
        of the last predators against those prey, of those predators against the last prey.

    Returns
    -------
    str
        Markdown; it depends on nothing but the arguments.
    """
    rows = (
        ('random, generation 0', 'random, generation 0', first),
        ('evolved', 'random, generation 0', predators_against_first),
        ('random, generation 0', 'evolved', prey_against_first),
        ('evolved', 'evolved', state.capture_ticks),
    )
    table = '\n'.join(
        f'| {predators} | {prey} | {_fitness(ticks, state.pair_ticks):.3f} '
        f'| {1 - _fitness(ticks, state.pair_ticks):.3f} '
        f'| {np.mean(ticks < state.pair_ticks):.1%} |'
        for predators, prey, ticks in rows
    )
    before, after = (
        _fitness(ticks, state.pair_ticks) for ticks in (first, predators_against_first)
    )
    escaped, escapes = (
        1 - _fitness(ticks, state.pair_ticks) for ticks in (first, prey_against_first)
    )
    each = configuration.episodes_per_opponent
    summed = f', summed over the {each} episodes of a pair' if each > 1 else ''
    told = ''.join(f'* Note: {remark}.\n' for remark in remarks(configuration, state.phase))
    return f"""# What this run achieved

Algorithm {configuration.algorithm} with {configuration.optimizer}, {configuration.environment} \
arena, world {configuration.world} (motor map {configuration.motor_map}), \
seed {configuration.seed}: \
{configuration.population} predators and {configuration.population} prey, \
{configuration.selected} of them evolved at a time.

* Predators: fitness {after:.3f} against the random prey of generation 0, where random predators \
reach {before:.3f}.
* Prey: fitness {escapes:.3f} against the random predators of generation 0, where random prey \
reach {escaped:.3f}.
{told}
| predators | prey | predator fitness | prey fitness | prey caught |
|---|---|---|---|---|
{table}

Means over all {configuration.population} x {configuration.population} pairs. Predator fitness \
is 1 - t/{state.pair_ticks} and prey fitness t/{state.pair_ticks}, where t is the tick of \
the capture, {state.pair_ticks} without one{summed}. Both species improve together, so the last \
row need not rise.

## Cost

{state.phase} phases, {state.generation:,} generations, {state.episodes:,} episodes, \
{state.ticks:,} ticks ({state.ticks * 0.1 / 86400:.1f} days of robot time). This report's own \
episodes are not counted.

## Where it lies

This folder holds `generations.csv` and `phases.csv` (fitness over time), `snapshots/` (both \
populations and who beat whom), `run.json` (every setting), `checkpoint/`, `run.log`.

Analyse it with `coevo_manager analyze`, record an episode with `coevo_manager record`; \
`coevo_manager evolve --config run.json` repeats it, to the byte.
"""


def _fitness(ticks: np.ndarray, pair_ticks: int) -> float:
    """Return the predators' mean fitness."""
    return 1 - int(ticks.sum(dtype=np.int64)) / (ticks.size * pair_ticks)
