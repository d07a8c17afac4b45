"""Parts of kernels: the same results, and no counting of references."""

from collections import namedtuple

import numba
import numpy as np

from simd_lanes import aligned_rows, any_lane, kernel_part, load, store

Rows = namedtuple('Rows', 'first second')


def halve(rows, count):
    """Halve rows of one array or the other, which takes a reference to each."""
    chosen = rows.first
    for i in range(count):
        store(chosen, i, load(chosen, i) * 0.5)
        chosen = rows.first if any_lane(load(chosen, i) > 1.0) else rows.second


def halved(compiled):
    """What comes of three rows, and how often references are counted up."""
    rows = Rows(aligned_rows(3), aligned_rows(3))
    rows.first[:] = 4.0
    compiled(rows, 3)
    code = compiled.inspect_llvm(compiled.signatures[0])
    return np.concatenate(rows), code.count('@NRT_incref(')


def test_a_part_of_a_kernel_counts_no_references():
    (plain, counted), (part, uncounted) = halved(numba.njit(halve)), halved(kernel_part(halve))
    np.testing.assert_array_equal(part, plain)
    assert counted > 0
    assert uncounted == 0
