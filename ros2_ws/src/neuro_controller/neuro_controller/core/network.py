"""From readings to wheels: sensors, leaky recurrent network, motors (paper A2), for 16 robots.

Rows of the arrays, each float32 of shape (rows, 16):

* `weights`: the genome, with the leaks as `genome.weights_of` gives them;
* `inputs`: the sensory neurons, 0..1: 8 infrared groups, 8 camera sectors, their mean, 4 ground
  sensors, the mean of their readings, contact, those of further sensors, clock, fatigue;
* `memory`: the 2 motor neurons of the last tick, the sum of the recent speeds, the ticks passed,
  the hidden neurons, and the recurrent input of each in the next tick (that of the first tick,
  with hidden neurons at 0, is the biases);
* `history`: the speeds of the last 200 ticks, those before the start being ignored;
* `settings`: what differs between robots and episodes, see `settings.settings_column`.

Every kernel is compiled for a `genome.Layout`, whose sizes and offsets are constants to it.
"""

import numba

import marxbot_sensors as sensors
from marxbot_sensors import MARXBOT
from neuro_controller.core.genome import OUTPUTS, Layout
from neuro_controller.core.settings import (
    DRIVE_OFFSET,
    DRIVE_SCALE,
    GROUND_GAIN,
    GROUND_MEAN_SHARE,
    GROUND_OFFSET,
    LEAST_FACTOR,
    MAX_SPEED,
    PER_EPISODE,
    PER_MAX_SPEED,
)
from simd_lanes import (
    absolute,
    compile_for,
    fma,
    kernel_part,
    load,
    logistic,
    maximum,
    minimum,
    select,
    splat,
    store,
)

compile_for(Layout)

INFRARED_GROUPS = sensors.INFRARED.neurons
GROUP = sensors.INFRARED.count // INFRARED_GROUPS
INFRARED_READINGS, CAMERA_READINGS, GROUND_READINGS, TOUCH_READING = (
    MARXBOT.rows(sensor).start for sensor in MARXBOT.sensors[:4]
)
INFRARED_RANGE = sensors.INFRARED.high
"""Distance, m, at which an infrared activation has fallen to 0."""

CAMERA_INPUTS, GROUND_INPUTS, CONTACT = (
    MARXBOT.inputs(sensor).start for sensor in MARXBOT.sensors[1:4]
)
CAMERA_MEAN = CAMERA_INPUTS + sensors.CAMERA.count
GROUND_MEAN = GROUND_INPUTS + sensors.GROUND.count

MOTORS, SPEED_SUM, TICKS, STATE = 0, OUTPUTS, OUTPUTS + 1, OUTPUTS + 2


@numba.njit(forceinline=True)
def recall_row(layout):
    """Return the row of `memory` with the recurrent input of the first hidden neuron."""
    return STATE + layout.hidden


TOGETHER = 10
"""Hidden neurons whose sums are made side by side, where there are so many; others' one by one."""


@numba.njit(forceinline=True)
def _alone(layout):
    """Return the first hidden neuron whose sum is made by itself."""
    return TOGETHER if layout.hidden >= TOGETHER else 0


def memory_rows(layout):
    """Return the number of rows of `memory`."""
    return STATE + 2 * layout.hidden


FATIGUE_TICKS = 200
"""Length of the fatigue window: 20 s (paper eq. 1)."""

LEFT, RIGHT = range(2)

# A float32 in [128, 256) is a multiple of 2**-16, so adding and subtracting these rounds to that.
_SPEED_GRID = 192.0
_EFFORT_GRID = 128.0


@numba.njit(forceinline=True)
def perceive(layout, readings, memory, settings, inputs):
    """Fill the sensory neurons from the readings, and from the controller's clock and fatigue."""
    least_factor = load(settings, LEAST_FACTOR)
    for group in range(INFRARED_GROUPS):
        total = _add_activation(0.0, readings, GROUP * group, least_factor)
        total = _add_activation(total, readings, GROUP * group + 1, least_factor)
        total = _add_activation(total, readings, GROUP * group + 2, least_factor)
        store(inputs, group, total * (1.0 / GROUP))
    ahead_and_left = _copy_four(readings, CAMERA_READINGS, inputs, CAMERA_INPUTS)
    behind_and_right = _copy_four(readings, CAMERA_READINGS + 4, inputs, CAMERA_INPUTS + 4)
    store(inputs, CAMERA_MEAN, (ahead_and_left + behind_and_right) * 0.125)
    mean = _copy_four(readings, GROUND_READINGS, inputs, GROUND_INPUTS) * 0.25
    store(inputs, GROUND_MEAN, mean)
    _code_ground(mean, settings, inputs)
    scales, offsets = layout.scales, layout.offsets
    for i in range(len(scales)):
        value = load(readings, TOUCH_READING + i)
        store(inputs, CONTACT + i, fma(scales[i], value, offsets[i]))
    store(inputs, layout.clock, load(memory, TICKS) * load(settings, PER_EPISODE))
    mean_speed = load(memory, SPEED_SUM) * (1.0 / FATIGUE_TICKS)
    store(inputs, layout.fatigue, mean_speed * mean_speed)


