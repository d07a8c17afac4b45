"""The generators of random numbers: known answers, and statistics that a generator must pass."""

import numba
import numpy as np
import pytest
from reference import disturbance as reference
from scipy import stats

from marxbot_sim.core.randomness import (
    NORMAL_DEVIATION,
    eight_normals,
    fractions,
    mix_tick,
    random_bits,
    random_words,
)
from marxbot_sim.core.starts import episode_key
from simd_lanes import LANES, load, store

WORDS_PER_TICK = 16
TICKS = 4000
U = np.uint32


@numba.njit
def draw(keys, ages, words, uniforms, normals):
    """Draw what some ticks give, a row of each output for each number of each tick."""
    for tick in range(ages.shape[0]):
        mixed = mix_tick(load(keys, 0), load(keys, 1), load(ages, tick))
        for number in range(WORDS_PER_TICK):
            row = WORDS_PER_TICK * tick + number
            store(words, row, random_words(mixed, number))
            store(uniforms, row, fractions(load(words, row)))
            for i, normal in enumerate(eight_normals(load(words, row))):
                store(normals, 8 * row + i, normal)


def drawn(keys, ages):
    """Words and uniform values (ticks, 16 numbers, 16 lanes), normal values (ticks, 128, 16)."""
    ages = np.repeat(np.asarray(ages, U)[:, None], LANES, axis=1)
    words = np.zeros((WORDS_PER_TICK * len(ages), LANES), U)
    uniforms = np.zeros(words.shape, np.float32)
    normals = np.zeros((8 * len(words), LANES), np.float32)
    draw(np.ascontiguousarray(keys, U), ages, words, uniforms, normals)
    normals /= np.float32(NORMAL_DEVIATION)
    return [part.reshape(len(ages), -1, LANES) for part in (words, uniforms, normals)]


def keys_of(seed, episodes):
    """Keys of both robots of eight episodes, (2, 16)."""
    keys = [
        int(episode_key(np.uint64(seed), np.uint64(episode), robot))
        for robot in range(2)
        for episode in episodes
    ]
    return np.array([[key >> 32 for key in keys], [key & 0xFFFFFFFF for key in keys]], U)


@pytest.fixture(scope='module')
def sample():
    return drawn(keys_of(5, range(8)), np.arange(TICKS))


def mixed_by_hand(first_key, second_key, tick, number):
    """The same generator in Python's integers, for one robot."""
    mask = 0xFFFFFFFF

    def stir(x, right, factor):
        return ((x ^ (x >> right)) * factor) & mask

    first = (first_key + tick * 0x9E3779B9) & mask
    first = stir(stir(first, 16, 0x21F0AAAD), 15, 0xD35A2D97)
    first ^= first >> 15
    second = stir(first ^ second_key, 16, 0x21F0AAAD)
    second ^= second >> 15
    bits = (stir((first + number * 0x9E3779B9) & mask, 16, 0x21F0AAAD) + second) & mask
    bits = stir(bits, 15, 0xD35A2D97)
    return bits ^ (bits >> 15)


def test_the_generator_of_episodes_is_splitmix64():
    """First numbers of the reference implementation for the seed 1234567 (Vigna, splitmix64.c)."""
    known = [6457827717110365317, 3203168211198807973, 9817491932198370423, 4593380528125082431]
    assert [int(random_bits(np.uint64(1234567), i)) for i in range(4)] == known


def test_the_generator_of_ticks_is_the_one_written_in_python():
    keys, ages = keys_of(5, range(8)), [0, 1, 77, 999_999, 2**32 - 1]
    expected = [
        [[mixed_by_hand(int(a), int(b), t, n) for a, b in keys.T] for n in range(WORDS_PER_TICK)]
        for t in ages
    ]
    np.testing.assert_array_equal(drawn(keys, ages)[0], expected)


def test_words_are_equidistributed_in_every_byte_and_in_pairs_of_successive_ones(sample):
    words = sample[0]
    for shift in range(0, 32, 8):
        part = (words >> U(shift)) & U(255)
        assert 1e-4 < stats.chisquare(np.bincount(part.ravel(), minlength=256)).pvalue < 1 - 1e-4
    upper = (words >> U(28)).astype(int)
    for axis in range(3):  # from tick to tick, number to number, lane to lane
        first, second = np.moveaxis(upper, axis, 0)[:-1], np.moveaxis(upper, axis, 0)[1:]
        counts = np.bincount((16 * first + second).ravel(), minlength=256)
        assert 1e-4 < stats.chisquare(counts).pvalue < 1 - 1e-4


