"""The elementary functions over their whole range against float64."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

import simd_lanes
from simd_lanes import (
    arcsine,
    arctan2,
    cosine,
    load,
    logistic,
    reciprocal,
    sine_over,
    store,
)

F = np.float32


def over(function):
    """A function of float32 arrays of any multiple of 16 values."""

    @numba.njit
    def one(a, out):
        for row in range(a.shape[0]):
            store(out, row, function(load(a, row)))

    @numba.njit
    def two(a, b, out):
        for row in range(a.shape[0]):
            store(out, row, function(load(a, row), load(b, row)))

    def apply(*arrays):
        rows = [np.ascontiguousarray(values, F).reshape(-1, 16) for values in arrays]
        out = np.empty_like(rows[0])
        (one, two)[len(arrays) - 1](*rows, out)
        return out.reshape(-1)

    return apply


def every(start, stop, step=1):
    """The float32 between two positive ones, every ``step``-th."""
    first, last = F([start, stop]).view(np.uint32)
    values = np.arange(first, last, step, dtype=np.uint32).view(F)
    return values[: len(values) // 16 * 16]


def ulps(result, exact):
    return np.abs(result - exact) / np.spacing(np.abs(exact).astype(F)).astype(float)


# The reciprocal acts on the mantissa alone: every third value of one octave, then a sample of all
# magnitudes.
OCTAVE, RANGE = every(1, 2, 3), every(1e-30, 1e30, 1009)


@pytest.mark.parametrize('values', [OCTAVE, RANGE], ids=['octave', 'range'])
def test_reciprocal_is_within_2_ulp(values):
    result = over(reciprocal)(values)
    assert ulps(result, 1 / values.astype(float)).max() <= 2
    assert (over(reciprocal)(-values) == -result).all()


def test_logistic_is_within_3e_7_everywhere():
    sweep = np.linspace(-30, 30, 16 * 300_000).astype(F)
    near_zero = every(1e-10, 1, 4001)
    for values in (sweep, near_zero, -near_zero):
        exact = 1 / (1 + np.exp(-values.astype(float)))
        assert np.abs(over(logistic)(values) - exact).max() <= 3e-7


def test_logistic_stays_between_0_and_1_and_saturates():
    large = np.array([30, 31, 100, 3e38, np.inf, -30, -31, -100, -3e38, -np.inf, 0] + [0] * 5)
    result = over(logistic)(large)
    assert (result[:5] == result[0]).all() and 1 - 1e-6 < result[0] <= 1
    assert (result[5:10] == result[5]).all() and 0 < result[5] < 1e-12
    assert result[10] == pytest.approx(0.5, abs=1e-7)
    sweep = over(logistic)(np.linspace(-40, 40, 1_600_000))
    assert sweep.min() >= 0 and sweep.max() <= 1
    assert np.diff(sweep).min() > -3e-7


def test_arctan2_is_within_4e_7_all_the_way_round():
    angle = np.linspace(-np.pi, np.pi, 16 * 100_000)
    arguments = [
        ((scale * np.sin(angle)).astype(F), (scale * np.cos(angle)).astype(F))
        for scale in (1e-25, 0.17, 1, 4.2, 1e25)
    ]
    ratio = every(1e-6, 1, 501)
    one = np.ones_like(ratio)
    arguments += [(ratio, one), (one, ratio), (ratio, -one), (-one, -ratio)]
    for y, x in arguments:
        error = over(arctan2)(y, x) - np.arctan2(y.astype(float), x.astype(float))
        assert np.abs(error).max() <= 4e-7
    axes = np.array([(0, 1), (1, 0), (0, -1), (-1, 0)] * 4, F)
    assert over(arctan2)(*axes.T)[:4] == pytest.approx([0, np.pi / 2, np.pi, -np.pi / 2])


@pytest.mark.parametrize(
    ('function', 'exact', 'limit', 'bound'),
    [
        (arcsine, np.arcsin, 0.5, 1e-7),
        (sine_over, lambda x: np.sinc(x / np.pi), 0.5, 1.2e-7),
        (cosine, np.cos, 0.5, 1.2e-7),
        # the most that occurs: half a turn in a tick at the highest wheel speed, 30 rad/s
        (sine_over, lambda x: np.sinc(x / np.pi), 0.6404, 2e-7),
        (cosine, np.cos, 0.6404, 2e-7),
    ],
    ids=['arcsine', 'sine_over', 'cosine', 'sine_over at 30 rad/s', 'cosine at 30 rad/s'],
)
def test_series_are_within_their_bounds(function, exact, limit, bound):
    values = np.concatenate([np.linspace(-limit, limit, 16 * 200_000).astype(F), np.zeros(16, F)])
    assert np.abs(over(function)(values) - exact(values.astype(float))).max() <= bound


def test_plain_python_gives_the_same_bits(tmp_path):
    rng = np.random.default_rng(0)
    wide = np.concatenate([rng.uniform(-30, 30, 800), rng.lognormal(0, 8, 800)]).astype(F)
    narrow = rng.uniform(-0.5, 0.5, 1600).astype(F)
    cases = {
        'reciprocal': [wide],
        'square_root': [np.abs(wide)],
        'logistic': [wide],
        'arctan2': [rng.permutation(wide), wide],
        'arcsine': [narrow],
        'sine_over': [narrow],
        'cosine': [narrow],
    }
    code = (
        'import sys, numpy as np, simd_lanes\n'
        'given, results = np.load(sys.argv[1]), {}\n'
        'for name in given:\n'
        '    function = getattr(simd_lanes, name)\n'
        '    rows = given[name].reshape(-1, 100, 16).swapaxes(0, 1)\n'
        '    results[name] = [function(*map(simd_lanes.Lanes, row)).values for row in rows]\n'
        'np.savez(sys.argv[2], **results)\n'
    )
    np.savez(tmp_path / 'in.npz', **{name: np.array(values) for name, values in cases.items()})
    environment = {
        **os.environ,
        'NUMBA_DISABLE_JIT': '1',
        'PYTHONPATH': str(Path(simd_lanes.__file__).parents[1]),
    }
    subprocess.run(
        [sys.executable, '-c', code, tmp_path / 'in.npz', tmp_path / 'out.npz'],
        env=environment,
        check=True,
        timeout=60,
    )
    results = np.load(tmp_path / 'out.npz')
    for name, values in cases.items():
        compiled = over(getattr(simd_lanes, name))(*values)
        assert (results[name].reshape(-1).view(np.uint32) == compiled.view(np.uint32)).all(), name
