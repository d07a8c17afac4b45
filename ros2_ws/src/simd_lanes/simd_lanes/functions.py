"""Elementary functions over `Lanes`, made of IEEE operations only and so the same everywhere.

NumPy's and libm's functions differ between versions and processors, and PyPI's Numba has no vector
library. Accuracy is stated for each and asserted over the whole range by the tests.
"""

import numba

from simd_lanes.lanes import (
    absolute,
    add_exponent,
    copy_sign,
    fma,
    maximum,
    minimum,
    select,
    subtract_bits,
)

_INTEGER_SHIFT = 12582912.0  # 1.5 * 2**23: adding it rounds a small float32 to an integer
_LOG2_E = 1.4426950408889634


@numba.njit(forceinline=True)
def reciprocal(x):
    """Return 1/x for 1e-30 < |x| < 1e30, within 2 ulp, by a cubic and a quadratic Newton step."""
    estimate = subtract_bits(0x7EF311C3, x)
    error = fma(-x, estimate, 1.0)
    estimate = fma(estimate, fma(error, error, error), estimate)
    return fma(estimate, fma(-x, estimate, 1.0), estimate)


@numba.njit(forceinline=True)
def logistic(x):
    """Return 1/(1 + exp(-x)), within 3e-7 absolute; beyond +-30 it is the value there.

    exp(-x) = 2**k 2**f, k integer and f in [-1/2, 1/2], with 2**f a polynomial of least
    maximal relative error.
    """
    x = minimum(maximum(x, -30.0), 30.0)
    shifted = fma(x, -_LOG2_E, _INTEGER_SHIFT)
    f = fma(x, -_LOG2_E, _INTEGER_SHIFT - shifted)
    square = f * f
    high = fma(f, 0.0013276470, 0.0096755416)
    middle = fma(f, 0.055507133, 0.24022120)
    low = fma(f, 0.69314697, 1.0000001)
    power = fma(fma(high, square, middle), square, low)
    return 1.0 / (1.0 + add_exponent(power, shifted))


@numba.njit(forceinline=True)
def arctan2(y, x):
    """Return the angle of (x, y) in [-pi, pi], within 4e-7, for 1e-30 < max(|x|, |y|) < 1e30."""
    across, along = absolute(y), absolute(x)
    tangent = minimum(across, along) / maximum(across, along)
    square = tangent * tangent
    series = fma(square, -0.0043553785, 0.023040041)
    series = fma(series, square, -0.057773459)
    series = fma(series, square, 0.097942256)
    series = fma(series, square, -0.13976579)
    series = fma(series, square, 0.19962703)
    series = fma(series, square, -0.33331659)
    angle = fma(series * square, tangent, tangent)
    angle = select(across > along, 1.5707964 - angle, angle)
    angle = select(x < 0.0, 3.1415927 - angle, angle)
    return copy_sign(angle, y)


@numba.njit(forceinline=True)
def arcsine(x):
    """Return the angle, radians, whose sine is x, for |x| <= 0.5, within 1e-7 absolute."""
    square = x * x
    series = fma(square, 0.051587027, 0.039193367)
    series = fma(series, square, 0.075540318)
    series = fma(series, square, 0.16664926)
    return fma(series * square, x, x)


@numba.njit(forceinline=True)
def sine_over(x):
    """Return sin(x)/x (1 at 0) for |x| <= 0.65, within 2e-7 absolute, by the Taylor series."""
    square = x * x
    series = fma(square, -1.9841270e-4, 8.3333333e-3)
    return fma(fma(series, square, -0.16666667), square, 1.0)


@numba.njit(forceinline=True)
def cosine(x):
    """Return cos(x) for |x| <= 0.65, within 2e-7 absolute, by the Taylor series."""
    square = x * x
    series = fma(square, 2.4801587e-5, -1.3888889e-3)
    return fma(fma(fma(series, square, 0.041666667), square, -0.5), square, 1.0)
