"""How champions fare outside the world they evolved in: other physics, imperfect robots."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from coevo_manager.analysis.measures.statistics import bootstrap_interval
from coevo_manager.analysis.runs import AnalysisError, Replication
from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes import evaluate_matrix
from coevo_manager.core.species import SPECIES
from marxbot_sim.core.perturbations import PERFECT, Perturbations

KERNEL = 'kernel'
"""The condition that others are compared with: kinematic physics, perfect robots."""

STANDARD: dict[str, dict[str, Any]] = {
    'wheels 5 % smaller': {'wheel_radius_scale': 0.95},
    'wheels 5 % larger': {'wheel_radius_scale': 1.05},
    'wheels 5 % closer': {'wheel_separation_scale': 0.95},
    'wheels 5 % farther': {'wheel_separation_scale': 1.05},
    'sensor noise': {'infrared_noise': 0.005, 'camera_noise': 0.05, 'ground_noise': 0.05},
    'motor noise': {'motor_noise': 0.1},
    'commands a tick late': {'latency_ticks': 1},
    'weak battery': {'battery': 0.9},
    'lost commands': {'command_loss': 0.1},
    'displaced starts': {'start_displacement': 0.2, 'start_rotation': 0.5},
}
"""The standard perturbations, fields of `Perturbations` by name."""

ALL = {
    name: value
    for kind, fields in STANDARD.items()
    if kind not in ('wheels 5 % larger', 'wheels 5 % closer')
    for name, value in fields.items()
}
"""All of them at once, the wheels smaller and farther from each other."""

_RANDOM = (
    'infrared_noise', 'camera_noise', 'ground_noise', 'motor_noise', 'command_loss',
    'start_displacement', 'start_rotation',
)  # fmt: skip


@dataclass(frozen=True)
class Target:
    """A world to transfer to.

    Attributes
    ----------
    name : str
    physics : str
        'kinematic' or 'pymunk'.
    perturbed : str
        Whom `fields` affect: 'both', 'predator' or 'prey'.
    fields : dict
        Fields of `Perturbations`.
    """

    name: str
    physics: str
    perturbed: str
    fields: dict[str, Any]

    def environments(self, environment: Environment, draws: int) -> list[Environment]:
        """Return the environment as it is there, once for each seed if anything is random."""
        seeds = range(draws) if any(name in self.fields for name in _RANDOM) else [0]
        perfect = replace(environment, physics=self.physics, perturbations=PERFECT)
        return [
            replace(
                perfect,
                perturbations=Perturbations(**self.fields, robots=self.perturbed, seed=seed + 1),
            )
            for seed in seeds
        ]


def targets() -> list[Target]:
    """Return all conditions, `KERNEL` first."""
    singly = {**STANDARD, 'all perturbations': ALL}
    return [
        Target(KERNEL, 'kinematic', 'both', {}),
        Target('pymunk', 'pymunk', 'both', {}),
        *(
            Target(name, 'kinematic', perturbed, fields)
            for name, fields in singly.items()
            for perturbed in (*SPECIES, 'both')
        ),
        Target('pymunk, all perturbations', 'pymunk', 'both', ALL),
    ]


def champions(run: Replication, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the fittest predators and prey of a run's last snapshot, float32 (count, genes) each.

    Raises
    ------
    AnalysisError
        The run has no snapshot, or fewer individuals.
    """
    if not run.snapshots:
        raise AnalysisError(f'{run.folder} has no snapshot')
    snapshot = run.snapshot(max(run.snapshots))
    if count > len(snapshot.predators):
        raise AnalysisError(
            f'champions is {count}, expected at most {len(snapshot.predators)}, the population '
            f'of {run.folder}'
        )
    return snapshot.best('predator', count), snapshot.best('prey', count)


def measure_transfer(
    runs: Sequence[Replication],
    count: int,
    draws: int,
    threads: int,
    advance: Callable[[], object] = lambda: None,
) -> pd.DataFrame:
    """Let the champions of all runs meet in every condition.

    Parameters
    ----------
    runs : sequence of Replication
        All of one arena. Each champion meets the champions of all runs, so that runs compare.
    count : int
        Champions of each species and run.
    draws : int
        Seeds of conditions that are random; the fitness is the mean over them.
    threads : int
    advance : callable
        Called after each condition.

    Returns
    -------
    DataFrame
        For each run, condition, perturbed robots and species: the champions' mean `fitness`, its
        `change` from the kernel with a 95 % bootstrap interval over champions, `low` to `high`
        (NaN of a single one), and the `rank_correlation` (Spearman) of the champions' fitness
        here and in the kernel.

    Raises
    ------
    AnalysisError
        The runs' arenas differ, or a run cannot be used.
    """
    environment = _common_environment(runs)
    chosen = [champions(run, count) for run in runs]
    predators, prey = (np.concatenate(parts) for parts in zip(*chosen, strict=True))
    rows: list[dict[str, Any]] = []
    reference: dict[str, np.ndarray] = {}
    for condition in targets():
        survival = np.mean(
            [
                evaluate_matrix(predators, prey, each, threads) / each.episode_ticks
                for each in condition.environments(environment, draws)
            ],
            axis=0,
        )
        fitness = {'predator': 1 - survival.mean(axis=1), 'prey': survival.mean(axis=0)}
        reference = reference or fitness
        for species in SPECIES:
            parts = zip(
                runs,
                np.split(fitness[species], len(runs)),
                np.split(reference[species], len(runs)),
                strict=True,
            )
            for run, here, there in parts:
                rows.append(
                    {
                        'run': run.name,
                        'condition': condition.name,
                        'perturbed': condition.perturbed,
                        'species': species,
                    }
                    | _compare(here, there)
                )
        advance()
    return pd.DataFrame(rows)


def _common_environment(runs: Sequence[Replication]) -> Environment:
    worlds = [replace(run.environment, physics='kinematic', perturbations=PERFECT) for run in runs]
    for run, world in zip(runs, worlds, strict=True):
        if world != worlds[0]:
            raise AnalysisError(
                f'{runs[0].folder} and {run.folder} differ in arena, motors or episode length: '
                'expected runs of one environment, but for physics and perturbations'
            )
    return worlds[0]


def _compare(here: np.ndarray, there: np.ndarray) -> dict[str, float]:
    change = here - there
    low, high = bootstrap_interval(change)
    varies = np.ptp(here) > 0 and np.ptp(there) > 0
    return {
        'fitness': here.mean(),
        'change': change.mean(),
        'low': low,
        'high': high,
        'rank_correlation': stats.spearmanr(here, there).statistic if varies else np.nan,
    }


def perturbed_alone(table: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each run, condition and species: that in which it alone is perturbed.

    Under conditions that have only one variant, it is the row in which both are.
    """
    alone = table[(table.perturbed == table.species) | (table.perturbed == 'both')]
    return alone.drop_duplicates(['run', 'condition', 'species'])


def hurt(table: pd.DataFrame) -> pd.Series:
    """Return who is hurt, by run and condition: those who do worse when they are perturbed.

    A species counts as hurt where the whole interval of its change lies below 0, with itself
    perturbed alone, or, under conditions that have only one variant, with everybody.
    """
    own = perturbed_alone(table)
    worse = own[own.high < 0]
    return worse.groupby(['run', 'condition'], sort=False).species.agg(' and '.join)
