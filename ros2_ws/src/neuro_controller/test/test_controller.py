"""Known answers, by hand, for the network, the motors and fatigue (paper, A2, equations 1-5)."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from neuro_controller.core.controller import Controller
from neuro_controller.core.genome import GENES

GRID = 2.0**-16
PLAIN = {
    'max_wheel_speed': 10.0,
    'motor_map': 'printed',
    'infrared_response': 'linear',
    'ground_coding': 'raw',
}
"""The equations as printed, and neurons that show readings as they are."""

NOTHING = np.array([1.0] * 24 + [0.0] * 13, np.float32)
OUTPUTS = slice(10, 12)
LEAKS = slice(362, 372)


def logistic(x):
    return 1 / (1 + math.exp(-x))


def genome(**genes):
    """A genome of zeros but for the genes given by index: ``genome(g10=5)``."""
    values = np.zeros(GENES, np.float32)
    for name, value in genes.items():
        values[int(name[1:])] = value
    return values


def sensing(neuron, readings=NOTHING):
    """Readings that activate one of the sensory neurons 0..21 alone, and its activation."""
    readings = readings.copy()
    if neuron < 8:
        readings[3 * neuron : 3 * neuron + 3] = (0.02, 0.05, 0.08)
        return readings, 0.5
    reading = {**{k: k + 16 for k in range(8, 16)}, **{k: k + 15 for k in range(17, 21)}, 22: 36}
    readings[reading[neuron]] = 0.75
    return readings, 0.75


def stepped(genes, readings=NOTHING, ticks=1, **options):
    controller = Controller(genes, **{**PLAIN, **options})
    for _ in range(ticks):
        wheels = controller.step(readings)
    return controller, np.asarray(wheels, float)


def test_a_genome_of_zeros_drives_straight_at_half_speed():
    # every net input is 0, so every neuron is 1/2 and f(1/2) = 1
    controller, wheels = stepped(genome())
    assert controller.hidden == pytest.approx([0.5] * 10, abs=1e-6)
    assert controller.outputs == pytest.approx([0.5, 0.5], abs=1e-6)
    assert wheels == pytest.approx([5, 5], abs=1e-4)
    _, signed = stepped(genome(), motor_map='signed')
    assert signed == pytest.approx([0, 0], abs=1e-4)


def test_inputs_are_in_the_documented_order():
    readings = NOTHING.copy()
    readings[:24] = 0.1 - 0.1 * np.arange(24) / 24  # activation k/24 of ray k
    readings[24:32] = np.arange(8) / 8
    readings[32:36] = (0.1, 0.2, 0.3, 0.4)
    readings[36] = 1
    controller, _ = stepped(genome(), readings)
    inputs = np.asarray(controller.inputs, float)
    assert inputs.shape == (25,)
    assert inputs[:8] == pytest.approx((3 * np.arange(8) + 1) / 24, abs=1e-6)
    assert inputs[8:16] == pytest.approx(np.arange(8) / 8, abs=1e-6)
    assert inputs[16] == pytest.approx(28 / 64, abs=1e-6)
    assert inputs[17:22] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.25], abs=1e-6)
    assert inputs[22:] == pytest.approx([1, 0, 0], abs=1e-6)


def test_squared_infrared_is_the_mean_of_squares():
    readings = NOTHING.copy()
    readings[:24] = np.resize([0.02, 0.05, 0.08, 0.0, 0.1, 3.0], 24)
    controller, _ = stepped(genome(), readings, infrared_response='squared')
    # (0.8^2 + 0.5^2 + 0.2^2) / 3 = 0.31, and of what touches, at the range and beyond: 1/3
    expected = np.resize([0.31, 1 / 3], 8)
    assert controller.inputs[:8] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(
    ('darkness', 'neurons'),
    [
        # 0.5 + 10 (g - mean): differences of 0.01 become 0.1
        ([0.50, 0.51, 0.52, 0.55], [0.3, 0.4, 0.5, 0.8, 0.52]),
        ([0.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5, 0.0]),
        # kept in 0..1
        ([0.1, 0.2, 0.3, 0.4], [0.0, 0.0, 1.0, 1.0, 0.25]),
    ],
)
def test_relative_ground_tells_directions(darkness, neurons):
    readings = NOTHING.copy()
    readings[32:36] = darkness
    controller, _ = stepped(genome(), readings, ground_coding='relative')
    assert controller.inputs[17:22] == pytest.approx(neurons, abs=2e-6)


def test_the_defaults_are_the_authors_robot():
    readings = NOTHING.copy()
    readings[0], readings[32] = 0.05, 0.02
    controller = Controller(genome(g11=-5), 10.0)
    wheels = controller.step(readings)
    assert controller.inputs[0] == pytest.approx(0.25 / 3, abs=1e-6)
    assert controller.inputs[17] == pytest.approx(0.65, abs=1e-6)
    assert wheels[0] == pytest.approx(10 * (2 * logistic(-5) - 1), abs=1e-4)


def test_nothing_in_range_activates_no_infrared_neuron():
    for distance in (0.1, 0.1001, 5.0, np.inf):
        readings = NOTHING.copy()
        readings[:24] = distance
        controller, _ = stepped(genome(), readings)
        assert controller.inputs[:8] == pytest.approx(np.zeros(8), abs=1e-6)


@pytest.mark.parametrize('neuron', [*range(16), 17, 18, 19, 20, 22])
def test_each_sensor_reaches_each_neuron_through_its_own_gene(neuron):
    readings, activation = sensing(neuron)
    for target in range(10):
        controller, _ = stepped(genome(**{f'g{12 + 25 * target + neuron}': 3}), readings)
        expected = np.full(10, 0.5)
        expected[target] = logistic(3 * activation)
        assert controller.hidden == pytest.approx(expected, abs=1e-6)
        assert controller.outputs == pytest.approx([0.5, 0.5], abs=1e-6)
    for output in range(2):
        controller, _ = stepped(genome(**{f'g{372 + 25 * output + neuron}': -3}), readings)
        expected = np.full(2, 0.5)
        expected[output] = logistic(-3 * activation)
        assert controller.outputs == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize('target', range(10))
def test_each_bias_and_each_connection_between_neurons(target):
    first, _ = stepped(genome(**{f'g{target}': 2}))
    expected = np.full(10, 0.5)
    expected[target] = logistic(2)
    assert first.hidden == pytest.approx(expected, abs=1e-6)
    for source in range(10):
        # in the first tick the hidden neurons of the tick before are 0, in the second 1/2
        gene = {f'g{262 + 10 * target + source}': 2}
        assert stepped(genome(**gene))[0].hidden == pytest.approx([0.5] * 10, abs=1e-6)
        expected = np.full(10, 0.5)
        expected[target] = logistic(2 * 0.5)
        assert stepped(genome(**gene), ticks=2)[0].hidden == pytest.approx(expected, abs=1e-6)
    for output in range(2):
        # outputs are fed by the hidden neurons of this tick, not of the tick before
        controller, _ = stepped(genome(**{f'g{422 + 10 * output + target}': 2}))
        expected = np.full(2, 0.5)
        expected[output] = logistic(2 * 0.5)
        assert controller.outputs == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize('gene', [0, 1, -2.5, 5, -5])
@pytest.mark.parametrize('neuron', [0, 9])
def test_a_leaky_neuron_keeps_the_share_of_its_gene(neuron, gene):
    controller = Controller(genome(**{f'g{362 + neuron}': gene}), **PLAIN)
    kept, hidden = abs(gene) / 5, 0.0
    for _ in range(5):
        controller.step(NOTHING)
        hidden = kept * hidden + (1 - kept) * 0.5
        assert controller.hidden[neuron] == pytest.approx(hidden, abs=1e-6)
        assert np.delete(controller.hidden, neuron) == pytest.approx([0.5] * 9, abs=1e-6)


def expected_wheels(translation, rotation, signed, speed=10.0):
    """Equations 3-5."""
    drive = speed * (2 * rotation - 1 if signed else rotation)
    slowed = drive * (1 - 8 * (translation - 0.5) ** 2)
    return (slowed, drive) if translation < 0.5 else (drive, slowed)


@pytest.mark.parametrize('motor_map', ['printed', 'signed'])
@pytest.mark.parametrize('rotation', [-5, -1, 0, 2, 5])
@pytest.mark.parametrize('translation', [-5, -2, -0.1, 0, 0.1, 2, 5])
def test_motor_equations(translation, rotation, motor_map):
    controller, wheels = stepped(genome(g10=translation, g11=rotation), motor_map=motor_map)
    tm, rm = logistic(translation), logistic(rotation)
    assert controller.outputs == pytest.approx([tm, rm], abs=1e-6)
    assert wheels == pytest.approx(expected_wheels(tm, rm, motor_map == 'signed'), abs=5e-5)


def test_motor_equations_by_number():
    # tm = 0.2689, rm = 0.8808: f = 1 - 8 * 0.2311**2 = 0.5729
    _, wheels = stepped(genome(g10=-1, g11=2))
    assert wheels == pytest.approx([5.0462, 8.8080], abs=1e-3)
    _, wheels = stepped(genome(g10=1, g11=2), motor_map='signed', max_wheel_speed=8.5)
    assert wheels == pytest.approx([6.4736, 3.7088], abs=1e-3)
    # nearly turning on the spot: f(0.0067) = -0.9468
    _, wheels = stepped(genome(g10=-5, g11=5))
    assert wheels == pytest.approx([-9.4048, 9.9331], abs=1e-3)


def test_fatigue_is_the_square_of_the_mean_energy_of_200_ticks():
    controller = Controller(genome(g10=1, g11=3), **{**PLAIN, 'max_wheel_speed': 8.5})
    spent = []
    for tick in range(450):
        tiredness = (sum(spent[-200:]) / 200) ** 2
        wheels = np.asarray(controller.step(NOTHING), float)
        assert controller.inputs[24] == pytest.approx(tiredness, abs=2e-6)
        expected = expected_wheels(logistic(1), logistic(3), False, 8.5 * (1 - tiredness))
        assert wheels == pytest.approx(expected, abs=5e-5), tick
        spent.append(np.abs(wheels).mean() / 8.5)
    assert 0.2 < tiredness < 1


def test_fatigue_counts_each_wheel_in_either_direction():
    controller = Controller(genome(g10=-5, g11=5), **PLAIN)
    wheels = np.asarray(controller.step(NOTHING), float)
    assert wheels[0] < 0 < wheels[1]
    controller.step(NOTHING)
    tiredness = (np.abs(wheels).mean() / 10 / 200) ** 2
    assert controller.inputs[24] == pytest.approx(tiredness, abs=1e-9)


def test_the_clock_counts_the_ticks_passed():
    for ticks in (1000, 40):
        controller = Controller(genome(), max_wheel_speed=10.0, episode_ticks=ticks)
        for tick in range(30):
            controller.step(NOTHING)
            assert controller.inputs[23] == pytest.approx(tick / ticks, abs=1e-7)


def test_clock_and_fatigue_reach_the_network():
    genes = genome(**{f'g{12 + 23}': 4, f'g{12 + 25 + 24}': 4, 'g11': 5})
    controller, _ = stepped(genes, ticks=200)
    clock, fatigue = np.asarray(controller.inputs, float)[23:]
    assert clock == pytest.approx(0.199, abs=1e-6) and fatigue > 0.1
    expected = [logistic(4 * clock), logistic(4 * fatigue)]
    assert controller.hidden[:2] == pytest.approx(expected, abs=1e-6)


def test_reset_begins_anew():
    rng = np.random.default_rng(0)
    controller = Controller(rng.uniform(-5, 5, GENES).astype(np.float32), max_wheel_speed=10.0)
    readings = rng.uniform(0, 1, (250, 37)).astype(np.float32)
    runs = []
    for _ in range(2):
        controller.reset()
        runs.append([np.copy(controller.step(each)) for each in readings])
    assert (np.array(runs[0]) == np.array(runs[1])).all()


random_genes = hnp.arrays(np.float32, GENES, elements=st.floats(-5, 5, width=32))
random_readings = hnp.arrays(np.float32, 37, elements=st.floats(0, 1, width=32))


@given(random_genes, random_readings, st.sampled_from(['printed', 'signed']))
@settings(max_examples=100, deadline=None)
def test_commands_are_on_the_grid_and_within_the_maximum(genes, readings, motor_map):
    controller = Controller(genes, max_wheel_speed=8.5, motor_map=motor_map)
    for _ in range(20):
        wheels = np.asarray(controller.step(readings), float)
        assert (wheels / GRID == np.round(wheels / GRID)).all()
        assert np.abs(wheels).max() <= 8.5
        assert np.min(controller.hidden) >= 0 and np.max(controller.hidden) <= 1
        assert np.min(controller.inputs) >= 0 and np.max(controller.inputs) <= 1
        if motor_map == 'printed':
            assert wheels.sum() >= -GRID


@given(random_genes, random_readings)
@settings(max_examples=50, deadline=None)
def test_a_mirrored_output_bias_swaps_the_wheels(genes, readings):
    # no weights reach tm: its bias alone turns the robot, and -bias to the other side
    genes[372:397] = genes[422:432] = 0
    mirrored = genes.copy()
    mirrored[10] = -genes[10]
    _, wheels = stepped(genes, readings)
    _, swapped = stepped(mirrored, readings)
    assert wheels == pytest.approx(swapped[::-1], abs=5e-5)
