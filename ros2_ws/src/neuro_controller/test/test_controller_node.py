"""The controller and genome server nodes as processes: what they answer, refuse and survive."""

import json
import math
import signal
from array import array

import numpy as np
import pytest
from geometry_msgs.msg import TwistStamped, WrenchStamped
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from marxbot_msgs.msg import Camera, Ground, Neurons
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from neuro_controller.core.champions import SHIPPED
from neuro_controller.core.controller import Controller
from neuro_controller.core.drive import body_speeds
from neuro_controller.core.genome import GENES, random_genomes
from neuro_controller.core.snapshot import read_snapshot

GENOMES = random_genomes(3, np.random.default_rng(3))
QUICK = 'trigger:=sensors', 'sensor_timeout:=1.0', 'body_radius:=0.0'


def controller(namespace, *parameters):
    """Command line of a controller that answers its sensors."""
    settings = [part for parameter in (*QUICK, *parameters) for part in ('-p', parameter)]
    return ['neuro_controller', 'controller', '--ros-args', '-r', f'__ns:={namespace}', *settings]


class Robot:
    """The robot that a controller drives: sends readings, hears commands, changes parameters."""

    def __init__(self, client, namespace, process):
        self.client, self.namespace, self.process = client, namespace, process
        self.tick = 0

    def connect(self):
        """Find the topics, which exist once the controller is configured."""
        client, topic = self.client, self.namespace
        self.commands = client.listen(TwistStamped, f'{topic}/cmd_vel')
        self.neurons = client.listen(Neurons, f'{topic}/neurons')
        self.publishers = {
            name: client.publisher(kind, f'{topic}/{name}', qos_profile_sensor_data)
            for name, kind in (
                ('proximity', LaserScan),
                ('camera', Camera),
                ('ground', Ground),
                ('traction', WrenchStamped),
            )
        }

    def call(self, service_type, name, **fields):
        return self.client.call(service_type, f'{self.namespace}/controller/{name}', **fields)

    def change(self, transition):
        return self.call(ChangeState, 'change_state', transition=Transition(id=transition)).success

    def set(self, **values):
        parameters = [
            Parameter(
                name.replace('__', '.'),
                Parameter.Type.DOUBLE_ARRAY if name == 'genome' else None,
                value,
            ).to_parameter_msg()
            for name, value in values.items()
        ]
        return self.call(
            SetParametersAtomically, 'set_parameters_atomically', parameters=parameters
        ).result

    def messages(self, readings):
        scan = LaserScan(ranges=array('f', readings[:24].tobytes()))
        camera, ground = Camera(sectors=readings[24:32]), Ground(darkness=readings[32:36])
        traction = WrenchStamped()
        traction.wrench.force.y = -float(readings[36])
        return {'proximity': scan, 'camera': camera, 'ground': ground, 'traction': traction}

    def send(self, messages):
        for name, message in messages.items():
            message.header.stamp.sec = self.tick
            self.publishers[name].publish(message)

    def ask(self, readings):
        """Send readings of the next tick until a command answers them, and return it."""
        self.tick += 1

        def answer():
            found = [c for c in self.commands if c.header.stamp.sec == self.tick]
            return found[-1].twist if found else None

        messages = self.messages(readings)
        for _ in range(20):
            self.send(messages)
            try:
                self.client.until(answer, 'an answer', 2.0)
            except AssertionError:
                continue
            twist = answer()
            return twist.linear.x, twist.angular.z
        raise AssertionError(f'no answer at tick {self.tick}')


@pytest.fixture(scope='module')
def robot(starter, client):
    """A controller driven by its sensors, active with genome 0."""
    process = starter(controller('/a', 'max_wheel_speed:=8.5'))
    robot = Robot(client, '/a', process)
    assert not robot.change(Transition.TRANSITION_CONFIGURE)  # no genome yet
    process.wait_for_output('cannot be configured: genome is not set')
    assert robot.set(genome=GENOMES[0].tolist()).successful
    assert robot.change(Transition.TRANSITION_CONFIGURE)
    robot.connect()
    assert robot.change(Transition.TRANSITION_ACTIVATE)
    return robot


def readings_of(rng):
    readings = rng.random(37).astype(np.float32)
    readings[:24] = np.where(rng.random(24) < 0.5, np.inf, readings[:24] * 0.1)
    readings[36] = rng.random() < 0.5
    return readings


def check_drives(robot, genome, ticks=15, reset=True, max_wheel_speed=8.5, **settings):
    """The robot answers as a fresh controller of that genome does, bit for bit."""
    if reset:
        assert robot.call(Trigger, 'reset').success
    core = Controller(genome, max_wheel_speed, **settings)
    rng = np.random.default_rng(robot.tick)
    for _ in range(ticks):
        readings = readings_of(rng)
        readings[36] *= 2  # newtons, above the threshold
        answer = robot.ask(readings)
        readings[36] /= 2
        assert answer == body_speeds(core.step(readings))