@numba.njit(forceinline=True)
def _add_activation(total, readings, ray, least_factor):
    """Add a max(a, least factor) with a = 1 - d/range: its square, or itself where that is 1."""
    near = fma(load(readings, INFRARED_READINGS + ray), -1.0 / INFRARED_RANGE, 1.0)
    near = maximum(near, 0.0)
    return fma(near, maximum(near, least_factor), total)


@numba.njit(forceinline=True)
def _code_ground(mean, settings, inputs):
    """Make offset + gain (g - share mean), kept in 0..1, of each ground sensor's darkness g."""
    gain, offset = load(settings, GROUND_GAIN), load(settings, GROUND_OFFSET)
    base = load(settings, GROUND_MEAN_SHARE) * mean
    for sensor in range(GROUND_INPUTS, GROUND_MEAN):
        coded = fma(gain, load(inputs, sensor) - base, offset)
        store(inputs, sensor, minimum(maximum(coded, 0.0), 1.0))


@numba.njit(forceinline=True)
def _copy(readings, row, inputs, target):
    value = load(readings, row)
    store(inputs, target, value)
    return value


@numba.njit(forceinline=True)
def _copy_four(readings, first, inputs, target):
    """Copy four readings to the inputs and return their sum."""
    left = _copy(readings, first, inputs, target) + _copy(readings, first + 1, inputs, target + 1)
    right = _copy(readings, first + 2, inputs, target + 2) + _copy(
        readings, first + 3, inputs, target + 3
    )
    return left + right


@numba.njit(forceinline=True)
def _sense_six(layout, sums, weights, inputs, neuron, output, start, end):
    """Add what sensory neurons `start` to `end - 1` give to five hidden neurons and to one output.

    Six sums at a time, because a value is then loaded once for six products, and the additions to
    one sum do not wait for each other.
    """
    a, b, c, d, e, f = sums
    count = layout.inputs
    hidden = layout.input_to_hidden + count * neuron
    motor = layout.input_to_output + count * output
    for i in range(start, end):
        value = load(inputs, i)
        a = fma(load(weights, hidden + i), value, a)
        b = fma(load(weights, hidden + count + i), value, b)
        c = fma(load(weights, hidden + 2 * count + i), value, c)
        d = fma(load(weights, hidden + 3 * count + i), value, d)
        e = fma(load(weights, hidden + 4 * count + i), value, e)
        f = fma(load(weights, motor + i), value, f)
    return a, b, c, d, e, f


@numba.njit(forceinline=True)
def _net_six(layout, weights, memory, inputs, neuron, output):
    """Return the net input of five hidden neurons, and what the sensors give to one output."""
    first = recall_row(layout) + neuron
    sums = (
        load(memory, first),
        load(memory, first + 1),
        load(memory, first + 2),
        load(memory, first + 3),
        load(memory, first + 4),
        load(weights, layout.output_biases + output),
    )
    sums = _sense_six(layout, sums, weights, inputs, neuron, output, GROUND_INPUTS, layout.inputs)
    return _sense_six(layout, sums, weights, inputs, neuron, output, 0, GROUND_INPUTS)


@numba.njit(forceinline=True)
def _net(layout, net, weights, first, inputs):
    """Add to a sum, in the same order, what the sensors give by the weights from `first` on."""
    for i in range(GROUND_INPUTS, layout.inputs):
        net = fma(load(weights, first + i), load(inputs, i), net)
    for i in range(GROUND_INPUTS):
        net = fma(load(weights, first + i), load(inputs, i), net)
    return net


@numba.njit(forceinline=True)
def _net_output(layout, weights, inputs, output):
    """Return what the sensors give to one output."""
    bias = load(weights, layout.output_biases + output)
    return _net(layout, bias, weights, layout.input_to_output + layout.inputs * output, inputs)


@numba.njit(forceinline=True)
def _net_hidden(layout, weights, memory, inputs, neuron):
    """Return the net input of one hidden neuron."""
    recalled = load(memory, recall_row(layout) + neuron)
    return _net(layout, recalled, weights, layout.input_to_hidden + layout.inputs * neuron, inputs)


@numba.njit(forceinline=True)
def _recall_five(layout, weights, memory, neuron):
    """Set what five hidden neurons will get in the next tick from bias and recurrence."""
    a, b, c = load(weights, neuron), load(weights, neuron + 1), load(weights, neuron + 2)
    d, e = load(weights, neuron + 3), load(weights, neuron + 4)
    hidden = layout.hidden
    first = layout.hidden_to_hidden + hidden * neuron
    for i in range(hidden):
        value = load(memory, STATE + i)
        a = fma(load(weights, first + i), value, a)
        b = fma(load(weights, first + hidden + i), value, b)
        c = fma(load(weights, first + 2 * hidden + i), value, c)
        d = fma(load(weights, first + 3 * hidden + i), value, d)
        e = fma(load(weights, first + 4 * hidden + i), value, e)
    for offset, total in enumerate((a, b, c, d, e)):
        store(memory, recall_row(layout) + neuron + offset, total)


