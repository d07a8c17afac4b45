"""A robot with a compass and a network of 13 hidden neurons: all follows from the layout."""

import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from analysis_runs import make_run
from ros_processes import ROOT

from coevo_manager.analysis.report.packing import layer_places
from coevo_manager.analysis.runs import AnalysisError, read_run
from coevo_manager.core.episodes import Environment, evaluate_matrix, trace_pair, trace_pairs
from coevo_manager.core.evolution import load_configuration
from coevo_manager.core.evolution.run_folder import RunFolderError, read_configuration
from coevo_manager.export import main as export
from marxbot_sensors import CAMERA, GROUND, MARXBOT, Robot, Sensor
from marxbot_sim.core.layout import COSINE, SINE
from neuro_controller.core.c_header import c_header
from neuro_controller.core.champions import select_champion
from neuro_controller.core.controller import Controller
from neuro_controller.core.genome import GENES, Layout, check_genomes, random_genomes
from neuro_controller.sensors import Sensors
from simd_lanes import kernel_part, load, store


@kernel_part
def sense_compass(bodies, arena, first, readings):
    store(readings, first, load(bodies, COSINE))
    store(readings, first + 1, load(bodies, SINE))


COMPASS = Sensor(
    name='compass',
    topic='compass',
    count=2,
    low=-1.0,
    high=1.0,
    unit='',
    reads='cosine and sine of the heading',
    neurons=2,
    neurons_are='2 of the compass',
    sense=sense_compass,
)
ROBOT = Robot((*MARXBOT.sensors, COMPASS))
LAYOUT = Layout(13, ROBOT)


class CompassEnvironment(Environment):
    robot = ROBOT


ENVIRONMENT = CompassEnvironment(hidden=13, episode_ticks=120)


def genomes(count=3, seed=0):
    return random_genomes(count, np.random.default_rng(seed), LAYOUT)


def test_sizes_follow_from_the_description():
    assert (ROBOT.readings, LAYOUT.inputs) == (37 + 2, 25 + 2)
    assert LAYOUT.genes == 13 + 2 + 27 * 13 + 13 * 13 + 13 + 27 * 2 + 13 * 2
    assert (LAYOUT.clock, LAYOUT.fatigue) == (25, 26)
    assert LAYOUT.inputs_are.endswith('contact, 2 of the compass, clock, fatigue')
    assert Layout.of(LAYOUT.genes, ROBOT) == LAYOUT


def logistic(x):
    return 1 / (1 + np.exp(-x))


def test_batch_traces_and_single_steps_agree_and_the_compass_is_wired():
    predators, prey = genomes(seed=1), genomes(seed=2)
    ticks = evaluate_matrix(predators, prey, ENVIRONMENT)
    rows, columns = np.indices(ticks.shape).reshape(2, -1)
    batch = list(trace_pairs(predators, prey, rows, columns, ENVIRONMENT))
    assert [trace.ticks for trace in batch] == ticks.ravel().tolist()
    single = trace_pair(predators[0], prey[1], ENVIRONMENT)
    for name in ('poses', 'wheels', 'readings', 'inputs', 'hidden', 'outputs'):
        assert np.array_equal(getattr(single, name), getattr(batch[1], name)), name

    headings = single.poses[:-1, :, 2]
    compass = single.readings[..., 37:]
    assert np.allclose(compass, np.stack([np.cos(headings), np.sin(headings)], -1), atol=1e-6)
    assert np.allclose(single.inputs[..., 23:25], (compass + 1) / 2, atol=1e-6)
    assert np.allclose(single.inputs[:, 0, 25], np.arange(single.ticks) / 120)

    genome = predators[0].astype(float)
    parts = np.split(genome, np.cumsum([13, 2, 27 * 13, 13 * 13, 13, 27 * 2]))
    hidden_bias, output_bias, sense, recall, leak, direct, out = parts
    leak, h = np.abs(leak) / 5, np.zeros(13)
    for inputs, hidden, outputs in zip(
        single.inputs[:, 0], single.hidden[:, 0], single.outputs[:, 0], strict=True
    ):
        net = hidden_bias + sense.reshape(13, 27) @ inputs + recall.reshape(13, 13) @ h
        assert np.allclose(leak * h + (1 - leak) * logistic(net), hidden, atol=1e-5)
        h = hidden.astype(float)
        net = output_bias + direct.reshape(2, 27) @ inputs + out.reshape(2, 13) @ h
        assert np.allclose(logistic(net), outputs, atol=1e-5)


MAIN = """
#include <stdio.h>
#include "robot.h"

int main(void)
{
    static robot_controller robot;
    float readings[39], wheels[2];
    robot_reset(&robot);
    while (fread(readings, sizeof(float), 39, stdin) == 39) {
        robot_step(&robot, readings, wheels);
        fwrite(robot.inputs, sizeof(float), 27, stdout);
        fwrite(wheels, sizeof(float), 2, stdout);
    }
    return 0;
}
"""


def test_the_c_header_follows(tmp_path):
    genome = genomes(1)[0]
    text = c_header(genome, 'robot', 10.0, robot=ROBOT)
    assert '37: compass, 2 numbers, -1 to 1: cosine and sine of the heading' in text
    (tmp_path / 'robot.h').write_text(text)
    (tmp_path / 'main.c').write_text(MAIN)
    program = tmp_path / 'main'
    flags = ['-std=c99', '-Wall', '-Wextra', '-Wconversion', '-pedantic', '-Werror']
    command = ['cc', *flags, tmp_path / 'main.c', '-lm', '-o', program]
    subprocess.run(command, check=True)
    readings = np.random.default_rng(0).uniform(-1, 1, (50, 39)).astype(np.float32)
    readings[:, :37] = np.abs(readings[:, :37])
    output = subprocess.run(program, input=readings.tobytes(), capture_output=True, check=True)
    controller = Controller(genome, 10.0, robot=ROBOT)
    expected = [(controller.step(row), controller.inputs)[::-1] for row in readings]
    found = np.frombuffer(output.stdout, np.float32).reshape(50, 29)
    assert np.array_equal(found, [np.concatenate(step) for step in expected])


