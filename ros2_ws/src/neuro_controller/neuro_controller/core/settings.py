"""What a controller can be set to."""

import math

import numpy as np

MOTOR_MAPS = {'signed': (2.0, -1.0), 'printed': (1.0, 0.0)}
"""How the motor neuron rm becomes a drive, scale * rm + offset: with 2 rm - 1 in place of rm,
where a robot can back up (FARSA), or as equations 3 and 4 print it, where it cannot."""

INFRARED_RESPONSES = {'squared': 0.0, 'linear': 1.0}
"""How an infrared distance d becomes an activation, a max(a, least factor) with a = 1 - d/range:
a^2 (the authors' sampled tables), or a."""

GROUND_CODINGS = {'relative': (10.0, 1.0, 0.5), 'raw': (1.0, 0.0, 0.0)}
"""How a ground sensor's darkness g becomes a neuron, offset + gain (g - share * mean) kept in
0..1, as gain, share and offset: 0.5 + 10 (g - mean), which tells directions (the authors' later
code), or g. The fifth neuron is the mean of the readings in both."""

MIN_WHEEL_SPEED = 0.01
"""Lowest setting of the highest wheel speed, rad/s."""

MAX_WHEEL_SPEED = 30.0
"""Highest wheel speed, rad/s, that a controller can be set to; commands keep their grid of
2**-16 up to there."""

FIRST_RUNS = {
    'world': 'faithful',
    'wall_contact': 'slide',
    'infrared_response': 'linear',
    'ground_coding': 'raw',
}
"""Fields of the configuration in runs that do not say, from before there was a choice."""

(
    MAX_SPEED,
    PER_MAX_SPEED,
    PER_EPISODE,
    DRIVE_SCALE,
    DRIVE_OFFSET,
    LEAST_FACTOR,
    GROUND_GAIN,
    GROUND_MEAN_SHARE,
    GROUND_OFFSET,
) = range(9)
SETTING_ROWS = 9
"""Rows of the `settings` of a controller's kernel."""


def _look_up(name, value, known):
    if value not in known:
        raise ValueError(f'{name} is {value!r}, expected one of {", ".join(known)}')
    return known[value]


def settings_column(
    max_wheel_speed,
    motor_map='signed',
    episode_ticks=1000,
    infrared_response='squared',
    ground_coding='relative',
):
    """Return one robot's column of the `settings` array, float32 of shape (SETTING_ROWS,).

    Raises
    ------
    ValueError
        If a value is out of its range, in one sentence.
    """
    if not MIN_WHEEL_SPEED <= max_wheel_speed <= MAX_WHEEL_SPEED:
        raise ValueError(
            f'max_wheel_speed is {max_wheel_speed}, '
            f'expected rad/s from {MIN_WHEEL_SPEED:g} to {MAX_WHEEL_SPEED:g}'
        )
    if not 1 <= episode_ticks < math.inf:
        raise ValueError(
            f'episode_ticks is {episode_ticks}, expected a number of ticks of at least 1'
        )
    column = np.empty(SETTING_ROWS, dtype=np.float32)
    column[MAX_SPEED] = max_wheel_speed
    column[PER_MAX_SPEED] = 1.0 / max_wheel_speed
    column[PER_EPISODE] = 1.0 / episode_ticks
    column[DRIVE_SCALE], column[DRIVE_OFFSET] = _look_up('motor_map', motor_map, MOTOR_MAPS)
    column[LEAST_FACTOR] = _look_up('infrared_response', infrared_response, INFRARED_RESPONSES)
    column[GROUND_GAIN], column[GROUND_MEAN_SHARE], column[GROUND_OFFSET] = _look_up(
        'ground_coding', ground_coding, GROUND_CODINGS
    )
    return column
