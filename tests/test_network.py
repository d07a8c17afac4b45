"""By default nothing leaves the machine."""

import subprocess

import pytest
from ros_processes import ROOT

LISTENER = """
import rclpy
from rclpy.node import Node
rclpy.init()
node = Node('listener')
while node.count_publishers('/parameter_events') < 2:
    rclpy.spin_once(node, timeout_sec=0.1)
node.destroy_node()
rclpy.try_shutdown()
"""
IN_WORKSPACE = 'source "$1/scripts/lib/common.sh" && enter_workspace && exec python -c "$0"'


@pytest.fixture(scope='module')
def watch(tmp_path_factory):
    """A library that writes down the datagrams with which a process would leave the machine."""
    library = tmp_path_factory.mktemp('watch') / 'packet_watch.so'
    source = ROOT / 'tests' / 'packet_watch.c'
    subprocess.run(
        ['cc', '-Wall', '-Werror', '-shared', '-fPIC', '-o', library, source, '-ldl'], check=True
    )
    return library


@pytest.mark.parametrize(
    ('discovery', 'leave'), [('', False), ('LOCALHOST', False), ('SUBNET', True)]
)
def test_nothing_leaves_the_machine_unless_the_network_is_opened(
    start, watch, tmp_path, discovery, leave
):
    leaving = tmp_path / 'leaving'
    changes = {
        'LD_PRELOAD': str(watch),
        'PACKETS_LEAVING': str(leaving),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': discovery,
    }
    runner = [ROOT / 'scripts' / 'ros2', 'run', 'neuro_controller', 'genome_server']
    start(runner, changes)
    listener = start(['bash', '-c', IN_WORKSPACE, LISTENER, ROOT], changes)
    assert listener.wait() == 0, listener.stderr_text
    assert leaving.exists() == leave, leaving.read_text()