def test_the_player_has_bars_for_every_neuron():
    layers = layer_places(LAYOUT)
    assert ('compass', 24 + 23, 2) in layers['bars'][1]
    bars = [group for row in layers['bars'] for group in row]
    covered = [place for _, first, count in bars for place in range(first, first + count)]
    assert covered == list(range(24, 24 + 27 + 13 + 2)) and layers['channels'] == 66


def test_a_controller_takes_the_message_of_a_further_sensor():
    sensors = Sensors(0.5, 0.085, 0.05, ROBOT)
    header = SimpleNamespace(stamp=SimpleNamespace(sec=1, nanosec=0))
    sensors.take('compass', SimpleNamespace(header=header, values=[0.5, -3.0]), 1.0, 0)
    assert sensors.readings[37:].tolist() == [0.5, -1.0]
    with pytest.raises(ValueError, match='compass has 1 values, expected 2'):
        sensors.take('compass', SimpleNamespace(header=header, values=[0.5]), 1.0, 0)


def test_other_layouts_are_refused_in_a_sentence():
    ours, theirs = genomes(), np.zeros((3, GENES), np.float32)
    with pytest.raises(ValueError, match=f'predators has {LAYOUT.genes} genes, expected 442'):
        evaluate_matrix(ours, theirs)
    with pytest.raises(ValueError, match=f'prey has 442 genes, expected {LAYOUT.genes}'):
        evaluate_matrix(ours, theirs, ENVIRONMENT)
    with pytest.raises(ValueError, match=f'genome has {LAYOUT.genes} genes'):
        Controller(ours[0], 10.0)
    with pytest.raises(ValueError, match='prey has 442 genes, expected'):
        check_genomes(theirs, 'prey', LAYOUT)
    with pytest.raises(ValueError, match='hidden is 0, expected 1 to 100'):
        Layout(0)


@pytest.mark.parametrize(
    ('sensors', 'clue'),
    [
        ((*MARXBOT.sensors, GROUND), 'neurons of sensor ground is 5, expected its count, 4'),
        ((*MARXBOT.sensors, COMPASS, COMPASS), 'compass is the name of two sensors'),
        ((COMPASS, *MARXBOT.sensors), 'expected infrared, camera, ground and touch before others'),
    ],
)
def test_a_robot_that_makes_no_sense_is_refused(sensors, clue):
    with pytest.raises(ValueError, match=clue):
        Robot(sensors)


def test_another_number_of_hidden_neurons_from_evolution_to_the_header(tmp_path, capsys):
    folder = make_run(tmp_path / 'run', hidden=13, phases=2)
    run = read_run(folder)
    snapshot = run.snapshot(20)
    assert snapshot.predators.shape == (8, Layout(13).genes)
    champion = select_champion(str(folder), 'prey')
    trace = trace_pair(champion.genome, champion.genome, run.environment)
    assert trace.hidden.shape[2] == 13
    header = tmp_path / 'prey.h'
    assert export([str(folder), '--species', 'prey', '--header', str(header)]) == 0
    assert 'float hidden[13]' in header.read_text()

    record = folder / 'run.json'
    record.write_text(record.read_text().replace('"hidden": 13', '"hidden": 10'))
    with pytest.raises((AnalysisError, RunFolderError, ValueError), match='another config'):
        read_run(folder)


def test_a_champion_whose_run_tells_of_another_network_is_refused(tmp_path):
    folder = make_run(tmp_path / 'run', phases=1)
    path = folder / 'snapshots' / 'gen_000010.npz'
    with np.load(path, allow_pickle=False) as file:
        arrays = dict(file)
    arrays['run'] = np.array(str(arrays['run']).replace('"hidden": 10', '"hidden": 20'))
    np.savez(path, **arrays)
    with pytest.raises(ValueError, match='has 442 genes, expected 1032 as a network of 25 sens'):
        select_champion(str(path), 'prey')


def test_a_run_from_before_the_number_could_be_chosen_goes_on(tmp_path):
    folder = make_run(tmp_path / 'run', phases=1)
    assert read_configuration(folder).hidden == 10
    record = folder / 'run.json'
    record.write_text(record.read_text().replace('    "hidden": 10,\n', ''))
    assert read_configuration(folder) == load_configuration(
        {**read_configuration(folder).as_dict(), 'hidden': 10}
    )
    read_run(folder)


def test_messages_and_readme_say_what_the_description_says():
    def read(path):
        text = (ROOT / 'ros2_ws' / 'src' / path).read_text()
        return ' '.join(text.replace('\n# ', ' ').split())

    inputs = Layout().inputs_are
    assert f'25 of a MarxBot: {inputs}.' in read('marxbot_msgs/msg/Neurons.msg')
    assert f'float32[{CAMERA.count}] sectors' in read('marxbot_msgs/msg/Camera.msg')
    assert f'float32[{GROUND.count}] darkness' in read('marxbot_msgs/msg/Ground.msg')
    table = read('marxbot_sensors/README.md')
    for sensor in MARXBOT.sensors:
        extent = f'{sensor.low:g} to {sensor.high:g} {sensor.unit}'.strip()
        assert (
            f'| {sensor.name} | `{sensor.topic}` | {sensor.count} | {extent} | '
            f'{sensor.neurons_are} |' in table
        )
    assert f'These are {MARXBOT.readings} readings and {MARXBOT.neurons} neurons.' in table
