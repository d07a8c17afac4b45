"""Every operation of the lanes, compiled and in plain Python, against NumPy."""

import numba
import numpy as np
import pytest

from simd_lanes import (
    HALF,
    LANES,
    Lanes,
    absolute,
    any_lane,
    copy_sign,
    fma,
    from_bits,
    lane_bits,
    load,
    maximum,
    minimum,
    select,
    signed,
    splat,
    square_root,
    store,
    swap_halves,
)
from simd_lanes.lanes import add_exponent, subtract_bits

F, U = np.float32, np.uint32
ROWS = 200


def bits(values):
    return np.asarray(values, F).view(np.uint32)


def samples(count, seed=0):
    """Float32 of all magnitudes and signs, with zeros of both signs and equal pairs among them."""
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(count, ROWS, LANES)) * 10.0 ** rng.integers(
        -8, 8, (count, ROWS, LANES)
    )
    values[:, ::7] = np.round(rng.normal(size=values[:, ::7].shape))
    values[:, 1::7] = rng.choice([0.0, -0.0, 1.0], values[:, 1::7].shape)
    return values.astype(F)


def compiled(function, arrays):
    function = numba.njit(function)

    @numba.njit
    def one(a, out):
        for row in range(a.shape[0]):
            store(out, row, function(load(a, row)))

    @numba.njit
    def two(a, b, out):
        for row in range(a.shape[0]):
            store(out, row, function(load(a, row), load(b, row)))

    @numba.njit
    def three(a, b, c, out):
        for row in range(a.shape[0]):
            store(out, row, function(load(a, row), load(b, row), load(c, row)))

    out = np.empty((ROWS, LANES), F)
    (one, two, three)[len(arrays) - 1](*arrays, out)
    return out


def plain(function, arrays):
    out = np.empty((ROWS, LANES), F)
    for row in range(ROWS):
        store(out, row, function(*(load(array, row) for array in arrays)))
    return out


def exact_fma(a, b, c):
    """a * b + c with a 64-bit mantissa, enough for these arguments to be rounded once."""
    total = a.astype(np.longdouble) * b + c
    return total.astype(F)


