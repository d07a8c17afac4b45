"""``scripts/ros2``'s commands that ask running nodes, in the words of ros2cli, and the bridge."""

import contextlib
import fcntl
import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from ros_processes import FIRST_PORT, PORTS_EACH, ROOT, own_lines, ros_environment, wait_until

COMMAND = [str(ROOT / 'scripts' / 'ros2')]


@pytest.fixture(scope='module')
def demo(env, starter):
    """A simulator in real time and one controller, unconfigured."""
    simulator = starter(['marxbot_sim', 'simulator', '--ros-args', '-p', 'physics:=kinematic'])
    controller = ['neuro_controller', 'controller', '--ros-args', '-r', '__ns:=/prey']
    starter(controller)
    simulator.wait_for_output('arena of 3 m')

    def run(*arguments, code=0):
        result = subprocess.run(
            [*COMMAND, *arguments],
            env=env,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=120,
        )
        assert result.returncode == code, result.stderr
        said = own_lines(result.stderr)
        return said if code == 2 else result.stdout or said

    return run


@pytest.fixture
def env_of_taken_ports():
    """A domain whose first ports in shared memory another process holds."""
    with ros_environment() as env, contextlib.ExitStack() as held:
        first = FIRST_PORT + PORTS_EACH * int(env['ROS_DOMAIN_ID'])
        for port in range(first, first + 20):
            path = Path(f'/dev/shm/fastrtps_port{port}_el')
            held.callback(path.unlink)
            # which those who ask for the port make
            mutex = Path(f'/dev/shm/sem.fastrtps_port{port}_mutex')
            held.callback(mutex.unlink, missing_ok=True)
            fcntl.flock(held.enter_context(path.open('w')), fcntl.LOCK_EX)
        yield env


def test_what_dds_complains_of_is_not_in_the_answer(env_of_taken_ports):
    result = subprocess.run(
        [*COMMAND, 'node', 'list'],
        env=env_of_taken_ports,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout == '\n'
    assert 'open_and_lock_file failed' in result.stderr


def test_lists_of_nodes_and_topics(demo):
    names = ['/prey/controller', '/simulator']
    listed = []

    def complete():
        listed.append(demo('node', 'list').split())
        return listed[-1] == names

    with contextlib.suppress(AssertionError):
        wait_until(complete, 'both nodes')
    assert listed[-1] == names, listed
    wanted = {'/clock', '/tf', '/tf_static', '/prey/proximity', '/predator/cmd_vel'}
    wait_until(lambda: wanted <= set(demo('topic', 'list').split()), 'the topics')
    line = '/prey/camera [marxbot_msgs/msg/Camera]'
    wait_until(lambda: line in demo('topic', 'list', '-t').splitlines(), 'the types')


def test_echo_prints_messages_as_yaml(demo):
    text = demo('topic', 'echo', '--once', '/prey/proximity')
    assert text.endswith('---\n')
    scan = yaml.safe_load(text.removesuffix('---\n'))
    assert scan['header']['frame_id'] == 'prey/base_link' and len(scan['ranges']) == 24
    latched = demo('topic', 'echo', '--once', '/prey/leds', 'std_msgs/msg/ColorRGBA')
    assert yaml.safe_load(latched.removesuffix('---\n')) == {
        'r': 0.0,
        'g': 1.0,
        'b': 0.0,
        'a': 1.0,
    }
    size = demo('topic', 'echo', '--once', '--field', 'size', '/arena/state')
    assert size.split() == ['3.0', '---']


def test_hz_tells_the_rate(env, demo, starter):
    process = starter([*COMMAND, 'topic', 'hz', '/clock'])
    process.wait_for_output('average rate: ')
    process.wait_for_output('s window: ')
    process.terminate()
    assert process.wait() == 0


def test_parameters_are_read_and_set(demo):
    assert demo('param', 'get', '/simulator', 'real_time_factor') == 'Double value is: 1.0\n'
    assert demo('param', 'get', '/simulator', 'physics') == 'String value is: kinematic\n'
    assert demo('param', 'get', '/simulator', 'paused') == 'Boolean value is: False\n'
    assert demo('param', 'get', '/simulator', 'nothing', code=1) == 'Parameter not set\n'
    done = demo('param', 'set', '/simulator', 'real_time_factor', '2.0')
    assert done == 'Set parameter successful\n'
    assert demo('param', 'get', '/simulator', 'real_time_factor') == 'Double value is: 2.0\n'
    refused = demo('param', 'set', '/simulator', 'real_time_factor', '1.0e-300', code=1)
    sentence = 'real_time_factor is 1e-300, expected a number from 0.001 to 1000'
    assert refused == f'Setting parameter failed: {sentence}\n'


def test_a_lifecycle_node_is_configured(demo):
    node = '/prey/controller'
    assert demo('lifecycle', 'get', node) == 'unconfigured [1]\n'
    assert demo('lifecycle', 'set', node, 'configure', code=1) == 'Transitioning failed\n'
    unknown = demo('lifecycle', 'set', node, 'activate', code=1)
    assert 'Unknown transition requested, available ones are:\n- configure [1]' in unknown
    genes = str([0.0] * 442)
    assert demo('param', 'set', node, 'genome', genes) == 'Set parameter successful\n'
    assert demo('lifecycle', 'set', node, 'configure') == 'Transitioning successful\n'
    assert demo('lifecycle', 'set', node, 'activate') == 'Transitioning successful\n'
    assert demo('lifecycle', 'get', node) == 'active [3]\n'


def test_a_service_is_called(demo):
    answer = demo('service', 'call', '/simulator/pause', 'std_srvs/srv/SetBool', '{data: true}')
    assert "SetBool_Response(success=True, message='paused')" in answer
    poses = '{predator: {x: -0.6, y: 0.2}, prey: {x: 9}}'
    answer = demo('service', 'call', '/simulator/set_poses', 'marxbot_msgs/srv/SetPoses', poses)
    assert 'success=False' in answer


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (['topic', 'echo', '--once', '/prey/leds', 'no/such/Type'], "type 'no/such/Type' is not"),
        (['service', 'call', '/simulator/pause', 'std_srvs/srv/SetBool', '{of: 1}'], "field 'of'"),
        (['service', 'call', '/x', 'std_srvs/srv/SetBool', '{data: 7}'], 'data is 7'),
        (['param', 'get', '/simulator'], 'required: parameter'),
    ],
)
def test_bad_input_is_one_sentence(demo, arguments, sentence):
    text = demo(*arguments, code=2)
    assert sentence in text and text.count('\n') == 1


def test_a_node_that_is_not_there_is_told(demo):
    text = demo('param', 'get', '/nobody', 'x', code=1)
    assert 'the start of /nobody/get_parameters did not happen within 10 s' in text


def test_the_bridge_serves_or_says_what_it_needs(env, starter):
    process = starter(
        [sys.executable, ROOT / 'scripts' / 'lib' / 'foxglove_bridge.py', '--port', '0']
    )
    spec = importlib.util.find_spec('foxglove')
    if spec is not None and spec.origin:
        process.wait_for_output('serves ws://127.0.0.1:')
    else:
        assert process.wait() == 2
        assert 'foxglove-sdk is not installed' in process.stderr_text
