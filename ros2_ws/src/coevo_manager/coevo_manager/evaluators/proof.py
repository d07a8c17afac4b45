"""How answers are proved: by their form, by known episodes, by playing one episode again."""

from __future__ import annotations

import numpy as np

from coevo_manager.core.evaluation import Batch, Lineages, all_pairs
from neuro_controller.core.genome import LAYOUT, Layout, random_genomes


def fault(
    work: Batch | Lineages, success: bool, message: str, ticks: np.ndarray, episode_ticks: int
) -> str:
    """Return what is wrong with an answer, as a clause that begins with a verb; '' if nothing.

    Parameters
    ----------
    work : Batch or Lineages
        What was asked.
    success, message
        Whether the evaluator says it has played, and if not, why.
    ticks : int32 (n,)
        Its capture ticks.
    episode_ticks : int
        Length of an episode.
    """
    if not success:
        return f'refused its work: {message}'
    if len(ticks) != len(work):
        return f'answered {len(ticks)} episodes of {len(work)}'
    wrong = (ticks < 1) | (ticks > episode_ticks)
    if wrong.any():
        return f'answered tick {ticks[wrong][0]}, expected 1 to {episode_ticks}'
    return ''


def known_episodes(layout: Layout = LAYOUT) -> Batch:
    """Return the episodes by which evaluators are compared: sixteen pairs of random genomes."""
    rng = np.random.default_rng(0)
    pairs = np.arange(16, dtype=np.uint32)
    predators, prey = (random_genomes(16, rng, layout) for _ in range(2))
    return Batch(predators, prey, pairs, pairs)


def sample(
    work: Batch | Lineages, ticks: np.ndarray, rng: np.random.Generator
) -> tuple[Batch, int]:
    """Draw one episode of an answer; return it and the tick at which it is said to have ended."""
    episode = int(rng.integers(len(work)))
    if isinstance(work, Lineages):
        candidate, opponent = divmod(episode, len(work.opponents))
        ours = work.offspring(ticks)[candidate : candidate + 1]
        batch = all_pairs(work.species, ours, work.opponents[opponent : opponent + 1], work.noise)
    else:
        alone = np.zeros(1, np.uint32)
        predator, prey = work.predator_index[episode], work.prey_index[episode]
        batch = Batch(
            work.predators[predator : predator + 1],
            work.prey[prey : prey + 1],
            alone,
            alone,
            work.noise,
        )
    return batch, int(ticks[episode])
