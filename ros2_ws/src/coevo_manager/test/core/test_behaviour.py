"""Measures of behaviour by hand."""

import numpy as np
import pytest

from coevo_manager.core.behaviour import MEASURES, behaviour, complexity


def test_complexity_by_hand():
    # From rest: tv 0 -> 2 -> 2, rv 0 -> 1 -> -1: |2| + |1| + |0| + |-2| = 5, over 2 * 2 ticks.
    assert complexity([[1, 3], [3, 1]]) == pytest.approx(5 / 4)


def test_what_a_robot_does_by_hand():
    forward, backward, turn, pause = (4, 5), (-4, -3), (-2, 2), (0.5, 0.2)
    ticks = [pause, forward, forward, turn, backward, pause, backward, pause, forward, forward]
    found = behaviour(np.array(ticks))
    assert tuple(found) == MEASURES
    assert found['forward'] == pytest.approx(0.4)
    assert found['backward'] == pytest.approx(0.2)
    assert found['turning'] == pytest.approx(0.1)
    assert found['pausing'] == pytest.approx(0.3)
    # Forward, backward (once, with a pause in it), forward: 2 reversals in 1 s.
    assert found['reversals'] == pytest.approx(200)


def test_a_reversal_through_rest_counts_once_and_rest_alone_never():
    assert behaviour([(5, 5), (0, 0), (0, 0), (-5, -5)])['reversals'] == pytest.approx(250)
    assert behaviour([(5, 5), (0, 0), (5, 5), (0, 0)])['reversals'] == 0


def test_many_robots_at_once_are_as_each_alone():
    wheels = np.random.default_rng(1).uniform(-10, 10, (50, 3, 2, 2))
    together = behaviour(wheels)
    for i in range(3):
        for robot in range(2):
            alone = behaviour(wheels[:, i, robot])
            for name in MEASURES:
                assert together[name][i, robot] == pytest.approx(alone[name])
