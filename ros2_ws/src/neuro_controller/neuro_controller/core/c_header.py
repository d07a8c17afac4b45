"""A controller as one self-contained C99 header, for a robot without Python."""

import re

import numpy as np

from .controller import MOTOR_MAPS, settings_column
from .drive import WHEEL_RADIUS, WHEEL_SEPARATION
from .genome import (
    HIDDEN,
    HIDDEN_BIASES,
    HIDDEN_TO_HIDDEN,
    HIDDEN_TO_OUTPUT,
    LEAKS,
    OUTPUT_BIASES,
    OUTPUTS,
    SENSOR_TO_HIDDEN,
    SENSOR_TO_OUTPUT,
    SENSORS,
    check_genomes,
    weights_of,
)
from .network import FATIGUE_TICKS, INFRARED_RANGE

_TEMPLATE = """\
/* A controller evolved for a MarxBot, as one C99 header without dependencies but libm.
 *
 *     static @NAME@_controller robot;
 *     @NAME@_reset(&robot);
 *     every 0.1 s: @NAME@_step(&robot, readings, wheels);
 *
 * readings, 37 floats: 24 infrared distances from the body's rim in m, ray i at 7.5 + 15 i degrees
 * counter-clockwise from the heading (@RANGE@ or more, INFINITY too: nothing seen); 8 camera
 * sectors of 45 degrees counter-clockwise from the heading, the fraction of each that the opponent's
 * lights fill, 0 to 1; 4 ground sensors, front left, front right, rear left and rear right, darkness 0 to
 * 1; contact 0 or 1.
 * wheels: speeds of the left and right wheel, rad/s, positive forward. The body moves at
 * @NAME@_linear(wheels) m/s and @NAME@_angular(wheels) rad/s.
 *
 * Motor map: @MAP@. Highest wheel speed: @SPEED@ rad/s. The clock reads 1 after @TICKS@ ticks.
 */
#ifndef @GUARD@
#define @GUARD@

#include <math.h>

typedef struct {
    float inputs[@SENSORS@];  /* sensory neurons of the last step */
    float hidden[@HIDDEN@];
    float outputs[@OUTPUTS@];  /* motor neurons: translation, rotation */
    float effort[@FATIGUE@];  /* mean wheel speed of the last 20 s, as a fraction */
    double effort_sum;
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
    static const @NAME@_controller start;
    *c = start;
}

static inline float @NAME@_logistic(float net)
{
    return 1.0f / (1.0f + expf(-net));
}

static inline void @NAME@_perceive(@NAME@_controller *c, const float readings[37])
{
    float camera = 0.0f, ground = 0.0f;
    double tired = c->effort_sum / @FATIGUE@;
    int i, k;

    for (i = 0; i < 8; i++) {
        float total = 0.0f;
        for (k = 0; k < 3; k++) {
            float distance = readings[3 * i + k];
            total += distance < @RANGE@f ? 1.0f - distance / @RANGE@f : 0.0f;
        }
        c->inputs[i] = total / 3.0f;
    }
    for (i = 0; i < 8; i++) {
        c->inputs[8 + i] = readings[24 + i];
        camera += readings[24 + i];
    }
    c->inputs[16] = camera / 8.0f;
    for (i = 0; i < 4; i++) {
        c->inputs[17 + i] = readings[32 + i];
        ground += readings[32 + i];
    }
    c->inputs[21] = ground / 4.0f;
    c->inputs[22] = readings[36];
    c->inputs[23] = (float)c->tick / @TICKS@.0f;
    c->inputs[24] = (float)(tired * tired);
}

static inline void @NAME@_think(@NAME@_controller *c)
{
    float before[@HIDDEN@];
    int i, k;

    for (i = 0; i < @HIDDEN@; i++)
        before[i] = c->hidden[i];
    for (i = 0; i < @HIDDEN@; i++) {
        float net = @NAME@_hidden_bias[i], active;
        for (k = 0; k < @HIDDEN@; k++)
            net += @NAME@_hidden_to_hidden[i][k] * before[k];
        for (k = 0; k < @SENSORS@; k++)
            net += @NAME@_sensor_to_hidden[i][k] * c->inputs[k];
        active = @NAME@_logistic(net);
        c->hidden[i] = active + @NAME@_leak[i] * (before[i] - active);
    }
    for (i = 0; i < @OUTPUTS@; i++) {
        float net = @NAME@_output_bias[i];
        for (k = 0; k < @SENSORS@; k++)
            net += @NAME@_sensor_to_output[i][k] * c->inputs[k];
        for (k = 0; k < @HIDDEN@; k++)
            net += @NAME@_hidden_to_output[i][k] * c->hidden[k];
        c->outputs[i] = @NAME@_logistic(net);
    }
}

static inline void @NAME@_drive(@NAME@_controller *c, float wheels[2])
{
    float off = c->outputs[0] - 0.5f;
    float outer = @SPEED@f * (1.0f - c->inputs[24]) * (@SCALE@f * c->outputs[1] + @OFFSET@f);
    float inner = outer * (1.0f - 8.0f * off * off);
    float effort;

    wheels[0] = rintf(65536.0f * (off < 0.0f ? inner : outer)) / 65536.0f;
    wheels[1] = rintf(65536.0f * (off > 0.0f ? inner : outer)) / 65536.0f;
    effort = (fabsf(wheels[0]) + fabsf(wheels[1])) / (2.0f * @SPEED@f);
    effort = rintf(65536.0f * effort) / 65536.0f;
    c->effort_sum += (double)effort - (double)c->effort[c->slot];
    c->effort[c->slot] = effort;
    c->slot = (c->slot + 1) % @FATIGUE@;
    c->tick++;
}

static inline void @NAME@_step(@NAME@_controller *c, const float readings[37], float wheels[2])
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


def c_header(genome, name, max_wheel_speed, motor_map='printed', episode_ticks=1000):
    """Return a header that defines ``NAME_controller``, ``NAME_reset`` and ``NAME_step``.

    Its neurons agree with `Controller` to 1e-6; the exponential is libm's.

    Parameters
    ----------
    genome : array_like, shape (442,)
    name : str
        A C identifier, the prefix of everything the header defines.
    max_wheel_speed, motor_map, episode_ticks
        See `Controller`.

    Raises
    ------
    ValueError
        One of them is out of its range.
    """
    if not re.fullmatch(r'[a-z][a-z0-9_]*', name):
        raise ValueError(f'name is {name!r}, expected a C identifier in lower case')
    settings_column(max_wheel_speed, motor_map, episode_ticks)
    weights = weights_of(check_genomes(np.atleast_2d(genome), 'genome'))[0]
    scale, offset = MOTOR_MAPS[motor_map]

    def table(first, *shape):
        return _c_table(weights[first : first + int(np.prod(shape))].reshape(shape))

    values = {
        'NAME': name,
        'GUARD': f'{name.upper()}_CONTROLLER_H',
        'MAP': motor_map,
        'SPEED': _c_number(max_wheel_speed),
        'SCALE': _c_number(scale),
        'OFFSET': _c_number(offset),
        'TICKS': str(episode_ticks),
        'RANGE': _c_number(INFRARED_RANGE),
        'RADIUS': _c_number(WHEEL_RADIUS),
        'SEPARATION': _c_number(WHEEL_SEPARATION),
        'SENSORS': str(SENSORS),
        'HIDDEN': str(HIDDEN),
        'OUTPUTS': str(OUTPUTS),
        'FATIGUE': str(FATIGUE_TICKS),
        'HIDDEN_BIAS': table(HIDDEN_BIASES, HIDDEN),
        'OUTPUT_BIAS': table(OUTPUT_BIASES, OUTPUTS),
        'LEAK': table(LEAKS, HIDDEN),
        'SENSOR_TO_HIDDEN': table(SENSOR_TO_HIDDEN, HIDDEN, SENSORS),
        'HIDDEN_TO_HIDDEN': table(HIDDEN_TO_HIDDEN, HIDDEN, HIDDEN),
        'SENSOR_TO_OUTPUT': table(SENSOR_TO_OUTPUT, OUTPUTS, SENSORS),
        'HIDDEN_TO_OUTPUT': table(HIDDEN_TO_OUTPUT, OUTPUTS, HIDDEN),
    }
    return re.sub('@([A-Z_]+)@', lambda match: values[match[1]], _TEMPLATE)


def _c_number(value):
    text = f'{value:.9g}'
    return text if '.' in text or 'e' in text else f'{text}.0'


def _c_table(values):
    if values.ndim == 1:
        return '{' + ', '.join(f'{_c_number(value)}f' for value in values) + '}'
    return '{\n    ' + ',\n    '.join(_c_table(row) for row in values) + '}'
