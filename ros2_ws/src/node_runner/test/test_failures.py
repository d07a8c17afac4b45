"""What happens when a callback raises: it is told with its place, and the node lives on."""

import sys

import pytest

PROGRAM = """
import sys
import rclpy
from node_runner import Interface, run_node
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

def fail(*_):
    raise ValueError('boom')

async def fail_later(*_):
    raise ValueError('boom')

class Failing(Node):
    def __init__(self):
        super().__init__('failing')
        {body}
        self.create_timer(0.1, self.count)
        self.turns = 0

    def every(self, act):
        self.create_timer(0.1, act)

    def call(self):
        client = self.create_client(Trigger, 'x')
        self.create_service(Trigger, 'x', lambda request, response: response)
        return lambda: client.call_async(Trigger.Request()).add_done_callback(fail)

    def count(self):
        self.turns += 1
        if self.turns == 10:
            print('lives on', flush=True)

    def on_failure(self, reason):
        print('safe after', reason, flush=True)

sys.exit(run_node(Failing, Interface('a b', 'fails')))
"""
CALLBACKS = {
    'timer': 'self.every(fail)',
    'subscription': (
        "self.create_subscription(String, 'x', fail, 1); "
        "talk = self.create_publisher(String, 'x', 1); self.every(lambda: talk.publish(String()))"
    ),
    'done callback': 'self.every(self.call())',
    'coroutine': 'self.every(lambda: self.executor.create_task(fail_later))',
}


@pytest.mark.parametrize('kind', CALLBACKS)
def test_a_node_outlives_what_its_callbacks_raise(start, kind):
    process = start([sys.executable, '-c', PROGRAM.format(body=CALLBACKS[kind])])
    process.wait_for_output('lives on')
    assert 'a callback failed with ValueError: boom (<string>, line ' in process.stderr_text
    assert 'safe after ' in process.stdout_text
    process.terminate()
    assert process.wait() == 0


def test_a_node_outlives_a_message_that_cannot_be_read(start):
    body = (
        "self.create_subscription(String, 'x', print, 1); "
        "talk = self.create_publisher(String, 'x', 1); "
        'self.every(lambda: talk.publish(bytes([0, 1, 0, 0, 255, 255, 0, 0])))'
    )
    start([sys.executable, '-c', PROGRAM.format(body=body)]).wait_for_output('lives on')


def test_what_the_constructor_raises_is_bad_input(start):
    process = start([sys.executable, '-c', PROGRAM.format(body='fail()')])
    assert process.wait() == 2
    assert process.stderr_text == '-c: boom\n'


def test_a_command_ends_with_a_sentence_when_a_callback_raises(start):
    program = """
import sys
from node_runner import make_executor, run_ros, wait_until
from rclpy.node import Node

def work():
    node = Node('n')
    executor = make_executor(node)
    node.create_timer(0.1, lambda: int('no number'))
    wait_until(executor, lambda: False, 20, 'rain')

sys.exit(run_ros(work))
"""
    process = start([sys.executable, '-c', program])
    assert process.wait() == 1
    last = process.stderr_text.splitlines()[-1]
    assert last.startswith('-c: a callback failed with ValueError: invalid literal')
    assert last.endswith('(<string>, line 9)')
