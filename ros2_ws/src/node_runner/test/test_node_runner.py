"""How processes begin and end: exit codes, signals, children, and warnings that do not flood."""

import os
import signal
import subprocess
import sys

import psutil
import pytest
from ros_processes import has_ended, wait_until

from node_runner import Complaints
from node_runner.children import Child, end_all

PROGRAM = """
import sys
from node_runner import make_executor, run_node, run_ros, wait_until
from node_runner.children import Children
from rclpy.node import Node

def work():
    {body}

sys.exit(run_ros(work, ['work', *sys.argv[1:]]))
"""


def program(body):
    return [sys.executable, '-c', PROGRAM.format(body=body)]


@pytest.mark.parametrize(
    ('body', 'code', 'sentence'),
    [
        ('return 0', 0, ''),
        ("raise ValueError('x is 1, expected 2')", 2, 'work: x is 1, expected 2'),
        ("raise RuntimeError('it broke')", 1, 'work: it broke'),
        (
            "wait_until(make_executor(Node('n')), lambda: False, 0.2, 'rain')",
            1,
            'work: rain did not happen within 0.2 s',
        ),
    ],
)
def test_exit_codes_and_sentences(start, body, code, sentence):
    process = start(program(body))
    assert process.wait() == code
    assert process.stderr_text.strip() == sentence


def test_bad_ros_arguments_are_refused_in_one_sentence(start):
    process = start([*program('return 0'), '--ros-args', '--nonsense'])
    assert process.wait() == 2
    (line,) = process.stderr_text.splitlines()
    assert '--nonsense' in line


@pytest.mark.parametrize('rule', ['__node:=a/b', 'a:__name:=' + 'x' * 300, '__ns:=/' + 'x' * 300])
def test_a_name_that_no_node_can_have_is_refused_in_one_sentence(start, rule):
    process = start([*program("Node('n'); return 0"), '--ros-args', '-r', rule])
    assert process.wait() == 2
    (line,) = process.stderr_text.splitlines()
    assert line.startswith(f"work: -r is '{rule[:8]}") and len(line) < 150


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('ROS_DOMAIN_ID', 'abc'),
        ('ROS_DOMAIN_ID', '233'),
        ('ROS_AUTOMATIC_DISCOVERY_RANGE', 'here'),
        ('RCUTILS_COLORIZED_OUTPUT', 'yes'),
    ],
)
def test_a_variable_with_which_ros_would_not_start_is_named(start, name, value):
    process = start(program('return 0'), {name: value})
    assert process.wait() == 2
    (line,) = process.stderr_text.splitlines()
    assert line.startswith(f"work: {name} is '{value}', expected ")


def test_no_home_is_needed(start):
    process = start(
        program("Node('n'); return 0"), {'HOME': '', 'ROS_HOME': '', 'ROS_LOG_DIR': ''}
    )
    assert process.wait() == 0
    assert process.stderr_text == ''


@pytest.mark.parametrize('peers', ['###', '127.0.0.1;no.such.host.invalid'])
def test_peers_without_an_address_are_named(start, peers):
    process = start(program("Node('n'); return 0"), {'ROS_STATIC_PEERS': peers})
    assert process.wait() == 2
    (line,) = process.stderr_text.splitlines()
    assert line.startswith(f"work: ROS_STATIC_PEERS names '{peers.split(';')[-1]}', which has no ")


def test_what_rcl_raises_is_one_line_without_places_in_its_sources(start):
    body = "raise RuntimeError('no node: no memory\\n, at /project/src/rcl/node.c:252')"
    process = start(program(body))
    assert process.wait() == 1
    assert process.stderr_text == 'work: no node: no memory\n'


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_a_wait_with_exit_code_0(start, number):
    body = "print('up', flush=True); wait_until(make_executor(Node('n')), lambda: 0, 60, 'rain')"
    process = start(program(body))
    process.wait_for_output('up')
    process.send_signal(number)
    assert process.wait() == 0
    assert process.stderr_text == ''


def test_children_end_with_a_killed_parent(start):
    body = (
        "children = Children(); children.start('neuro_controller', 'genome_server'); "
        "wait_until(make_executor(Node('n')), lambda: 0, 60, 'rain')"
    )
    process = start(program(body))
    parent = psutil.Process(process.pid)
    wait_until(parent.children, 'the child')
    (child,) = parent.children()
    process.kill()
    wait_until(lambda: has_ended(child), 'its end')


PARENT = """
import os, random, signal, sys, threading, time
from node_runner.children import Child
mark = sys.argv[1]

def end():
    time.sleep(random.uniform(0, 0.05))
    os.kill(os.getpid(), signal.SIGKILL)

threading.Thread(target=end).start()
while True:
    Child(['sleep', mark])
"""


def test_no_child_outlives_a_parent_that_is_killed_while_it_starts_them(start):
    for number in range(10):
        seconds = f'{300 + number}.{os.getpid()}'
        parent = start([sys.executable, '-c', PARENT, seconds])
        assert parent.wait() == -signal.SIGKILL
        wait_until(lambda seconds=seconds: not _living('sleep', seconds), 'the end of all')


def test_a_stopped_child_ends_with_its_killed_parent(start):
    seconds = f'400.{os.getpid()}'
    body = f"Child(['sleep', '{seconds}']); print('up', flush=True); time.sleep(100)"
    parent = start(
        [sys.executable, '-c', f'import time\nfrom node_runner.children import Child\n{body}']
    )
    parent.wait_for_output('up')
    (child,) = _living('sleep', seconds)
    child.send_signal(signal.SIGSTOP)
    parent.kill()
    wait_until(lambda: not _living('sleep', seconds), 'its end')


def test_stopped_children_are_ended_and_obstinate_ones_killed():
    stopped, willing = (Child(['sleep', '300']) for _ in range(2))
    obstinate = Child(
        [sys.executable, '-c', 'import signal, time\nsignal.signal(15, signal.SIG_IGN)\n'
         'print(1, flush=True)\ntime.sleep(300)'], stdout=subprocess.PIPE
    )  # fmt: skip
    obstinate.stdout.readline()
    stopped.send_signal(signal.SIGSTOP)
    end_all([stopped, willing, obstinate], timeout=0.5)
    assert stopped.returncode == willing.returncode == -signal.SIGTERM
    assert obstinate.returncode == -signal.SIGKILL
    obstinate.stdout.close()


def _living(*command):
    """Return the processes of a command that have not ended."""
    found = []
    for process in psutil.process_iter(['cmdline']):
        if process.info['cmdline'] == list(command) and not has_ended(process):
            found.append(process)
    return found


def test_a_complaint_is_not_repeated_but_another_is_heard(monkeypatch):
    class Logger:
        def __init__(self):
            self.texts = []

        def warning(self, text):
            self.texts.append(text)

    now = [100.0]
    monkeypatch.setattr('node_runner.complaints.time.monotonic', lambda: now[0])
    logger = Logger()
    complaints = Complaints(logger)
    for text in ('prey stopped: 1 s', 'prey stopped: 2 s', 'predator stopped: 2 s'):
        complaints.warn(text)
    now[0] += 5.0
    complaints.warn('prey stopped: 7 s')
    assert logger.texts == ['prey stopped: 1 s', 'predator stopped: 2 s', 'prey stopped: 7 s']
