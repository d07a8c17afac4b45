"""A controller as one self-contained header, C99 and C++17, for a robot without Python."""

import re
import textwrap

import numpy as np

from marxbot_sensors import CAMERA, GROUND, MARXBOT
from neuro_controller.core.drive import WHEEL_RADIUS, WHEEL_SEPARATION
from neuro_controller.core.genome import OUTPUTS, Layout, check_genomes, weights_of
from neuro_controller.core.network import (
    CAMERA_INPUTS,
    CAMERA_MEAN,
    CAMERA_READINGS,
    CONTACT,
    FATIGUE_TICKS,
    GROUND_INPUTS,
    GROUND_MEAN,
    GROUND_READINGS,
    GROUP,
    INFRARED_GROUPS,
    INFRARED_RANGE,
    TOUCH_READING,
)
from neuro_controller.core.settings import (
    DRIVE_OFFSET,
    DRIVE_SCALE,
    GROUND_GAIN,
    GROUND_MEAN_SHARE,
    GROUND_OFFSET,
    LEAST_FACTOR,
    PER_EPISODE,
    PER_MAX_SPEED,
    settings_column,
)

_TEMPLATE = """\
/* A controller evolved for a MarxBot, as one header that needs but libm: C99, and C++ too.
 *
 *     static @NAME@_controller robot;
 *     @NAME@_reset(&robot);
 *     every 0.1 s: @NAME@_step(&robot, readings, wheels);
 *
 * readings, @READINGS@ floats, from the place that each line names; degrees are counter-clockwise,
 * and infrared of @RANGE@ m or more, INFINITY too, means that nothing is seen:
@SENSOR_LIST@
 * wheels: speeds of the left and right wheel, rad/s, positive forward. The body moves at
 * @NAME@_linear(wheels) m/s and @NAME@_angular(wheels) rad/s.
 *
 * Genome: @PROVENANCE@.
 * Motor map: @MAP@. Infrared response: @RESPONSE@. Ground coding: @CODING@.
 * Highest wheel speed: @SPEED@ rad/s. The clock reads 1 after @TICKS@ ticks.
 */
#ifndef @GUARD@
#define @GUARD@

#include <math.h>
#include <string.h>

typedef struct {
    float inputs[@SENSORS@];  /* sensory neurons of the last step */
    float hidden[@HIDDEN@];
    float outputs[@OUTPUTS@];  /* motor neurons: translation, rotation */
    float effort[@FATIGUE@];  /* mean wheel speed of the last 20 s, as a fraction */
    float effort_sum;
    unsigned slot;
    unsigned long tick;
} @NAME@_controller;

static const float @NAME@_hidden_bias[@HIDDEN@] = @HIDDEN_BIAS@;
static const float @NAME@_output_bias[@OUTPUTS@] = @OUTPUT_BIAS@;
static const float @NAME@_leak[@HIDDEN@] = @LEAK@;
static const float @NAME@_sensor_to_hidden[@HIDDEN@][@SENSORS@] = @SENSOR_TO_HIDDEN@;
static const float @NAME@_hidden_to_hidden[@HIDDEN@][@HIDDEN@] = @HIDDEN_TO_HIDDEN@;
static const float @NAME@_sensor_to_output[@OUTPUTS@][@SENSORS@] = @SENSOR_TO_OUTPUT@;
static const float @NAME@_hidden_to_output[@OUTPUTS@][@HIDDEN@] = @HIDDEN_TO_OUTPUT@;

static inline void @NAME@_reset(@NAME@_controller *c)
{
    memset(c, 0, sizeof *c);
}

/* 1 / (1 + exp(-x)), with exp(-x) = 2^k 2^f, k an integer and |f| <= 1/2. */
static inline float @NAME@_logistic(float x)
{
    float k, f, square, high, middle, low;

    x = fminf(fmaxf(x, -30.0f), 30.0f);
    k = rintf(fmaf(x, -1.44269504f, 0.0f));
    f = fmaf(x, -1.44269504f, -k);
    square = f * f;
    high = fmaf(f, 0.0013276470f, 0.0096755416f);
    middle = fmaf(f, 0.055507133f, 0.24022120f);
    low = fmaf(f, 0.69314697f, 1.0000001f);
    low = fmaf(fmaf(high, square, middle), square, low);
    return 1.0f / (1.0f + ldexpf(low, (int)k));
}

static inline float @NAME@_mean(const float *values, int count)
{
    float total = 0.0f;
    int i;
    for (i = 0; i < count; i += 4)
        total += (values[i] + values[i + 1]) + (values[i + 2] + values[i + 3]);
    return total / (float)count;
}

static inline void @NAME@_perceive(@NAME@_controller *c, const float readings[@READINGS@])
{
    static const float scale[@DIRECT@] = @SCALES@, offset[@DIRECT@] = @OFFSETS@;
    float tired = c->effort_sum * @PER_FATIGUE@f;
    int i, k;

    for (i = 0; i < @GROUPS@; i++) {
        float total = 0.0f;
        for (k = 0; k < @GROUP@; k++) {
            float near = fmaxf(fmaf(readings[@GROUP@ * i + k], -@PER_RANGE@f, 1.0f), 0.0f);
            total = fmaf(near, fmaxf(near, @LEAST_FACTOR@f), total);
        }
        c->inputs[i] = total * @THIRD@f;
    }
    memcpy(c->inputs + @CAMERA_INPUTS@, readings + @CAMERA_READINGS@, @SECTORS@ * sizeof(float));
    c->inputs[@CAMERA_MEAN@] = @NAME@_mean(readings + @CAMERA_READINGS@, @SECTORS@);
    c->inputs[@GROUND_MEAN@] = @NAME@_mean(readings + @GROUND_READINGS@, @GROUNDS@);
    for (i = 0; i < @GROUNDS@; i++) {
        float mean = c->inputs[@GROUND_MEAN@];
        float above = readings[@GROUND_READINGS@ + i] - @GROUND_MEAN_SHARE@f * mean;
        float coded = fmaf(@GROUND_GAIN@f, above, @GROUND_OFFSET@f);
        c->inputs[@GROUND@ + i] = fminf(fmaxf(coded, 0.0f), 1.0f);
    }
    for (i = 0; i < @DIRECT@; i++)
        c->inputs[@CONTACT@ + i] = fmaf(scale[i], readings[@TOUCH_READING@ + i], offset[i]);
    c->inputs[@CLOCK@] = (float)c->tick * @PER_EPISODE@f;
    c->inputs[@TIRED@] = tired * tired;
}

/* Adds weighted values in the order, and with the single rounding, of the original. */
static inline float @NAME@_sum(float net, const float *weights, const float *values, int first,
                               int end)
{
    int i;
    for (i = first; i < end; i++)
        net = fmaf(weights[i], values[i], net);
    return net;
}

static inline void @NAME@_think(@NAME@_controller *c)
{
    float before[@HIDDEN@];
    int i;

    for (i = 0; i < @HIDDEN@; i++)
        before[i] = c->hidden[i];
    for (i = 0; i < @HIDDEN@; i++) {
        const float *sensors = @NAME@_sensor_to_hidden[i];
        float net = @NAME@_hidden_bias[i], active;
        net = @NAME@_sum(net, @NAME@_hidden_to_hidden[i], before, 0, @HIDDEN@);
        net = @NAME@_sum(net, sensors, c->inputs, @GROUND@, @SENSORS@);
        net = @NAME@_sum(net, sensors, c->inputs, 0, @GROUND@);
        active = @NAME@_logistic(net);
        c->hidden[i] = fmaf(@NAME@_leak[i], before[i] - active, active);
    }
    for (i = 0; i < @OUTPUTS@; i++) {
        const float *sensors = @NAME@_sensor_to_output[i];
        float net = @NAME@_output_bias[i];
        net = @NAME@_sum(net, sensors, c->inputs, @GROUND@, @SENSORS@);
        net = @NAME@_sum(net, sensors, c->inputs, 0, @GROUND@);
        net = @NAME@_sum(net, @NAME@_hidden_to_output[i], c->hidden, 0, @HIDDEN@);
        c->outputs[i] = @NAME@_logistic(net);
    }
}

static inline void @NAME@_drive(@NAME@_controller *c, float wheels[2])
{
    float off = c->outputs[0] - 0.5f;
    float fresh = @SPEED@f * (1.0f - c->inputs[@TIRED@]);
    float outer = fresh * fmaf(c->outputs[1], @SCALE@f, @OFFSET@f);
    float inner = outer * fmaf(off * off, -8.0f, 1.0f);
    float effort;

    wheels[0] = rintf(65536.0f * (off < 0.0f ? inner : outer)) / 65536.0f;
    wheels[1] = rintf(65536.0f * (off > 0.0f ? inner : outer)) / 65536.0f;
    effort = (fabsf(wheels[0]) + fabsf(wheels[1])) * @HALF_PER_SPEED@f;
    effort = rintf(65536.0f * effort) / 65536.0f;
    c->effort_sum += effort - c->effort[c->slot];
    c->effort[c->slot] = effort;
    c->slot = (c->slot + 1) % @FATIGUE@;
    c->tick++;
}

static inline void @NAME@_step(@NAME@_controller *c, const float readings[@READINGS@],
                               float wheels[2])
{
    @NAME@_perceive(c, readings);
    @NAME@_think(c);
    @NAME@_drive(c, wheels);
}

static inline double @NAME@_linear(const float wheels[2])
{
    return @RADIUS@ * ((double)wheels[0] + (double)wheels[1]) / 2.0;
}

static inline double @NAME@_angular(const float wheels[2])
{
    return @RADIUS@ * ((double)wheels[1] - (double)wheels[0]) / @SEPARATION@;
}

#endif
"""