OPERATIONS = {
    'add': (2, lambda a, b: a + b, lambda a, b: a + b),
    'subtract': (2, lambda a, b: a - b, lambda a, b: a - b),
    'multiply': (2, lambda a, b: a * b, lambda a, b: a * b),
    'divide': (2, lambda a, b: a / (b + 2e9), lambda a, b: a / (b + F(2e9))),
    'negate': (1, lambda a: -a, lambda a: -a),
    'scalar on the right': (
        1,
        lambda a: a * 0.1 + 0.7 - 3.3,
        lambda a: a * F(0.1) + F(0.7) - F(3.3),
    ),
    'scalar on the left': (1, lambda a: 0.7 - 0.1 * a, lambda a: F(0.7) - F(0.1) * a),
    'scalar divided': (1, lambda a: 1.0 / (a + 2e9), lambda a: F(1) / (a + F(2e9))),
    'splat': (1, lambda a: splat(0.3) + a, lambda a: F(0.3) + a),
    'absolute': (1, lambda a: absolute(a), np.abs),
    'square_root': (1, lambda a: square_root(absolute(a)), lambda a: np.sqrt(np.abs(a))),
    'root of a negative drops out of a maximum': (
        1,
        lambda a: maximum(square_root(-1.0 - absolute(a)), a),
        lambda a: a,
    ),
    'copy_sign': (2, lambda a, b: copy_sign(a, b), np.copysign),
    'copy_sign of a scalar': (1, lambda a: copy_sign(1.5, a), lambda a: np.copysign(F(1.5), a)),
    'minimum': (2, lambda a, b: minimum(a, b), lambda a, b: np.where(a < b, a, b)),
    'maximum': (2, lambda a, b: maximum(a, b), lambda a, b: np.where(a > b, a, b)),
    'clip': (1, lambda a: minimum(maximum(a, -1.0), 1.0), lambda a: np.clip(a, F(-1), F(1))),
    'swap_halves': (1, lambda a: swap_halves(a), lambda a: np.roll(a, HALF, axis=1)),
    'less': (2, lambda a, b: select(a < b, a, 7.0), lambda a, b: np.where(a < b, a, F(7))),
    'less or equal': (
        2,
        lambda a, b: select(a <= b, 1.0, b),
        lambda a, b: np.where(a <= b, F(1), b),
    ),
    'greater': (
        2,
        lambda a, b: select(a > b, a, b * 2.0),
        lambda a, b: np.where(a > b, a, b * F(2)),
    ),
    'greater or equal': (
        2,
        lambda a, b: select(a >= b, a, b),
        lambda a, b: np.where(a >= b, a, b),
    ),
    'compare to a scalar': (
        1,
        lambda a: select(a < 0.5, a, -a),
        lambda a: np.where(a < F(0.5), a, -a),
    ),
    'and': (
        3,
        lambda a, b, c: select((a < b) & (b < c), a, b),
        lambda a, b, c: np.where((a < b) & (b < c), a, b),
    ),
    'or': (
        3,
        lambda a, b, c: select((a < b) | (b < c), a, b),
        lambda a, b, c: np.where((a < b) | (b < c), a, b),
    ),
    'not': (2, lambda a, b: select(~(a < b), a, b), lambda a, b: np.where(a < b, b, a)),
    'fma': (3, lambda a, b, c: fma(a, b, c), exact_fma),
    'fma of scalars': (1, lambda a: fma(a, 0.1, 1.0), lambda a: exact_fma(a, F(0.1), F(1))),
    'subtract_bits': (
        1,
        lambda a: subtract_bits(0x7EF311C3, a),
        lambda a: (np.uint32(0x7EF311C3) - a.view(np.uint32)).view(F),
    ),
    'add_exponent': (
        1,
        lambda a: add_exponent(copy_sign(1.5, a), splat(12582912.0) - 5.0),
        lambda a: np.copysign(F(1.5 / 32), a),
    ),
}


@pytest.mark.parametrize('name', OPERATIONS)
def test_operation_equals_numpy_bit_for_bit(name):
    count, function, expected = OPERATIONS[name]
    arrays = samples(count)
    result = bits(expected(*arrays))
    assert (bits(compiled(function, arrays)) == result).all()
    assert (bits(plain(function, arrays)) == result).all()


WORDS = {
    'add': (lambda a, b: a + b, lambda a, b: a + b),
    'multiply': (lambda a, b: a * b, lambda a, b: a * b),
    'exclusive or': (lambda a, b: a ^ b, lambda a, b: a ^ b),
    'and': (lambda a, b: a & b, lambda a, b: a & b),
    'or': (lambda a, b: a | b, lambda a, b: a | b),
    'shift left': (lambda a, b: (a << 13) + b, lambda a, b: (a << U(13)) + b),
    'shift right': (lambda a, b: (a >> 13) + b, lambda a, b: (a >> U(13)) + b),
    'scalars': (
        lambda a, b: ((a + 0x9E3779B9) * 0xD35A2D97) ^ (b & 0x007FE000),
        lambda a, b: ((a + U(0x9E3779B9)) * U(0xD35A2D97)) ^ (b & U(0x007FE000)),
    ),
    'scalar that needs more bits': (lambda a, b: a + b * 0x1_0000_0003, lambda a, b: a + b * U(3)),
}


@pytest.mark.parametrize('name', WORDS)
def test_integer_operation_equals_numpy(name):
    function, expected = WORDS[name]
    a, b = np.random.default_rng(1).integers(0, 2**32, (2, ROWS, LANES), dtype=U)
    jitted = numba.njit(function)

    @numba.njit
    def over(a, b, out):
        for row in range(a.shape[0]):
            store(out, row, jitted(load(a, row), load(b, row)))

    out, plain_out = np.empty_like(a), np.empty_like(a)
    over(a, b, out)
    for row in range(ROWS):
        store(plain_out, row, function(load(a, row), load(b, row)))
    assert (out == expected(a, b)).all()
    assert (plain_out == out).all()


