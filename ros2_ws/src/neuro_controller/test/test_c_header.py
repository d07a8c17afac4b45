"""The C header, compiled, against the controller."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from neuro_controller.core.c_header import c_header
from neuro_controller.core.controller import Controller
from neuro_controller.core.drive import body_speeds
from neuro_controller.core.genome import random_genomes

STRICT = ['-Wall', '-Wextra', '-Wconversion', '-Werror', '-pedantic']
MAIN = """
#include <stdio.h>
#include "robot.h"

int main(void)
{
    robot_controller robot;
    float readings[37], wheels[2];
    robot_reset(&robot);
    while (fread(readings, sizeof(float), 37, stdin) == 37) {
        double body[2];
        robot_step(&robot, readings, wheels);
        body[0] = robot_linear(wheels);
        body[1] = robot_angular(wheels);
        fwrite(robot.outputs, sizeof(float), 2, stdout);
        fwrite(robot.hidden, sizeof(float), 10, stdout);
        fwrite(robot.inputs, sizeof(float), 25, stdout);
        fwrite(wheels, sizeof(float), 2, stdout);
        fwrite(body, sizeof(double), 2, stdout);
    }
    return 0;
}
"""
RECORD = np.dtype(
    [
        ('outputs', 'f4', 2),
        ('hidden', 'f4', 10),
        ('inputs', 'f4', 25),
        ('wheels', 'f4', 2),
        ('body', 'f8', 2),
    ]
)


def some_readings(rng, ticks):
    """Readings that change as those of a robot do: some seen, some not, +inf among them."""
    readings = rng.random((ticks, 37)).astype(np.float32)
    readings[:, :24] *= 0.3
    readings[:, :24][rng.random((ticks, 24)) < 0.3] = np.inf
    readings[::2, 32:36] = readings[::2, 32:33] + 0.03 * rng.random((ticks // 2, 4))
    readings[:, 36] = rng.random(ticks) < 0.2
    return readings


@pytest.mark.parametrize(
    'choices',
    [
        {},
        {'motor_map': 'printed', 'infrared_response': 'linear', 'ground_coding': 'raw'},
        {'infrared_response': 'linear'},
    ],
    ids=['default', 'plain', 'linear'],
)
@pytest.mark.parametrize('seed', range(3))
def test_the_header_is_strict_c99_and_agrees_bit_for_bit(tmp_path, seed, choices):
    rng = np.random.default_rng(seed)
    genome = random_genomes(1, rng)[0]
    settings = {'max_wheel_speed': 8.5, 'episode_ticks': 700, **choices}
    (tmp_path / 'robot.h').write_text(c_header(genome, 'robot', **settings))
    (tmp_path / 'main.c').write_text(MAIN)
    flags = ['-std=c99', *STRICT, '-O1']
    program = tmp_path / 'main'
    subprocess.run(['cc', *flags, tmp_path / 'main.c', '-lm', '-o', program], check=True)
    readings = some_readings(rng, 1000)
    output = subprocess.run(program, input=readings.tobytes(), capture_output=True, check=True)
    steps = np.frombuffer(output.stdout, RECORD)
    assert len(steps) == 1000

    controller = Controller(genome, **settings)
    for step, reading in zip(steps, readings, strict=True):
        wheels = controller.step(reading)
        assert (step['inputs'] == controller.inputs).all()
        assert (step['hidden'] == controller.hidden).all()
        assert (step['outputs'] == controller.outputs).all()
        assert (step['wheels'] == wheels).all()
        assert step['body'].tolist() == list(body_speeds(wheels))


def test_cpp_and_c_compute_the_same(tmp_path):
    genome = random_genomes(1, np.random.default_rng(5))[0]
    (tmp_path / 'robot.h').write_text(c_header(genome, 'robot', 10.0))
    readings = some_readings(np.random.default_rng(6), 300).tobytes()
    outputs = []
    for compiler, standard, name in (('cc', 'c99', 'main.c'), ('c++', 'c++17', 'main.cpp')):
        (tmp_path / name).write_text(MAIN)
        program = tmp_path / standard
        command = [compiler, f'-std={standard}', *STRICT, tmp_path / name, '-lm', '-o', program]
        subprocess.run(command, check=True)
        run = subprocess.run(program, input=readings, capture_output=True, check=True)
        outputs.append(run.stdout)
    assert outputs[0] == outputs[1] and len(outputs[0]) == 300 * RECORD.itemsize


ARDUINO = """
#include <math.h>
#include <stdio.h>
#define HIGH 1
#define LOW 0
static unsigned long now_ms;
static unsigned long millis(void) { return now_ms; }
static int analogRead(int) { return 2000; }
static int digitalRead(int) { return LOW; }
static void digitalWrite(int, int) {}
static void analogWrite(int motor, int duty) { printf("%d %d\\n", motor, duty); }
"""


def test_the_example_sketch_drives_on_the_host(tmp_path):
    """Compiled as an Arduino would: C++, its core included before the sketch, strictly."""
    sketch = Path(__file__).parent.parent / 'examples' / 'predator_robot' / 'predator_robot.ino'
    genome = random_genomes(1, np.random.default_rng(5))[0]
    (tmp_path / 'predator.h').write_text(c_header(genome, 'predator', 10.0))
    body = '\nint main() { setup(); for (; now_ms < 1000; now_ms++) loop(); }\n'
    (tmp_path / 'sketch.cpp').write_text(ARDUINO + sketch.read_text() + body)
    program = tmp_path / 'sketch'
    command = ['c++', '-std=c++17', *STRICT, tmp_path / 'sketch.cpp', '-lm', '-o', program]
    subprocess.run(command, check=True)
    output = subprocess.run(program, capture_output=True, check=True, text=True).stdout

    controller, expected = Controller(genome, 10.0), []
    readings = np.full(37, np.inf, np.float32)
    readings[24:], readings[32:36] = 0, np.float32(2000) / np.float32(4095)
    for _ in range(10):
        for motor, speed in enumerate(controller.step(readings)):
            expected.append(f'{motor} {int(np.float32(25.5) * abs(speed))}')
    assert output.split('\n')[:-1] == expected


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        ((np.zeros(442), 'Bad Name', 10.0), 'name is'),
        ((np.zeros(441), 'robot', 10.0), 'genome has 441 genes'),
        ((np.full(442, 6.0), 'robot', 10.0), 'genome has the value 6.0'),
        ((np.zeros(442), 'robot', 0.0), 'max_wheel_speed is 0.0'),
        ((np.zeros(442), 'robot', 10.0, 'odd'), 'motor_map is'),
        ((np.zeros(442), 'robot', 10.0, 'signed', 1000, 'odd'), 'infrared_response is'),
        ((np.zeros(442), 'robot', 10.0, 'signed', 1000, 'linear', 'odd'), 'ground_coding is'),
    ],
)
def test_bad_input_is_refused(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        c_header(*arguments)
