"""The layouts for RViz and Foxglove show something of a running demo."""

import json
import re

import pytest
import yaml
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_client import ros_client
from ros_processes import ROOT, process_starter, ros_environment

SHARE = ROOT / 'ros2_ws' / 'src' / 'marxbot_sim'
DEMO = [str(ROOT / 'scripts' / 'ros2'), 'launch', 'coevo_manager', 'demo.launch.xml']


def foxglove():
    """Every path of the Foxglove layout: topic, then what is taken of its messages."""
    layout = json.loads((SHARE / 'foxglove' / 'arena.json').read_text())
    placed = json.dumps(layout['layout'])
    for name, panel in layout['configById'].items():
        assert f'"{name}"' in placed
        for path in panel.get('paths', ()):
            topic, _, field = path['value'].partition('.')
            yield topic, field
        yield from ((topic, '') for topic in panel.get('topics', ()))
        yield from ((panel[key], '') for key in ('topicPath', 'topicToRender') if key in panel)
        yield from ((layer['topic'], '') for layer in panel.get('layers', {}).values())


def rviz():
    """Every topic of the RViz layout."""
    layout = yaml.safe_load((SHARE / 'rviz' / 'arena.rviz').read_text())
    for display in layout['Visualization Manager']['Displays']:
        for key in ('Topic', 'Description Topic'):
            if key in display:
                yield display[key]['Value'], ''


PATHS = sorted({*foxglove(), *rviz(), ('/tf', ''), ('/tf_static', '')})


@pytest.fixture(scope='module')
def heard(tmp_path_factory):
    """The first message of each topic of the layouts, from a running demo."""
    from ros2_graph import interface

    messages = {}
    with (
        ros_environment() as env,
        process_starter(env, tmp_path_factory.mktemp('demo')) as start,
    ):
        start(DEMO)
        with ros_client(env) as client:
            infos = client.node.get_publishers_info_by_topic
            for topic in {topic for topic, _ in PATHS}:
                client.until(lambda t=topic: infos(t), f'a publisher of {topic}', 90)
                offer = infos(topic)[0]
                qos = QoSProfile(depth=10, durability=offer.qos_profile.durability)
                if offer.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT:
                    qos.reliability = ReliabilityPolicy.BEST_EFFORT
                assert qos.durability in (
                    DurabilityPolicy.VOLATILE,
                    DurabilityPolicy.TRANSIENT_LOCAL,
                )
                client.node.create_subscription(
                    interface(offer.topic_type),
                    topic,
                    lambda message, t=topic: messages.setdefault(t, message),
                    qos,
                )
            wanted = {topic for topic, _ in PATHS}
            client.until(lambda: wanted <= messages.keys(), 'a message of each topic')
    return messages


@pytest.mark.parametrize(('topic', 'field'), PATHS)
def test_what_a_layout_shows_is_there(heard, topic, field):
    value = heard[topic]
    for name, index in re.findall(r'(\w+)(?:\[(\d+)\])?', field):
        value = getattr(value, name)
        value = value[int(index)] if index else value
    assert not field or float(value) == value


def test_every_frame_of_the_robots_hangs_together(heard):
    parents = {
        transform.child_frame_id: transform.header.frame_id
        for topic in ('/tf', '/tf_static')
        for transform in heard[topic].transforms
    }
    for robot in ('predator', 'prey'):
        links = re.findall(r'<link name="(\w+)"', heard[f'/{robot}/robot_description'].data)
        for link in links:
            frame, steps = f'{robot}/{link}', 0
            while frame != 'map' and steps < 10:
                frame, steps = parents[frame], steps + 1
            assert frame == 'map'
