"""Hands every topic's messages, as they are, to whoever connects with Foxglove."""

import argparse
import sys
from pathlib import Path
from typing import Any

from ament_index_python import get_package_share_directory
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros2_graph import interface
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from node_runner import Complaints, make_executor, run_ros, wait_until

LOOK = 1.0
"""Time between two looks for new topics, s."""

OWN_PACKAGES = ('marxbot_msgs', 'coevo_msgs')


class Bridge(Node):
    """Subscribes to every topic there is, and follows those that come."""

    def __init__(self, channel: Any, schema: Any) -> None:
        super().__init__('foxglove_bridge', start_parameter_services=False)
        self._channel, self._schema = channel, schema
        self._complaints = Complaints(self.get_logger())
        self._known: set[str] = set()
        self._types = get_typestore(Stores.ROS2_JAZZY)
        for package in OWN_PACKAGES:
            for path in Path(get_package_share_directory(package), 'msg').glob('*.msg'):
                self._types.register(
                    get_types_from_msg(path.read_text(), f'{package}/msg/{path.stem}')
                )
        self._look()
        self.create_timer(LOOK, self._look)

    def _look(self) -> None:
        for topic, types in self.get_topic_names_and_types():
            if topic not in self._known and self.get_publishers_info_by_topic(topic):
                self._known.add(topic)
                try:
                    self._serve(topic, types[0])
                except (ValueError, KeyError):
                    self._complaints.warn(f'{topic} is not served: {types[0]} is not known here')

    def _serve(self, topic: str, type_name: str) -> None:
        definition, _ = self._types.generate_msgdef(type_name, ros_version=2)
        schema = self._schema(name=type_name, encoding='ros2msg', data=definition.encode())
        channel = self._channel(topic, message_encoding='cdr', schema=schema)
        offers = [info.qos_profile for info in self.get_publishers_info_by_topic(topic)]
        qos = QoSProfile(depth=100)
        if any(offer.reliability == ReliabilityPolicy.BEST_EFFORT for offer in offers):
            qos.reliability = ReliabilityPolicy.BEST_EFFORT
        if all(offer.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offers):
            qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
        self.create_subscription(interface(type_name), topic, channel.log, qos, raw=True)


def main() -> int:
    """Serve until a signal comes."""
    parser = argparse.ArgumentParser(prog='foxglove')
    parser.add_argument('--port', type=int, default=8765)
    parser.add_argument('--host', default='127.0.0.1')
    options = parser.parse_args()

    def serve() -> int:
        try:
            from foxglove import Channel, Schema, start_server
        except ImportError:
            raise ValueError(
                'foxglove-sdk is not installed, expected it by '
                '.venv/bin/uv pip install --python .venv/bin/python foxglove-sdk'
            ) from None
        if not 0 <= options.port < 65536:
            raise ValueError(f'port is {options.port}, expected 0 to 65535')
        server = start_server(name='Red Queen', host=options.host, port=options.port)
        print(f'serves ws://{options.host}:{server.port}', flush=True)
        bridge = Bridge(Channel, Schema)
        try:
            wait_until(make_executor(bridge), lambda: False, float('inf'), 'the end')
        finally:
            server.stop()
            bridge.destroy_node()
        return 0

    return run_ros(serve, ['foxglove'])


if __name__ == '__main__':
    sys.exit(main())
