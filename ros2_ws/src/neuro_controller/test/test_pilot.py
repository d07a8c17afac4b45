"""From readings to commands: limits, repeated and new readings, wheel geometry."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from neuro_controller.core.controller import Controller
from neuro_controller.core.genome import random_genomes
from neuro_controller.core.limits import Limits
from neuro_controller.core.pilot import STOP, Pilot

GENOME = random_genomes(1, np.random.default_rng(5))[0]
READINGS = np.random.default_rng(6).random((40, 37)).astype(np.float32)


def pilot(**changes):
    return Pilot(Controller(GENOME, 10.0), **changes)


def test_without_limits_a_command_is_the_networks_bit_for_bit():
    one, controller = pilot(), Controller(GENOME, 10.0)
    for readings in READINGS:
        one.step(readings)
        left, right = map(float, controller.step(readings))
        assert one.command == (0.027 * (left + right) / 2, 0.027 * (right - left) / 0.1265)


def test_the_wheels_geometry_scales_the_command():
    one, other = pilot(), pilot(wheel_radius=0.054, wheel_separation=0.253)
    one.step(READINGS[0])
    other.step(READINGS[0])
    assert other.command == pytest.approx((2 * one.command[0], one.command[1]))


def test_readings_that_come_twice_are_answered_alike_and_count_once():
    one, other = pilot(), pilot()
    for tick, readings in enumerate(READINGS):
        one.answer((tick, 0), readings)
        first = one.command
        one.answer((tick, 0), readings)
        other.answer((tick, 0), readings)
        assert one.command == first == other.command


@pytest.mark.parametrize('stamp', [(0, 0), (38, 0), (39, 0)])
def test_time_that_does_not_advance_begins_an_episode(stamp):
    one, fresh = pilot(), pilot()
    for tick, readings in enumerate(READINGS):
        one.answer((tick, 0), readings)
    one.answer(stamp, READINGS[0])
    fresh.answer(stamp, READINGS[0])
    assert one.command == fresh.command


def test_a_stop_keeps_the_network():
    one, other = pilot(), pilot()
    for readings in READINGS[:10]:
        one.step(readings)
        other.step(readings)
    one.stop()
    assert one.command == STOP
    one.step(READINGS[10])
    other.step(READINGS[10])
    assert one.command == other.command


def test_a_speed_limit_keeps_the_curve():
    limits = Limits(linear_speed=0.1, angular_speed=1.0)
    assert limits.apply((0.2, 0.5), STOP, 0.1) == pytest.approx((0.1, 0.25))
    assert limits.apply((0.2, -4.0), STOP, 0.1) == pytest.approx((0.05, -1.0))
    assert limits.apply((-0.4, 0.0), STOP, 0.1) == pytest.approx((-0.1, 0.0))
    assert limits.apply((0.05, 0.9), STOP, 0.1) == (0.05, 0.9)


def test_an_acceleration_limit_approaches_the_command():
    limits = Limits(linear_acceleration=0.5, angular_acceleration=2.0)
    command = STOP
    for expected in ((0.05, -0.2), (0.1, -0.4), (0.12, -0.5), (0.12, -0.5)):
        command = limits.apply((0.12, -0.5), command, 0.1)
        assert command == pytest.approx(expected)
    assert limits.apply(STOP, command, 0.1) == pytest.approx((0.07, -0.3))


@given(st.tuples(*[st.floats(-9, 9)] * 2), st.tuples(*[st.floats(-0.3, 0.3)] * 2))
def test_no_command_exceeds_its_limits(wanted, previous):
    limits = Limits(0.3, 0.3, 1.0, 1.0)
    for new, old in zip(limits.apply(wanted, previous, 0.1), previous, strict=True):
        assert abs(new) <= 0.3 + 1e-12
        assert abs(new - old) <= 0.1 + 1e-12


@pytest.mark.parametrize('value', [0.0, -1.0, math.nan])
def test_a_limit_that_is_not_positive_is_refused(value):
    with pytest.raises(ValueError, match=r'^angular_speed is .*, expected a number above 0'):
        Limits(angular_speed=value)
