"""The elementary functions over their whole range against float64."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

import simd_lanes
from simd_lanes import inverse_square_root, load, logistic, reciprocal, square_root, store

F = np.float32
FUNCTIONS = {
    'reciprocal': reciprocal,
    'inverse_square_root': inverse_square_root,
    'square_root': square_root,
    'logistic': logistic,
}


def over(function):
    """A function of a float32 array of any multiple of 16 values."""

    @numba.njit
    def run(rows, out):
        for row in range(rows.shape[0]):
            store(out, row, function(load(rows, row)))

    def apply(values):
        rows = np.ascontiguousarray(values, F).reshape(-1, 16)
        out = np.empty_like(rows)
        run(rows, out)
        return out.reshape(-1)

    return apply


def every(start, stop, step=1):
    """The float32 between two positive ones, every ``step``-th."""
    first, last = F([start, stop]).view(np.uint32)
    values = np.arange(first, last, step, dtype=np.uint32).view(F)
    return values[: len(values) // 16 * 16]


def ulps(result, exact):
    return np.abs(result - exact) / np.spacing(np.abs(exact).astype(F)).astype(float)


# Reciprocal and inverse root act on the mantissa alone: all values of one octave (or two),
# then a sample of all magnitudes.


@pytest.mark.parametrize(
    'values', [every(1, 2), every(1e-30, 1e30, 1009)], ids=['octave', 'range']
)
def test_reciprocal_is_within_2_ulp(values):
    result = over(reciprocal)(values)
    assert ulps(result, 1 / values.astype(float)).max() <= 2
    assert (over(reciprocal)(-values) == -result).all()


@pytest.mark.parametrize(
    'values', [every(1, 4), every(1e-30, 1e30, 1009)], ids=['octaves', 'range']
)
def test_inverse_square_root_is_within_3_ulp(values):
    assert ulps(over(inverse_square_root)(values), 1 / np.sqrt(values.astype(float))).max() <= 3


def test_square_root_is_within_3_ulp_and_nearly_zero_near_zero():
    root = over(square_root)
    for values in (every(1, 4), every(1e-20, 1e30, 1009)):
        assert ulps(root(values), np.sqrt(values.astype(float))).max() <= 3
    tiny = np.concatenate([np.zeros(16, F), every(1e-38, 1e-20, 10007)])
    assert np.abs(root(tiny) - np.sqrt(tiny.astype(float))).max() <= 1e-10
    assert root(np.zeros(16)).max() == 0


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
    assert result[10] == 0.5
    sweep = over(logistic)(np.linspace(-40, 40, 1_600_000))
    assert sweep.min() >= 0 and sweep.max() <= 1
    assert np.diff(sweep).min() > -3e-7


def test_plain_python_gives_the_same_bits(tmp_path):
    rng = np.random.default_rng(0)
    values = np.concatenate([rng.uniform(-30, 30, 800), rng.lognormal(0, 8, 800)]).astype(F)
    code = (
        'import sys, numpy as np, simd_lanes as s\n'
        'x = np.load(sys.argv[1])\n'
        'f = getattr(s, sys.argv[2])\n'
        'np.save(sys.argv[3], np.concatenate([f(s.Lanes(r)).values for r in x.reshape(-1, 16)]))\n'
    )
    environment = {
        **os.environ,
        'NUMBA_DISABLE_JIT': '1',
        'PYTHONPATH': str(Path(simd_lanes.__file__).parents[1]),
    }
    for name, function in FUNCTIONS.items():
        arguments = values if name in ('reciprocal', 'logistic') else np.abs(values)
        np.save(tmp_path / 'in.npy', arguments)
        subprocess.run(
            [sys.executable, '-c', code, tmp_path / 'in.npy', name, tmp_path / 'out.npy'],
            env=environment,
            check=True,
            timeout=60,
        )
        result = np.load(tmp_path / 'out.npy')
        assert (result.view(np.uint32) == over(function)(arguments).view(np.uint32)).all(), name
