"""What individuals do, measured tick by tick on a sample of each generation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from coevo_manager.analysis.play.kernel import Kernel
from coevo_manager.analysis.play.tournament import content_hash
from coevo_manager.core.behaviour import MEASURES, behaviour
from coevo_manager.core.environment import Environment
from coevo_manager.core.species import OTHER, SPECIES
from neuro_controller.core.snapshot import Snapshot

AGENTS = 20
"""Individuals of a generation whose behaviour is measured, of every rank."""

OPPONENTS = 10
"""Opponents that each of them meets, the best of a generation."""

PATH_MOMENTS = 21
PATH_INDIVIDUALS = 10

Job = tuple[str, tuple]
"""What `Evaluations.compute` takes: a digest of all that the result depends on, and arguments."""


def of_every_rank(snapshot: Snapshot, species: str, count: int) -> np.ndarray:
    """Return the genomes of `count` individuals, evenly spaced in the ranking, best first."""
    ranking = snapshot.ranking(species)
    places = np.linspace(0, len(ranking) - 1, min(count, len(ranking))).round().astype(int)
    return snapshot.population(species)[ranking[places]]


def without_sensor_noise(environment: Environment) -> Environment:
    """Return the environment with sensors that tell the truth; starts and motors stay as they are.

    Noise alone makes wheel speeds vary, and so hides what behaviour there is.
    """
    quiet = replace(
        environment.perturbations, infrared_noise=0.0, camera_noise=0.0, ground_noise=0.0
    )
    return replace(environment, perturbations=quiet)


def sample(kernel: Kernel, function: Callable[..., np.ndarray], *arguments: Any) -> np.ndarray:
    """Carry out a job of either kind."""
    return function(kernel, *arguments)


def behaviour_job(
    agents: Snapshot, opponents: Snapshot, species: str, environment: Environment
) -> Job:
    """Individuals of every rank of one generation against the best opponents of another."""
    pair = (
        of_every_rank(agents, species, AGENTS),
        opponents.best(OTHER[species], OPPONENTS),
    )
    quiet = without_sensor_noise(environment)
    digest = content_hash('behaviour', species, asdict(quiet), *pair)
    return digest, (sample_behaviour, *pair, species, quiet)


def sample_behaviour(
    kernel: Kernel,
    agents: np.ndarray,
    opponents: np.ndarray,
    species: str,
    environment: Environment,
) -> np.ndarray:
    """Measure the agents' behaviour, each against each opponent.

    Returns
    -------
    float64 (1 + 6,)
        Number of episodes that no capture ended, and the mean of each of `behaviour.MEASURES` over
        them; NaN where there are none. Only these are of equal length: a capture ends an episode
        early, in which the start from rest then weighs more.
    """
    own, other = np.indices((len(agents), len(opponents))).reshape(2, -1)
    if species == 'predator':
        traces = kernel.traces(agents, opponents, own, other, environment)
    else:
        traces = kernel.traces(opponents, agents, other, own, environment)
    robot = SPECIES.index(species)
    found = [
        [measures[name] for name in MEASURES]
        for trace in traces
        if not trace.captured
        for measures in [behaviour(trace.wheels[:, robot])]
    ]
    means = np.mean(found, axis=0) if found else np.full(len(MEASURES), np.nan)
    return np.concatenate([[len(found)], means])


def paths_job(snapshot: Snapshot, species: str, environment: Environment) -> Job:
    """Individuals of every rank against the champion of the same generation."""
    genomes = of_every_rank(snapshot, species, PATH_INDIVIDUALS)
    champion = snapshot.best(OTHER[species], 1)
    digest = content_hash('paths', species, asdict(environment), genomes, champion)
    return digest, (sample_paths, genomes, champion, species, environment)


def sample_paths(
    kernel: Kernel,
    genomes: np.ndarray,
    champion: np.ndarray,
    species: str,
    environment: Environment,
) -> np.ndarray:
    """Positions (n, 21, 2) of n individuals at equal times over the longest episode, m.

    After a capture the position stays what it was.
    """
    own, other = np.arange(len(genomes)), np.zeros(len(genomes), int)
    if species == 'predator':
        traces = kernel.traces(genomes, champion, own, other, environment)
    else:
        traces = kernel.traces(champion, genomes, other, own, environment)
    moments = np.linspace(0, environment.episode_ticks, PATH_MOMENTS).round().astype(int)
    robot = SPECIES.index(species)
    return np.array([trace.poses[np.minimum(moments, trace.ticks), robot, :2] for trace in traces])