@numba.njit(forceinline=True)
def _recall(layout, weights, memory, neuron):
    """Set what one hidden neuron will get in the next tick from bias and recurrence."""
    total = load(weights, neuron)
    first = layout.hidden_to_hidden + layout.hidden * neuron
    for i in range(layout.hidden):
        total = fma(load(weights, first + i), load(memory, STATE + i), total)
    store(memory, recall_row(layout) + neuron, total)


@kernel_part
def recall(layout, weights, memory):
    """Set the recurrent input of the next tick.

    It is known as soon as the hidden neurons are, and computed then: the processor has little else
    to do while one number after the other goes through motors and motion.
    """
    if layout.hidden >= TOGETHER:
        _recall_five(layout, weights, memory, 0)
        _recall_five(layout, weights, memory, 5)
    for neuron in range(_alone(layout), layout.hidden):
        _recall(layout, weights, memory, neuron)


@numba.njit(forceinline=True)
def _leak(layout, weights, memory, neuron, net):
    """Update one hidden neuron: h = d h' + (1 - d) logistic(net)."""
    active = logistic(net)
    before, leak = load(memory, STATE + neuron), load(weights, layout.leaks + neuron)
    store(memory, STATE + neuron, fma(leak, before - active, active))


@numba.njit(forceinline=True)
def think(layout, weights, memory, inputs):
    """Run the network for one tick: leaky recurrent neurons, then two logistic outputs."""
    if layout.hidden >= TOGETHER:
        a, b, c, d, e, translation = _net_six(layout, weights, memory, inputs, 0, 0)
        f, g, h, i, j, rotation = _net_six(layout, weights, memory, inputs, 5, 1)
        for neuron, net in enumerate((a, b, c, d, e, f, g, h, i, j)):
            _leak(layout, weights, memory, neuron, net)
    else:
        translation = _net_output(layout, weights, inputs, 0)
        rotation = _net_output(layout, weights, inputs, 1)
    for neuron in range(_alone(layout), layout.hidden):
        net = _net_hidden(layout, weights, memory, inputs, neuron)
        _leak(layout, weights, memory, neuron, net)
    first = layout.hidden_to_output
    for neuron in range(layout.hidden):
        value = load(memory, STATE + neuron)
        translation = fma(load(weights, first + neuron), value, translation)
        rotation = fma(load(weights, first + layout.hidden + neuron), value, rotation)
    store(memory, MOTORS, logistic(translation))
    store(memory, MOTORS + 1, logistic(rotation))


@numba.njit(forceinline=True)
def drive(layout, memory, inputs, settings, history, slot, wheels):
    """Set the wheels from the motor neurons (paper eq. 1-5) and remember the effort.

    Wheel speeds are rounded to multiples of 2**-16 rad/s, which a Twist message carries without
    loss, and the effort of a tick to multiples of 2**-16, so that the sum over 200 ticks is exact
    and does not drift.
    """
    tm, rm = load(memory, MOTORS), load(memory, MOTORS + 1)
    max_speed = load(settings, MAX_SPEED)
    speed = max_speed * (1.0 - load(inputs, layout.fatigue))
    speed = speed * fma(rm, load(settings, DRIVE_SCALE), load(settings, DRIVE_OFFSET))
    off_middle = tm - 0.5
    inner = speed * fma(off_middle * off_middle, -8.0, 1.0)
    left = (select(tm < 0.5, inner, speed) + _SPEED_GRID) - _SPEED_GRID
    right = (select(tm > 0.5, inner, speed) + _SPEED_GRID) - _SPEED_GRID
    store(wheels, LEFT, left)
    store(wheels, RIGHT, right)

    effort = (absolute(left) + absolute(right)) * (load(settings, PER_MAX_SPEED) * 0.5)
    effort = (effort + _EFFORT_GRID) - _EFFORT_GRID
    ticks = load(memory, TICKS)
    leaving = select(ticks < FATIGUE_TICKS, splat(0.0), load(history, slot))
    store(memory, SPEED_SUM, load(memory, SPEED_SUM) - leaving + effort)
    store(history, slot, effort)
    store(memory, TICKS, ticks + 1.0)


@kernel_part
def control(layout, readings, weights, settings, memory, history, slot, inputs, wheels):
    """Run the controllers of 16 robots for one tick.

    Parameters
    ----------
    layout : neuro_controller.core.genome.Layout
    readings : float32 array, shape (layout.robot.readings, 16)
        In the order of the robot's sensors.
    weights, settings : float32 arrays, shapes (layout.genes, 16) and (SETTING_ROWS, 16)
    memory, history : float32 arrays, shapes (memory_rows(layout), 16) and (FATIGUE_TICKS, 16)
        Updated.
    slot : int
        Row of `history` that holds the oldest tick: the count of calls modulo FATIGUE_TICKS.
    inputs, wheels : float32 arrays, shapes (layout.inputs, 16) and (2, 16)
        Written; wheels left and right, rad/s.
    """
    perceive(layout, readings, memory, settings, inputs)
    think(layout, weights, memory, inputs)
    recall(layout, weights, memory)
    drive(layout, memory, inputs, settings, history, slot, wheels)