def c_header(
    genome,
    name,
    max_wheel_speed,
    motor_map='signed',
    episode_ticks=1000,
    infrared_response='squared',
    ground_coding='relative',
    provenance='unknown',
    robot=MARXBOT,
):
    """Return a header that defines ``NAME_controller``, ``NAME_reset`` and ``NAME_step``.

    It computes as `Controller` does, in the same order with the same roundings.

    Parameters
    ----------
    genome : array_like, shape (genes,)
    name : str
        A C identifier, the prefix of everything the header defines.
    max_wheel_speed, motor_map, episode_ticks, infrared_response, ground_coding
        See `Controller`.
    provenance : str
        Where the genome comes from, for the comment at the header's top.
    robot : marxbot_sensors.Robot
        Whose sensors it reads.

    Raises
    ------
    ValueError
        One of them is out of its range.
    """
    if not re.fullmatch(r'[a-z][a-z0-9_]*', name):
        raise ValueError(f'name is {name!r}, expected a C identifier in lower case')
    settings = settings_column(
        max_wheel_speed, motor_map, episode_ticks, infrared_response, ground_coding
    )
    layout = Layout.of(np.size(genome), robot)
    genomes = check_genomes(np.reshape(genome, (1, -1)), 'genome', layout)
    weights = weights_of(genomes, layout)[0]
    inputs, hidden = layout.inputs, layout.hidden

    def table(first, *shape):
        return _c_table(weights[first : first + int(np.prod(shape))].reshape(shape))

    values = {
        'NAME': name,
        'PROVENANCE': ' '.join(provenance.replace('*/', '* /').split()),
        'GUARD': f'{name.upper()}_CONTROLLER_H',
        'MAP': motor_map,
        'SPEED': _c_number(max_wheel_speed),
        'HALF_PER_SPEED': _c_number(settings[PER_MAX_SPEED] / 2),
        'PER_EPISODE': _c_number(settings[PER_EPISODE]),
        'PER_FATIGUE': _c_number(np.float32(1 / FATIGUE_TICKS)),
        'PER_RANGE': _c_number(1 / INFRARED_RANGE),
        'THIRD': _c_number(np.float32(1 / 3)),
        'SCALE': _c_number(settings[DRIVE_SCALE]),
        'OFFSET': _c_number(settings[DRIVE_OFFSET]),
        'RESPONSE': infrared_response,
        'LEAST_FACTOR': _c_number(settings[LEAST_FACTOR]),
        'CODING': ground_coding,
        'GROUND_GAIN': _c_number(settings[GROUND_GAIN]),
        'GROUND_MEAN_SHARE': _c_number(settings[GROUND_MEAN_SHARE]),
        'GROUND_OFFSET': _c_number(settings[GROUND_OFFSET]),
        'TICKS': str(episode_ticks),
        'RANGE': _c_number(INFRARED_RANGE),
        'RADIUS': _c_number(WHEEL_RADIUS),
        'SEPARATION': _c_number(WHEEL_SEPARATION),
        **{name: str(number) for name, number in _places(layout).items()},
        'SENSOR_LIST': _sensor_list(robot),
        'SCALES': _c_table(np.array(robot.scales)),
        'OFFSETS': _c_table(np.array(robot.offsets) + 0.0),
        'SENSORS': str(inputs),
        'HIDDEN': str(hidden),
        'OUTPUTS': str(OUTPUTS),
        'FATIGUE': str(FATIGUE_TICKS),
        'HIDDEN_BIAS': table(0, hidden),
        'OUTPUT_BIAS': table(layout.output_biases, OUTPUTS),
        'LEAK': table(layout.leaks, hidden),
        'SENSOR_TO_HIDDEN': table(layout.input_to_hidden, hidden, inputs),
        'HIDDEN_TO_HIDDEN': table(layout.hidden_to_hidden, hidden, hidden),
        'SENSOR_TO_OUTPUT': table(layout.input_to_output, OUTPUTS, inputs),
        'HIDDEN_TO_OUTPUT': table(layout.hidden_to_output, OUTPUTS, hidden),
    }
    return re.sub('@([A-Z_]+)@', lambda match: values[match[1]], _TEMPLATE)


