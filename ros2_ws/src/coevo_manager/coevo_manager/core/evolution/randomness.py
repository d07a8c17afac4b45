"""Every random draw of a run, by the place it belongs to.

A generator is a function of the run's seed and of what it is for, so that no result depends on
the order in which evaluators answer, and a resumed run draws what it would have drawn.
"""

from __future__ import annotations

import numpy as np

_PURPOSES = (
    'first predators',
    'first prey',
    'opponents',
    'agent',
    'drawn opponents',
    'leaving',
)


def generator(seed: int, purpose: str, *path: int) -> np.random.Generator:
    """Return the generator for a purpose.

    Parameters
    ----------
    seed : int
        The run's seed.
    purpose : str
        ``'first predators'``, ``'first prey'``, ``'opponents'`` of a phase, ``'agent'`` of a
        phase, ``'drawn opponents'`` of an agent in a generation of a phase, or ``'leaving'`` an
        archive in a generation of a phase.
    path : int
        Phase, agent, generation of the phase from 0, as far as the purpose has them.
    """
    key = (_PURPOSES.index(purpose), *path)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=key)))