def test_every_bit_is_a_fair_coin_whatever_the_others(sample):
    bits = np.unpackbits(sample[0].view(np.uint8).reshape(-1, 4), axis=1).astype(np.float32)
    error = 0.5 / np.sqrt(len(bits))
    assert np.abs(bits.mean(axis=0) - 0.5).max() < 5 * error
    correlation = np.corrcoef(bits, rowvar=False)
    np.fill_diagonal(correlation, 0)
    assert np.abs(correlation).max() < 5 / np.sqrt(len(bits))


def test_uniform_values_are_uniform(sample):
    uniforms = sample[1].ravel()
    assert uniforms.min() >= 0
    assert uniforms.max() < 1
    assert stats.kstest(uniforms[:200_000], 'uniform').pvalue > 1e-4
    assert (uniforms * 2.0**23 % 1 == 0).all()


def test_eight_normal_values_are_sums_of_eight_steps_in_orthogonal_directions(sample):
    words, _, normals = (part[:50] for part in sample)
    expected = np.moveaxis(reference.normals(words.astype(int)), 0, 2).reshape(normals.shape)
    np.testing.assert_allclose(normals, expected, rtol=2e-7)


def test_no_moment_up_to_the_fourth_tells_them_from_independent_normal_values():
    """Moments of sums of independent steps follow from those of a step."""
    directions, steps = reference.DIRECTIONS, reference.SIGNED_STEPS
    product = directions @ directions.T
    assert (product == product[0, 0] * np.eye(8)).all()
    assert steps.sum() == (steps**3).sum() == 0
    second, fourth = (steps**2).mean(), (steps**4).mean()
    assert fourth / second**2 == pytest.approx(3, abs=3e-6)
    assert np.sqrt(product[0, 0] * second) == pytest.approx(NORMAL_DEVIATION)


def test_normal_values_have_the_moments_of_a_normal_distribution_up_to_the_fourth(sample):
    normals = sample[2].astype(float)
    count = normals.size
    assert abs(normals.mean()) < 5 / np.sqrt(count)
    assert abs((normals**2).mean() - 1) < 5 * np.sqrt(2 / count)
    assert abs((normals**3).mean()) < 5 * np.sqrt(15 / count)
    assert abs((normals**4).mean() - 3) < 5 * np.sqrt(96 / count)
    assert (normals**6).mean() == pytest.approx(14.9, abs=0.2)
    assert 4.75 < np.abs(normals).max() < 5.66
    ordered = np.sort(normals.ravel())
    distance = np.abs(stats.norm.cdf(ordered) - (np.arange(count) + 0.5) / count).max()
    assert distance < 0.001 + 2 / np.sqrt(count)


def test_neither_numbers_nor_ticks_nor_lanes_are_correlated(sample):
    normals = sample[2].astype(float)
    ticks = len(normals)
    error = 1 / np.sqrt(ticks)
    columns = normals.reshape(ticks, -1)  # 128 numbers of 16 robots
    for values in (columns, columns**2 - 1):
        scaled = (values - values.mean(axis=0)) / values.std(axis=0)
        together = scaled.T @ scaled / ticks
        np.fill_diagonal(together, 0)
        assert np.abs(together).max() < 6.5 * error
        for lag in (1, 2, 10):
            later = scaled[lag:].T @ scaled[:-lag] / ticks
            assert np.abs(later).max() < 6.5 * error
            assert later.std() == pytest.approx(error, rel=0.02)


def test_neighbouring_keys_and_episodes_have_nothing_in_common():
    def bits(keys, age):
        words = drawn(keys, [age])[0]
        return np.unpackbits(words.view(np.uint8))

    keys = keys_of(5, range(8))
    base = bits(keys, 3)
    others = [bits(keys_of(5, range(8, 16)), 3), bits(keys_of(6, range(8)), 3), bits(keys, 4)]
    for row in range(2):
        for bit in range(32):
            changed = keys.copy()
            changed[row] ^= U(1 << bit)
            others.append(bits(changed, 3))
    share = np.array([(other != base).mean() for other in others])
    assert np.abs(share - 0.5).max() < 5 * 0.5 / np.sqrt(len(base))
