"""A controller as one self-contained header, C99 and C++17, for a robot without Python."""

import re

import numpy as np

from neuro_controller.core.controller import settings_column
from neuro_controller.core.drive import WHEEL_RADIUS, WHEEL_SEPARATION
from neuro_controller.core.genome import (
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
from neuro_controller.core.network import (
    DRIVE_OFFSET,
    DRIVE_SCALE,
    FATIGUE_TICKS,
    GROUND_GAIN,
    GROUND_INPUTS,
    GROUND_MEAN_SHARE,
    GROUND_OFFSET,
    INFRARED_RANGE,
    LEAST_FACTOR,
    PER_EPISODE,
    PER_MAX_SPEED,
)

_TEMPLATE = """\
/* A controller evolved for a MarxBot, as one header that needs but libm: C99, and C++ too.
 *
 *     static @NAME@_controller robot;
 *     @NAME@_reset(&robot);
 *     every 0.1 s: @NAME@_step(&robot, readings, wheels);
 *
 * readings, 37 floats: 24 infrared distances from the body's rim in m, ray i at 7.5 + 15 i degrees
 * counter-clockwise from the heading (@RANGE@ or more, INFINITY too: nothing seen); 8 camera
 * sectors of 45 degrees counter-clockwise from the heading, the fraction of each that the
 * opponent's lights fill, 0 to 1; 4 ground sensors, front left, front right, rear left and rear
 * right, darkness 0 to 1; contact 0 or 1.
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

static inline void @NAME@_perceive(@NAME@_controller *c, const float readings[37])
{
    float tired = c->effort_sum * @PER_FATIGUE@f;
    int i, k;

    for (i = 0; i < 8; i++) {
        float total = 0.0f;
        for (k = 0; k < 3; k++) {
            float near = fmaxf(fmaf(readings[3 * i + k], -@PER_RANGE@f, 1.0f), 0.0f);
            total = fmaf(near, fmaxf(near, @LEAST_FACTOR@f), total);
        }
        c->inputs[i] = total * @THIRD@f;
    }
    memcpy(c->inputs + 8, readings + 24, 8 * sizeof(float));
    c->inputs[16] = @NAME@_mean(readings + 24, 8);
    c->inputs[21] = @NAME@_mean(readings + 32, 4);
    for (i = 0; i < 4; i++) {
        float above = readings[32 + i] - @GROUND_MEAN_SHARE@f * c->inputs[21];
        float coded = fmaf(@GROUND_GAIN@f, above, @GROUND_OFFSET@f);
        c->inputs[17 + i] = fminf(fmaxf(coded, 0.0f), 1.0f);
    }
    c->inputs[22] = readings[36];
    c->inputs[23] = (float)c->tick * @PER_EPISODE@f;
    c->inputs[24] = tired * tired;
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
    float fresh = @SPEED@f * (1.0f - c->inputs[24]);
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


def c_header(
    genome,
    name,
    max_wheel_speed,
    motor_map='signed',
    episode_ticks=1000,
    infrared_response='squared',
    ground_coding='relative',
    provenance='unknown',
):
    """Return a header that defines ``NAME_controller``, ``NAME_reset`` and ``NAME_step``.

    It computes as `Controller` does, in the same order with the same roundings.

    Parameters
    ----------
    genome : array_like, shape (442,)
    name : str
        A C identifier, the prefix of everything the header defines.
    max_wheel_speed, motor_map, episode_ticks, infrared_response, ground_coding
        See `Controller`.
    provenance : str
        Where the genome comes from, for the comment at the header's top.

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
    weights = weights_of(check_genomes(np.atleast_2d(genome), 'genome'))[0]

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
        'SENSORS': str(SENSORS),
        'HIDDEN': str(HIDDEN),
        'OUTPUTS': str(OUTPUTS),
        'FATIGUE': str(FATIGUE_TICKS),
        'GROUND': str(GROUND_INPUTS),
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
