"""What a robot does, measured on the speeds that it asks of its wheels."""

from __future__ import annotations

import numpy as np

from marxbot_sim.core.parameters import TICK

SLOW = 1.0
"""Wheel speed, rad/s (2.7 cm/s): a robot whose speed is below does not drive, or does not turn."""

MEASURES = ('complexity', 'reversals', 'forward', 'backward', 'turning', 'pausing')


def complexity(wheels: np.ndarray) -> np.ndarray:
    """Return how much a behaviour varies (paper, section 4), rad/s per tick.

    With the desired translational speed (l + r) / 2 and the rotational (r - l) / 2: the sum of the
    absolute changes of both from tick to tick, from rest, over twice the number of ticks.

    Parameters
    ----------
    wheels : array_like, shape (ticks, ..., 2)
        Speeds asked of the left and right wheel, rad/s.

    Returns
    -------
    float64 array, shape (...)
    """
    translation, rotation = _speeds(wheels)
    variation = sum(
        np.abs(np.diff(speed, axis=0, prepend=0)).sum(axis=0) for speed in (translation, rotation)
    )
    return variation / (2 * len(translation))


def behaviour(wheels: np.ndarray) -> dict[str, np.ndarray]:
    """Return all `MEASURES` of a behaviour.

    Parameters
    ----------
    wheels : array_like, shape (ticks, ..., 2)
        As for `complexity`.

    Returns
    -------
    dict of str to float64 array, shape (...)
        `complexity`; `reversals`, changes between driving forward and backward (slow moments
        between do not count) in 100 s; and the shares of time in which the robot drives `forward`
        or `backward` (translation of at least `SLOW`), is `turning` on the spot (slow translation,
        rotation of at least `SLOW`) or `pausing` (neither). The four shares sum to 1.
    """
    translation, rotation = _speeds(wheels)
    direction = np.where(np.abs(translation) >= SLOW, np.sign(translation), 0.0)
    spinning = np.abs(rotation) >= SLOW
    ticks = len(direction)
    moment = np.arange(ticks).reshape(-1, *[1] * (direction.ndim - 1))
    last_driven = np.maximum.accumulate(np.where(direction != 0, moment, 0), axis=0)
    heading = np.take_along_axis(direction, last_driven, axis=0)
    changes = (heading[1:] * heading[:-1] < 0).sum(axis=0)
    return {
        'complexity': complexity(wheels),
        'reversals': changes / (ticks * TICK) * 100,
        'forward': (direction > 0).mean(axis=0),
        'backward': (direction < 0).mean(axis=0),
        'turning': ((direction == 0) & spinning).mean(axis=0),
        'pausing': ((direction == 0) & ~spinning).mean(axis=0),
    }


def _speeds(wheels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    left, right = np.moveaxis(np.asarray(wheels, float), -1, 0)
    return (left + right) / 2, (right - left) / 2
