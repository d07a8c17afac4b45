"""The random bits of imperfect robots, without end, for a battery of tests of generators.

``python scripts/lib/random_words.py | dieharder -a -g 200``, where the workspace can be imported.
Sixteen robots of eight episodes draw side by side, 15 numbers in each of 1000 ticks; then come the
next eight episodes.
"""

import sys

import numba
import numpy as np

from marxbot_sim.core.randomness import mix_tick, random_words
from marxbot_sim.core.starts import episode_key
from simd_lanes import HALF, LANES, aligned_rows, load, store

NUMBERS, TICKS = 15, 1000


@numba.njit
def draw(counters, words):
    """Fill the rows of `words`, each with one number of a tick."""
    for tick in range(TICKS):
        mixed = mix_tick(load(counters, 0), load(counters, 1), load(counters, 2))
        for number in range(NUMBERS):
            store(words, NUMBERS * tick + number, random_words(mixed, number))
        store(counters, 2, load(counters, 2) + 1)


def main():
    """Write until the reader has had enough."""
    counters, words = aligned_rows(3, np.uint32), aligned_rows(NUMBERS * TICKS, np.uint32)
    episode = 0
    while True:
        for lane in range(LANES):
            key = int(episode_key(1, np.uint64(episode + lane % HALF), lane // HALF))
            counters[:, lane] = key >> 32, key & 0xFFFFFFFF, 0
        draw(counters, words)
        try:
            sys.stdout.buffer.write(words.tobytes())
        except BrokenPipeError:
            return
        episode += HALF


if __name__ == '__main__':
    main()
