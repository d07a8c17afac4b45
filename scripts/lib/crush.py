"""What scripts/crush does; see there."""

import argparse
import ctypes
import sys

import numba
import numpy as np
from numba import types

from marxbot_sim.core.randomness import mix_tick, random_words
from marxbot_sim.core.starts import episode_key
from simd_lanes import HALF, LANES, aligned_rows, load, store

NUMBERS, TICKS = 15, 1000
WORDS = NUMBERS * TICKS * LANES
FIRST_KEY, SECOND_KEY, AGE = (NUMBERS * TICKS + row for row in range(3))
BATTERIES = ('SmallCrush', 'Crush', 'BigCrush')


@numba.njit
def draw(rows, first_episode):
    """Fill `rows`, uint32 (15,003, 16), with what the robots of eight episodes draw.

    A row holds one number of a tick; the last three hold keys and age.
    """
    for lane in range(LANES):
        key = episode_key(np.uint64(1), np.uint64(first_episode + lane % HALF), lane // HALF)
        rows[FIRST_KEY, lane] = key >> np.uint64(32)
        rows[SECOND_KEY, lane] = key & np.uint64(0xFFFFFFFF)
        rows[AGE, lane] = 0
    for tick in range(TICKS):
        mixed = mix_tick(load(rows, FIRST_KEY), load(rows, SECOND_KEY), load(rows, AGE))
        for number in range(NUMBERS):
            store(rows, NUMBERS * tick + number, random_words(mixed, number))
        store(rows, AGE, load(rows, AGE) + 1)


@numba.njit
def next_word(rows, state):
    """Return the next word; `state` is words used, episodes drawn, and 1 to reverse bits."""
    if state[0] == WORDS:
        draw(rows, state[1])
        state[0] = 0
        state[1] += HALF
    word = rows[state[0] // LANES, state[0] % LANES]
    state[0] += 1
    if state[2]:
        reversed_word = np.uint32(0)
        for _ in range(32):
            reversed_word = np.uint32(reversed_word << 1) | np.uint32(word & 1)
            word = np.uint32(word >> 1)
        return reversed_word
    return word


_SHAPE = (NUMBERS * TICKS + 3, LANES)


@numba.njit
def _word_behind(rows, state):
    return next_word(
        numba.carray(rows, _SHAPE, dtype=np.uint32), numba.carray(state, 3, dtype=np.int64)
    )


@numba.cfunc(types.uint64(types.voidptr, types.voidptr))
def get_bits(rows, state):
    """Return 32 bits, as TestU01 asks for them."""
    return _word_behind(rows, state)


@numba.cfunc(types.float64(types.voidptr, types.voidptr))
def get_fraction(rows, state):
    """Return a number in [0, 1), as TestU01 asks for it."""
    return _word_behind(rows, state) * 2.0**-32


class Generator(ctypes.Structure):
    """The `unif01_Gen` of TestU01."""

    _fields_ = [
        ('state', ctypes.c_void_p),
        ('parameters', ctypes.c_void_p),
        ('name', ctypes.c_char_p),
        ('get_fraction', ctypes.c_void_p),
        ('get_bits', ctypes.c_void_p),
        ('write', ctypes.c_void_p),
    ]


def main():
    """Run a battery; 1 where the library is missing."""
    parser = argparse.ArgumentParser(prog='crush')
    parser.add_argument('battery', choices=BATTERIES)
    parser.add_argument('--reversed', action='store_true', help='lowest bits first')
    arguments = parser.parse_args()
    try:
        library = ctypes.CDLL('libtestu01.so.0', ctypes.RTLD_GLOBAL)
    except OSError as error:
        print(
            f'crush: TestU01 cannot be loaded, see scripts/crush --help: {error}', file=sys.stderr
        )
        return 1
    rows = aligned_rows(_SHAPE[0], np.uint32)
    state = np.array([WORDS, 0, arguments.reversed], np.int64)
    write = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(lambda _: None)
    generator = Generator(
        state.ctypes.data,
        rows.ctypes.data,
        b'the random words of imperfect robots',
        get_fraction.address,
        get_bits.address,
        ctypes.cast(write, ctypes.c_void_p),
    )
    library[f'bbattery_{arguments.battery}'](ctypes.byref(generator))
    return 0


if __name__ == '__main__':
    sys.exit(main())
