"""Look-up and weighted sums of bytes, by every processor's instructions that this one has."""

import numba
import numpy as np
import pytest
from llvmlite import binding

from simd_lanes import LANES, ByteTable, ByteWeights, compiled_bytes, load, look_up, store, weigh

ROWS = 50
TABLE = ByteTable((7, 255, 0, 128, 127, 1, 2, 3, 200, 100, 50, 25, 13, 99, 64, 31))
WEIGHTS = [ByteWeights((9, -7, 5, -3), -128 * 4), ByteWeights((127, 1, -128, 0), 2**31 - 5)]
SETS = {
    'of any processor': set(),
    **{each.feature: {each.feature} for each in compiled_bytes.X86},
    compiled_bytes.SUM_FOUR_FEATURE: {
        compiled_bytes.SUM_FOUR_FEATURE,
        compiled_bytes.X86[0].feature,
    },
}
HERE = {f'+{name}' for name, has in binding.get_host_cpu_features().items() if has}
CHOSEN = [name for name, features in SETS.items() if features <= HERE]


def rows(highest):
    words = np.random.default_rng(3).integers(0, highest + 1, (ROWS, 4 * LANES), dtype=np.uint8)
    words[0], words[1] = 0, highest
    return words.view(np.uint32)


def compiled(function, constant, words):
    @numba.njit
    def over(words, out):
        for row in range(words.shape[0]):
            store(out, row, function(constant, load(words, row)))

    out = np.zeros_like(words)
    over(words, out)
    return out


def plain(function, constant, words):
    out = np.zeros_like(words)
    for row in range(ROWS):
        store(out, row, function(constant, load(words, row)))
    return out


@pytest.fixture(params=CHOSEN)
def instructions(request, monkeypatch):
    """Compile for one set of instructions; what was compiled for another is not used again."""
    monkeypatch.setattr(compiled_bytes, 'features', lambda context: SETS[request.param])


@pytest.mark.usefixtures('instructions')
def test_bytes_are_looked_up():
    words = rows(15)
    expected = np.array(TABLE.values, np.uint8)[words.view(np.uint8)].view(np.uint32)
    assert (compiled(look_up, TABLE, words) == expected).all()
    assert (plain(look_up, TABLE, words) == expected).all()


@pytest.mark.usefixtures('instructions')
@pytest.mark.parametrize('weights', WEIGHTS)
def test_bytes_are_weighed(weights):
    words = rows(255)
    a, b, c, d = (int(weight) for weight in weights.values)
    expected = [
        [
            (
                a * (word & 255)
                + b * (word >> 8 & 255)
                + c * (word >> 16 & 255)
                + d * (word >> 24)
                + weights.offset
            )
            % 2**32
            for word in row
        ]
        for row in words.tolist()
    ]
    assert (compiled(weigh, weights, words) == expected).all()
    assert (plain(weigh, weights, words) == expected).all()