def test_it_drives_as_the_core_bit_for_bit(robot):
    check_drives(robot, GENOMES[0])


def test_it_publishes_its_neurons(robot, client):
    assert robot.call(Trigger, 'reset').success
    controller, readings = Controller(GENOMES[0], 8.5), np.full(37, 0.05, np.float32)
    robot.neurons.clear()
    robot.ask(readings)
    controller.step(np.append(readings[:36], np.float32(0)))  # 0.05 N is no contact
    client.until(lambda: robot.neurons, 'neurons')
    expected = np.concatenate([controller.inputs, controller.hidden, controller.outputs])
    message = robot.neurons[0]
    neurons = np.concatenate([message.inputs, message.hidden, message.outputs])
    assert neurons.tobytes() == expected.tobytes()
    assert message.header.stamp == robot.commands[-1].header.stamp


@pytest.mark.parametrize(
    ('values', 'sentence'),
    [
        ({'genome': [0.0] * 441}, 'genome has 441 genes, expected 442'),
        ({'genome': []}, 'genome'),
        ({'genome': [math.nan] + [0.0] * 441}, 'gene 0'),
        ({'genome': [0.0] * 441 + [5.5]}, 'gene 441'),
        ({'genome': GENOMES[1].tolist(), 'motor_map': 'sideways'}, "motor_map is 'sideways'"),
        ({'genome': GENOMES[1].tolist(), 'max_wheel_speed': -1.0}, 'max_wheel_speed is -1.0'),
        ({'limits__linear_speed': 0.0}, 'linear_speed is 0.0'),
    ],
)
def test_what_is_refused_leaves_the_old_network_running(robot, values, sentence):
    result = robot.set(**values)
    assert not result.successful
    assert sentence in result.reason
    check_drives(robot, GENOMES[0], ticks=3)


def test_a_genome_set_live_takes_over_afresh(robot):
    assert robot.set(genome=GENOMES[1].tolist()).successful
    check_drives(robot, GENOMES[1], reset=False)
    assert robot.set(genome=GENOMES[0].tolist()).successful
    check_drives(robot, GENOMES[0], reset=False)


def test_limits_hold_the_robot_back_and_can_be_lifted(robot):
    assert robot.set(limits__linear_speed=0.01, limits__angular_speed=0.1).successful
    rng = np.random.default_rng(1)
    for _ in range(5):
        linear, angular = robot.ask(readings_of(rng))
        assert abs(linear) <= 0.01 + 1e-12 and abs(angular) <= 0.1 + 1e-12
    assert robot.set(limits__linear_speed=math.inf, limits__angular_speed=math.inf).successful
    check_drives(robot, GENOMES[0], ticks=3)


def test_time_that_goes_back_is_a_new_episode(robot):
    check_drives(robot, GENOMES[0])
    robot.tick = 0
    robot.commands.clear()
    check_drives(robot, GENOMES[0], reset=False)


def wait_for_stop(robot):
    robot.client.until(
        lambda: (
            robot.commands
            and (robot.commands[-1].twist.linear.x, robot.commands[-1].twist.angular.z) == (0, 0)
        ),
        'the stop',
    )


def test_a_silent_sensor_stops_the_robot_and_is_named(robot, client):
    check_drives(robot, GENOMES[0], ticks=2)
    robot.tick += 1
    messages = robot.messages(readings_of(np.random.default_rng(0)))
    del messages['camera']
    before = len(robot.process.stderr_text)
    wait_for = 'robot stopped, no camera'

    def stopped():
        robot.send(messages)
        return wait_for in robot.process.stderr_text[before:]

    client.until(stopped, wait_for)
    wait_for_stop(robot)
    check_drives(robot, GENOMES[0], ticks=3)  # all sensors are back


def test_malformed_messages_are_refused_by_name_and_stop_the_robot(robot, client):
    good = robot.messages(np.full(37, 0.5, np.float32))
    short = LaserScan(ranges=array('f', [0.1] * 23))
    nan = Camera(sectors=np.full(8, np.nan, np.float32))
    for name, message, sentence in (
        ('proximity', short, 'proximity has 23 values, expected 24'),
        ('camera', nan, 'camera has a value that is not a number'),
    ):
        check_drives(robot, GENOMES[0], ticks=2)
        robot.commands.clear()
        robot.tick += 1

        def stopped(name=name, message=message, sentence=sentence):
            robot.send({**good, name: message})
            return f'(last refused: {sentence})' in robot.process.stderr_text or robot.commands

        client.until(stopped, sentence)
        wait_for_stop(robot)
        assert {c.header.stamp.sec for c in robot.commands}.isdisjoint({robot.tick})


floats = st.floats(width=32)
arrays = st.lists(floats, max_size=40)


