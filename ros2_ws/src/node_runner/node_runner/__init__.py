"""Start, spin and cleanly end a ROS 2 node: the one loop that every node of the workspace runs.

It exists because the obvious ways fall short on Jazzy: rclpy's own signal handling races with the
executor's (a busy node ends in an ``RCLError``, an idle one sometimes hangs), and the stock
single-threaded executor is 1.6 times slower in lockstep than the events executor.
"""

from node_runner.asking import ask, new_number
from node_runner.complaints import Complaints
from node_runner.concerns import Concerns
from node_runner.executor import describe, make_executor
from node_runner.interface import Interface, Parameter, Service, Topic
from node_runner.runner import run_node, run_ros, stop_requested, wait_until
from node_runner.start import complain, own_arguments, start_ros

__all__ = [
    'Complaints',
    'Concerns',
    'Interface',
    'Parameter',
    'Service',
    'Topic',
    'ask',
    'complain',
    'describe',
    'make_executor',
    'new_number',
    'own_arguments',
    'run_node',
    'run_ros',
    'start_ros',
    'stop_requested',
    'wait_until',
]
