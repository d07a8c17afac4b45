"""What a node says of its surroundings, and of itself with ``--help``."""

import os
import sys

import pytest
from ros_client import ros_client

PROGRAM = """
import sys
from node_runner import Concerns, Interface, Parameter, run_node
from rclpy.node import Node
from std_msgs.msg import Int32

INTERFACE = Interface(
    'a b', 'is', (Parameter('speed', 1.0, 'm/s', low=0.1, high=2.0, live=True),)
)

class Concerned(Node):
    def __init__(self):
        super().__init__('concerned')
        INTERFACE.declare(self)
        self.create_subscription(Int32, 'number', print, 1)
        self.concerns = Concerns(self)
        print('up', flush=True)

sys.exit(run_node(Concerned, INTERFACE))
"""


@pytest.fixture
def concerned(start):
    def run(*arguments):
        return start([sys.executable, '-c', PROGRAM, *map(str, arguments)])

    return run


def ros(*arguments):
    return ['--ros-args', *arguments]


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (
            ros('-p', 'sped:=2.0'),
            "parameter 'sped' was given, and this node has none of that name",
        ),
        (ros('-p', 'use_sim_time:=true'), 'use_sim_time is set and nothing came on /clock so far'),
    ],
)
def test_what_was_misspelt_is_told(concerned, arguments, sentence):
    concerned(*arguments).wait_for_output(sentence)


@pytest.mark.parametrize(
    ('name', 'ours'),
    [
        ('/ns/concerned', True),
        ('/**', True),
        ('/*/concerned', True),
        ('/**/concerned', True),
        ('/concerned', False),
        ('/ns/concernd', False),
        ('/*', False),
    ],
)
def test_a_parameter_file_for_other_nodes_is_told(concerned, tmp_path, name, ours):
    file = tmp_path / 'parameters.yaml'
    file.write_text(f"'{name}':\n  ros__parameters:\n    speed: 1.5\n")
    process = concerned(*ros('--params-file', file, '-r', '__ns:=/ns'))
    process.wait_for_output('up')
    sentence = f'parameter file {file} names {name}, and not this node, /ns/concerned'
    assert (sentence in process.stderr_text) != ours


@pytest.mark.parametrize('make', [os.mkfifo, os.mkdir, str])
def test_what_is_no_parameter_file_is_refused(concerned, tmp_path, make):
    file = tmp_path / 'parameters.yaml'
    make(file)
    process = concerned(*ros('--params-file', file))
    assert process.wait() == 2
    sentence = f': parameter file {file} is no file, expected one of YAML'
    assert process.stderr_text.rstrip().endswith(sentence)
    assert len(process.stderr_text.splitlines()) == 1


@pytest.mark.parametrize('bracket', '[{')
def test_a_parameter_file_of_brackets_is_refused_at_once(concerned, tmp_path, bracket):
    file = tmp_path / 'parameters.yaml'
    file.write_text(f'/**:\n  ros__parameters:\n    speed: {bracket * 200_000}\n')
    process = concerned(*ros('--params-file', file))
    assert process.wait() == 2
    sentence = f': parameter file {file} has more than 100 brackets in brackets'
    assert process.stderr_text.rstrip().endswith(sentence)


def test_another_type_on_a_topic_is_told(concerned, ros_env):
    from std_msgs.msg import String

    process = concerned()
    with ros_client(ros_env) as client:
        client.node.create_publisher(String, 'number', 1)
        process.wait_for_output(
            '/number is std_msgs/msg/Int32 here, and published as std_msgs/msg/String by another'
        )


def test_help_is_printed_and_nothing_started(concerned):
    process = concerned('--help')
    assert process.wait() == 0
    assert '  speed (double, default 1.0, from 0.1 to 2, live): m/s' in process.stdout_text
    assert process.stderr_text == ''


def test_an_unknown_argument_is_refused(concerned):
    process = concerned('--hepl')
    assert process.wait() == 2
    assert process.stderr_text.startswith("a b: the argument '--hepl' is not known")


@pytest.mark.parametrize('value', ['0.05', '3.0', '.nan', '.inf'])
def test_a_value_out_of_range_is_refused_at_the_start(concerned, value):
    process = concerned(*ros('-p', f'speed:={value}'))
    assert process.wait() == 2
    assert 'speed is ' in process.stderr_text
    assert 'expected a number from 0.1 to 2' in process.stderr_text
