"""By default nothing leaves the machine."""

import os
import shutil
import subprocess

import pytest
from ros_processes import ROOT

SCRIPT = r"""
sysctl -q -w net.ipv6.conf.all.disable_ipv6=1 net.ipv6.conf.default.disable_ipv6=1
ip link set lo up
ip link add card type veth peer name cable
ip addr add 10.9.0.1/24 dev card
ip link set card up
ip link set cable up
sent() { awk '/card:/ { print $11 }' /proc/self/net/dev; }
source "$0/scripts/lib/common.sh"
enter_workspace
before=$(sent)
"$0/ros2_ws/install/neuro_controller/lib/neuro_controller/genome_server" &
server=$!
python - <<'PYTHON'
import rclpy
from rclpy.node import Node
rclpy.init()
node = Node('listener')
for _ in range(300):
    if node.count_publishers('/parameter_events') == 2:
        break
    rclpy.spin_once(node, timeout_sec=0.1)
else:
    raise SystemExit('the two nodes never met')
node.destroy_node()
rclpy.try_shutdown()
PYTHON
kill -INT $server
wait $server
echo "sent $(( $(sent) - before ))"
"""


def packets_sent(tmp_path, **environment):
    """Packets that leave a machine of its own on its network card while two nodes meet there."""
    result = subprocess.run(
        ['unshare', '--net', 'bash', '-c', SCRIPT, ROOT],
        env={'PATH': os.environ['PATH'], 'HOME': str(tmp_path), **environment},
        capture_output=True,
        text=True,
        timeout=100,
    )
    assert result.returncode == 0, result.stderr
    return int(result.stdout.split('sent ')[-1])


@pytest.mark.skipif(
    os.getuid() != 0 or not shutil.which('unshare') or not shutil.which('ip'),
    reason='a network of its own takes root, unshare and ip',
)
def test_nothing_leaves_the_machine_unless_the_network_is_opened(tmp_path):
    assert packets_sent(tmp_path) == 0
    assert packets_sent(tmp_path, ROS_AUTOMATIC_DISCOVERY_RANGE='SUBNET') > 0
