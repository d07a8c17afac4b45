"""By default nothing leaves the machine."""

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


@pytest.mark.parametrize(
    ('discovery', 'leave'), [('', False), ('LOCALHOST', False), ('SUBNET', True)]
)
def test_nothing_leaves_the_machine_unless_the_network_is_opened(
    start, packets_library, tmp_path, discovery, leave
):
    leaving = tmp_path / 'leaving'
    leaving.touch()
    changes = {
        'LD_PRELOAD': str(packets_library),
        'PACKETS_LEAVING': str(leaving),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': discovery,
    }
    runner = [ROOT / 'scripts' / 'ros2', 'run', 'neuro_controller', 'genome_server']
    start(runner, changes)
    listener = start(['bash', '-c', IN_WORKSPACE, LISTENER, ROOT], changes)
    assert listener.wait() == 0, listener.stderr_text
    assert bool(leaving.read_text()) == leave
