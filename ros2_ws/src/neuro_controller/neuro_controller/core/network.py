"""From a robot's readings to its wheels: sensors, leaky recurrent network, motors (paper A2), for 16 robots at once.

Rows of the arrays, each float32 of shape (rows, 16):

* `weights`: the genome, with the leaks as `genome.weights_of` gives them;
* `inputs`: the 25 sensory neurons, 0..1: 8 infrared groups, 8 camera sectors, their mean, 4 ground sensors, their
  mean, collision, clock, fatigue;
* `memory`: 10 hidden neurons, the 2 motor neurons of the last tick, the sum of the recent speeds, the ticks passed;
* `history`: the speeds of the last 200 ticks;
* `settings`: what differs between robots and episodes, see `controller.settings_rows`.
"""

import numba
from simd_lanes import absolute, fma, load, logistic, maximum, select, store

from .genome import (
    HIDDEN,
    HIDDEN_BIASES,
    HIDDEN_TO_HIDDEN,
    HIDDEN_TO_OUTPUT,
    LEAKS,
    OUTPUT_BIASES,
    SENSOR_TO_HIDDEN,
    SENSOR_TO_OUTPUT,
    SENSORS,
)

INFRARED_GROUPS, GROUP = 8, 3
INFRARED_READINGS, CAMERA_READINGS, GROUND_READINGS, TOUCH_READING = 0, 24, 32, 36
INFRARED_RANGE = 0.1
"""Distance, m, at which an infrared activation has fallen to 0."""

CAMERA_INPUTS, CAMERA_MEAN, GROUND_INPUTS, GROUND_MEAN, COLLISION, CLOCK, FATIGUE = 8, 16, 17, 21, 22, 23, 24

MOTORS, SPEED_SUM, TICKS = HIDDEN, HIDDEN + 2, HIDDEN + 3
MEMORY_ROWS = HIDDEN + 4

FATIGUE_TICKS = 200
"""Length of the fatigue window: 20 s (paper eq. 1)."""

MAX_SPEED, PER_MAX_SPEED, PER_EPISODE, DRIVE_SCALE, DRIVE_OFFSET = range(5)
SETTING_ROWS = 5

LEFT, RIGHT = range(2)

_SPEED_GRID = 192.0  # a float32 in [128, 256) is a multiple of 2**-16, so adding and subtracting rounds to that
_EFFORT_GRID = 128.0


@numba.njit(forceinline=True)
def perceive(readings, memory, settings, inputs):
    """Fill the sensory neurons from the readings and from what the controller itself knows: clock and fatigue."""
    for group in range(INFRARED_GROUPS):
        total = _activation(readings, GROUP * group)
        total = total + _activation(readings, GROUP * group + 1)
        total = total + _activation(readings, GROUP * group + 2)
        store(inputs, group, total * (1.0 / GROUP))
    _copy_with_mean(readings, CAMERA_READINGS, 8, inputs, CAMERA_INPUTS)
    _copy_with_mean(readings, GROUND_READINGS, 4, inputs, GROUND_INPUTS)
    store(inputs, COLLISION, load(readings, TOUCH_READING))
    store(inputs, CLOCK, load(memory, TICKS) * load(settings, PER_EPISODE))
    mean_speed = load(memory, SPEED_SUM) * (1.0 / FATIGUE_TICKS)
    store(inputs, FATIGUE, mean_speed * mean_speed)


@numba.njit(forceinline=True)
def _activation(readings, ray):
    return maximum(fma(load(readings, INFRARED_READINGS + ray), -1.0 / INFRARED_RANGE, 1.0), 0.0)


@numba.njit(forceinline=True)
def _copy_with_mean(readings, first, count, inputs, target):
    """Copy `count` readings to `inputs` and put their mean behind them."""
    total = load(readings, first)
    store(inputs, target, total)
    for i in range(1, count):
        value = load(readings, first + i)
        store(inputs, target + i, value)
        total = total + value
    store(inputs, target + count, total * (1.0 / count))


@numba.njit(forceinline=True)
def _accumulate(sums, values, count, weights, first, stride):
    """Add ``sum_i values[i] * weights[first + stride * target + i]`` to each of five targets' sums.

    Five sums at a time, because a value is then loaded once for five products and the additions do not wait for
    each other.
    """
    a, b, c, d, e = sums
    for i in range(count):
        value = load(values, i)
        a = fma(load(weights, first + i), value, a)
        b = fma(load(weights, first + stride + i), value, b)
        c = fma(load(weights, first + 2 * stride + i), value, c)
        d = fma(load(weights, first + 3 * stride + i), value, d)
        e = fma(load(weights, first + 4 * stride + i), value, e)
    return a, b, c, d, e