def _places(layout):
    """Return sizes and offsets of readings and sensory neurons."""
    return {
        'READINGS': layout.robot.readings,
        'GROUPS': INFRARED_GROUPS,
        'GROUP': GROUP,
        'CAMERA_READINGS': CAMERA_READINGS,
        'CAMERA_INPUTS': CAMERA_INPUTS,
        'CAMERA_MEAN': CAMERA_MEAN,
        'SECTORS': CAMERA.count,
        'GROUND_READINGS': GROUND_READINGS,
        'GROUND': GROUND_INPUTS,
        'GROUND_MEAN': GROUND_MEAN,
        'GROUNDS': GROUND.count,
        'TOUCH_READING': TOUCH_READING,
        'CONTACT': CONTACT,
        'DIRECT': len(layout.scales),
        'CLOCK': layout.clock,
        'TIRED': layout.fatigue,
    }


def _sensor_list(robot):
    """Return a line for each sensor, as part of a comment."""
    lines = []
    for sensor in robot.sensors:
        first = robot.rows(sensor).start
        lines += textwrap.wrap(
            f'{first}: {sensor.name}, {sensor.text};',
            width=99,
            initial_indent=' *   ',
            subsequent_indent=' *     ',
        )
    return '\n'.join(lines)


def _c_number(value):
    text = f'{value:.9g}'
    return text if '.' in text or 'e' in text else f'{text}.0'


def _c_table(values):
    if values.ndim == 1:
        return '{' + ', '.join(f'{_c_number(value)}f' for value in values) + '}'
    return '{\n    ' + ',\n    '.join(_c_table(row) for row in values) + '}'
