"""Sixteen float32 lanes as one value, and elementary functions over them."""

from . import compiled as _compiled  # noqa: F401  gives the names below their compiled meaning
from .functions import inverse_square_root, logistic, reciprocal, square_root
from .lanes import (
    HALF,
    LANES,
    Lanes,
    Mask,
    absolute,
    any_lane,
    copy_sign,
    fma,
    lane_bits,
    load,
    maximum,
    minimum,
    select,
    splat,
    store,
    swap_halves,
)