@given(ranges=arrays, sectors=st.lists(floats, min_size=8, max_size=8), force=st.floats())
@settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_no_message_breaks_it(robot, ranges, sectors, force):
    robot.tick += 1
    messages = robot.messages(np.zeros(37, np.float32))
    messages['proximity'].ranges = array('f', ranges)
    messages['camera'].sectors = np.array(sectors, np.float32)
    messages['traction'].wrench.force.x = force
    robot.send(messages)


def test_it_lives_on_after_all_that(robot):
    assert robot.process.poll() is None
    for command in robot.commands:
        assert math.isfinite(command.twist.linear.x) and math.isfinite(command.twist.angular.z)
    check_drives(robot, GENOMES[0])


def test_deactivation_stops_the_robot_and_activation_starts_afresh(robot):
    check_drives(robot, GENOMES[0], ticks=2)
    assert robot.change(Transition.TRANSITION_DEACTIVATE)
    wait_for_stop(robot)
    assert not robot.call(Trigger, 'reset').success  # not in this state
    count = len(robot.commands)
    robot.tick += 1
    robot.send(robot.messages(np.zeros(37, np.float32)))
    assert robot.call(GetState, 'get_state').current_state.id == State.PRIMARY_STATE_INACTIVE
    assert len(robot.commands) == count
    assert robot.change(Transition.TRANSITION_CLEANUP)
    assert not robot.change(Transition.TRANSITION_ACTIVATE)  # not configured
    assert robot.change(Transition.TRANSITION_CONFIGURE)
    robot.connect()
    assert robot.change(Transition.TRANSITION_ACTIVATE)
    check_drives(robot, GENOMES[0], reset=False)


def test_the_genome_server_feeds_a_controller(starter, client, tmp_path):
    run = tmp_path / 'run'
    (run / 'snapshots').mkdir(parents=True)
    fitness = np.array([[0.2, 0.9], [0.1, 0.3]], np.float32)
    configuration = {
        'environment': 'obstacle',
        'predator_speed': None,
        'prey_speed': 6.0,
        'motor_map': 'printed',
        'episode_ticks': 300,
    }
    np.savez(
        run / 'snapshots' / 'gen_000500.npz',
        predators=GENOMES[:2],
        prey=GENOMES[1:],
        fitness=fitness,
        generation=500,
        run=json.dumps({'configuration': configuration}),
    )
    starter(['neuro_controller', 'genome_server', '--ros-args', '-p', f'run:={run}'])
    names = ['predator', 'prey', 'gen_000500.prey', 'open.predator', 'predator.max_wheel_speed']
    values = client.call(GetParameters, '/genome_server/get_parameters', names=names).values
    assert values[0].double_array_value.tolist() == GENOMES[0].tolist()
    assert values[1].double_array_value == values[2].double_array_value
    assert values[1].double_array_value.tolist() == GENOMES[1].tolist()
    shipped = read_snapshot(SHIPPED / 'open.npz').best('predator', 1)[0]
    assert values[3].double_array_value.tolist() == shipped.tolist()
    assert values[4].double_value == 10.0  # the paper's, with the obstacle

    process = starter(
        controller(
            '/b',
            *('genome_server:=/genome_server', 'champion:=prey', 'autostart:=true'),
            'episode_ticks:=500',
        )
    )
    other = Robot(client, '/b', process)
    process.wait_for_output('active', 40)
    assert 'episode_ticks is 500, in place of 300 with which prey' in process.stderr_text
    names = ['max_wheel_speed', 'motor_map', 'ground_coding', 'episode_ticks']
    values = other.call(GetParameters, 'get_parameters', names=names).values
    taken = [parameter_value_to_python(value) for value in values]
    assert taken == [6.0, 'printed', 'raw', 500]
    other.connect()
    evolved = dict(zip(names, taken, strict=True), infrared_response='linear')
    check_drives(other, GENOMES[1], ticks=3, **evolved)
    process.send_signal(signal.SIGTERM)  # while active: it stops the robot before it ends
    wait_for_stop(other)
    assert process.wait() == 0


@pytest.mark.parametrize(
    ('executable', 'parameters', 'sentence'),
    [
        ('controller', ['autostart:=true'], 'genome is not set'),
        ('controller', ['genome:=[1.0, 2.0]'], f'genome has 2 genes, expected {GENES}'),
        ('controller', ['trigger:=luck'], "trigger is 'luck', expected one of timer, sensors"),
        ('controller', ['genome_server:=/x'], 'champion is empty'),
        ('genome_server', ['run:=/nowhere/at/all'], '/nowhere/at/all does not exist'),
    ],
)
def test_bad_parameters_are_one_sentence_and_exit_code_2(
    starter, executable, parameters, sentence
):
    arguments = [part for parameter in parameters for part in ('-p', parameter)]
    process = starter(['neuro_controller', executable, '--ros-args', *arguments])
    assert process.wait(40) == 2
    assert sentence in process.stderr_text
    assert 'Traceback' not in process.stderr_text