def test_words_become_float32():
    words = samples(1)[0].view(U)

    @numba.njit
    def convert(words, same_bits, same_values):
        for row in range(words.shape[0]):
            store(same_bits, row, from_bits(load(words, row)))
            store(same_values, row, signed(load(words, row)))

    for route in (convert, convert.py_func):
        same_bits, same_values = np.zeros((2, ROWS, LANES), F)
        route(words, same_bits, same_values)
        assert (same_bits.view(U) == words).all()
        assert (same_values == words.view(np.int32).astype(F)).all()


def test_nothing_is_contracted_to_a_fused_multiply_add():
    a, b, c = samples(3)
    c = -(a * b)
    with_two_roundings = compiled(lambda a, b, c: a * b + c, (a, b, c))
    assert (with_two_roundings == 0).all()
    assert (compiled(lambda a, b, c: fma(a, b, c), (a, b, c)) != 0).any()


def test_fused_multiply_add_rounds_once_where_float64_would_round_twice():
    # a * b = 1 + 2**-12 + ..., exactly between two float32 but for the tiny addend
    a, b = F(1 + 2.0**-12), F(1 + 2.0**-12)
    halfway = F(a) * np.float64(b) - np.float64(F(np.float64(a) * b))
    assert halfway == 2.0**-24
    for tiny, expected in ((2.0**-60, 1 + 2.0**-11 + 2.0**-23), (-(2.0**-60), 1 + 2.0**-11)):
        rows = [np.full((ROWS, LANES), value, F) for value in (a, b, tiny)]
        for route in (compiled, plain):
            assert (route(lambda a, b, c: fma(a, b, c), rows) == F(expected)).all()


def test_reductions_of_a_mask():
    @numba.njit
    def reduce(rows, row):
        mask = load(rows, row) > 0.0
        return any_lane(mask), lane_bits(mask)

    patterns = [0, 1, 0x8000, 0xFFFF, 0x1234, 0x00FF]
    rows = np.array([[(p >> lane) & 1 for lane in range(LANES)] for p in patterns], F)
    for row, pattern in enumerate(patterns):
        assert reduce(rows, row) == (pattern != 0, pattern)
        assert reduce.py_func(rows, row) == (pattern != 0, pattern)


def test_store_writes_one_row_and_load_reads_it():
    @numba.njit
    def copy(source, i, target, j):
        store(target, j, load(source, i))

    source = np.arange(4 * LANES, dtype=F).reshape(4, LANES)
    for route in (copy, copy.py_func):
        target = np.full((3, LANES), -1, F)
        route(source, 2, target, 1)
        assert (target[1] == source[2]).all()
        assert (target[[0, 2]] == -1).all()


def test_a_loaded_value_does_not_change_with_its_row():
    @numba.njit
    def overwrite(rows):
        before = load(rows, 0)
        store(rows, 0, before + 1.0)
        store(rows, 1, before)

    for route in (overwrite, overwrite.py_func):
        rows = np.zeros((2, LANES), F)
        route(rows)
        assert (rows[0] == 1).all()
        assert (rows[1] == 0).all()


def test_not_a_number_compares_false():
    nan = Lanes(np.nan)
    for mask in (nan < nan, nan <= nan, nan > nan, nan >= nan):
        assert not any_lane(mask)
    rows = np.full((ROWS, LANES), np.nan, F)
    assert (compiled(lambda a: select(a >= a, 1.0, 2.0), [rows]) == 2).all()
    assert (compiled(lambda a: minimum(a, 5.0), [rows]) == 5).all()
    assert (plain(lambda a: minimum(a, 5.0), [rows]) == 5).all()
