"""The share of a panoramic image's sectors that shows a colour."""

import numpy as np

from marxbot_sensors import CAMERA

CHANNELS = {'red': 0, 'green': 1}
"""Colours of the rings of lights, and their channels in an image of red, green and blue."""

ENCODINGS = {
    'rgb8': (3, (0, 1, 2)),
    'bgr8': (3, (2, 1, 0)),
    'rgba8': (4, (0, 1, 2)),
    'bgra8': (4, (2, 1, 0)),
}
"""Bytes of a pixel, and the places of red, green and blue among them."""


def to_pixels(data, height, width, step, encoding):
    """Return the pixels of an image, uint8 of shape (height, width, 3): red, green, blue.

    Parameters
    ----------
    data : bytes-like
        Rows of `step` bytes.
    height, width, step : int
    encoding : str
        One of `ENCODINGS`.

    Raises
    ------
    ValueError
        The encoding is another, or there is not so much data, in one sentence.
    """
    if encoding not in ENCODINGS:
        raise ValueError(f'encoding is {encoding!r}, expected one of {", ".join(ENCODINGS)}')
    size, places = ENCODINGS[encoding]
    if not width or not height or step < width * size or len(data) != height * step:
        raise ValueError(
            f'image has {len(data)} bytes, expected {height} rows of {step}, each of {width} '
            f'pixels of {size}'
        )
    rows = np.frombuffer(data, np.uint8).reshape(height, step)[:, : width * size]
    return rows.reshape(height, width, size)[..., list(places)]


def sectors(pixels, colour, least=96, excess=48, yaw=np.pi):
    """Return for each camera sector the share of its columns that show a colour.

    Parameters
    ----------
    pixels : uint8 array, shape (height, width, 3)
        A panorama of 360 degrees, from left to right.
    colour : str
        One of `CHANNELS`.
    least, excess : int
        A pixel shows the colour if its channel is at least `least`, and exceeds both others by
        `excess`.
    yaw : float
        Where the left edge looks in the robot's frame, rad counter-clockwise; pi: backwards, so
        that the middle of the image looks ahead.

    Returns
    -------
    float64 array, shape (8,)
        0 to 1; sector k spans 45 k to 45 (k + 1) degrees counter-clockwise from the heading.
    """
    values = np.asarray(pixels, np.int16)
    own = values[..., CHANNELS[colour]]
    others = np.delete(values, CHANNELS[colour], axis=-1).max(axis=-1)
    shown = ((own >= least) & (own - others >= excess)).any(axis=0)
    width = len(shown)
    angles = yaw - 2 * np.pi * (np.arange(width) + 0.5) / width
    share = np.mod(angles / (2 * np.pi), 1.0)
    sector = np.minimum((share * CAMERA.count).astype(int), CAMERA.count - 1)
    columns = np.bincount(sector, minlength=CAMERA.count)
    return np.bincount(sector, weights=shown, minlength=CAMERA.count) / np.maximum(columns, 1)