@numba.njit(forceinline=True)
def _net_of_five(weights, memory, inputs, neuron):
    """Return the net input of hidden neurons `neuron` to `neuron + 4`."""
    bias = HIDDEN_BIASES + neuron
    sums = (
        load(weights, bias),
        load(weights, bias + 1),
        load(weights, bias + 2),
        load(weights, bias + 3),
        load(weights, bias + 4),
    )
    sums = _accumulate(sums, memory, HIDDEN, weights, HIDDEN_TO_HIDDEN + HIDDEN * neuron, HIDDEN)
    return _accumulate(sums, inputs, SENSORS, weights, SENSOR_TO_HIDDEN + SENSORS * neuron, SENSORS)


@numba.njit(forceinline=True)
def _leak(weights, memory, neuron, net):
    """Update one hidden neuron: h = d h' + (1 - d) logistic(net)."""
    active = logistic(net)
    store(memory, neuron, fma(load(weights, LEAKS + neuron), load(memory, neuron) - active, active))


@numba.njit(forceinline=True)
def _leak_five(weights, memory, neuron, nets):
    a, b, c, d, e = nets
    _leak(weights, memory, neuron, a)
    _leak(weights, memory, neuron + 1, b)
    _leak(weights, memory, neuron + 2, c)
    _leak(weights, memory, neuron + 3, d)
    _leak(weights, memory, neuron + 4, e)


@numba.njit(forceinline=True)
def think(weights, memory, inputs):
    """Run the network for one tick: ten leaky hidden neurons, all-to-all recurrent, and two logistic outputs."""
    first_five = _net_of_five(weights, memory, inputs, 0)
    last_five = _net_of_five(weights, memory, inputs, 5)
    _leak_five(weights, memory, 0, first_five)
    _leak_five(weights, memory, 5, last_five)

    translation, rotation = load(weights, OUTPUT_BIASES), load(weights, OUTPUT_BIASES + 1)
    for i in range(SENSORS):
        value = load(inputs, i)
        translation = fma(load(weights, SENSOR_TO_OUTPUT + i), value, translation)
        rotation = fma(load(weights, SENSOR_TO_OUTPUT + SENSORS + i), value, rotation)
    for i in range(HIDDEN):
        value = load(memory, i)
        translation = fma(load(weights, HIDDEN_TO_OUTPUT + i), value, translation)
        rotation = fma(load(weights, HIDDEN_TO_OUTPUT + HIDDEN + i), value, rotation)
    store(memory, MOTORS, logistic(translation))
    store(memory, MOTORS + 1, logistic(rotation))


@numba.njit(forceinline=True)
def drive(memory, inputs, settings, history, slot, wheels):
    """Set the wheels from the motor neurons (paper eq. 1-5) and remember the effort.

    Wheel speeds are rounded to multiples of 2**-16 rad/s, which a Twist message carries without loss, and the effort
    of a tick to multiples of 2**-16, so that the sum over 200 ticks is exact and does not drift.
    """
    tm, rm = load(memory, MOTORS), load(memory, MOTORS + 1)
    max_speed = load(settings, MAX_SPEED)
    speed = max_speed * (1.0 - load(inputs, FATIGUE))
    speed = speed * fma(rm, load(settings, DRIVE_SCALE), load(settings, DRIVE_OFFSET))
    off_middle = tm - 0.5
    inner = speed * fma(off_middle * off_middle, -8.0, 1.0)
    left = (select(tm < 0.5, inner, speed) + _SPEED_GRID) - _SPEED_GRID
    right = (select(tm > 0.5, inner, speed) + _SPEED_GRID) - _SPEED_GRID
    store(wheels, LEFT, left)
    store(wheels, RIGHT, right)

    effort = (absolute(left) + absolute(right)) * (load(settings, PER_MAX_SPEED) * 0.5)
    effort = (effort + _EFFORT_GRID) - _EFFORT_GRID
    store(memory, SPEED_SUM, load(memory, SPEED_SUM) - load(history, slot) + effort)
    store(history, slot, effort)
    store(memory, TICKS, load(memory, TICKS) + 1.0)


@numba.njit(forceinline=True)
def control(readings, weights, settings, memory, history, slot, inputs, wheels):
    """Run the controllers of 16 robots for one tick.

    Parameters
    ----------
    readings : float32 array, shape (37, 16)
        24 infrared distances, m; 8 camera sectors; 4 ground sensors; contact.
    weights, settings : float32 arrays, shapes (442, 16) and (SETTING_ROWS, 16)
    memory, history : float32 arrays, shapes (MEMORY_ROWS, 16) and (FATIGUE_TICKS, 16)
        Updated.
    slot : int
        Row of `history` that holds the oldest tick: the count of calls modulo FATIGUE_TICKS.
    inputs, wheels : float32 arrays, shapes (25, 16) and (2, 16)
        Written; wheels left and right, rad/s.
    """
    perceive(readings, memory, settings, inputs)
    think(weights, memory, inputs)
    drive(memory, inputs, settings, history, slot, wheels)
