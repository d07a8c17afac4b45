"""Answers arrive although every fifth packet is lost, on a transport that loses packets."""

import os
import sys
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_share_directory
from bag_stamps import stamps_of
from evolve_runs import TOY, read_files
from ros_processes import ROOT
from rosbags.highlevel import AnyReader

from coevo_manager.recording.message_types import make_typestore

LOSS = 0.2
UDP_ONLY = """
<transport_descriptors>
    <transport_descriptor>
        <transport_id>loopback</transport_id>
        <type>UDPv4</type>
        <interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>
    </transport_descriptor>
</transport_descriptors>
<participant profile_name="loopback" is_default_profile="true">
    <rtps>
        <userTransports><transport_id>loopback</transport_id></userTransports>
        <useBuiltinTransports>false</useBuiltinTransports>
    </rtps>
</participant>
"""
CLIENT = """
import os, sys
from coevo_msgs.action import RunEpisode
from ros_client import GoalClient, ros_client

class Counting(GoalClient):
    sent = 0

    def send_goal_async(self, *arguments):
        self.sent += 1
        return super().send_goal_async(*arguments)

goals = int(sys.argv[1])
arrived = repeated = 0
for _ in range(goals):
    with ros_client(os.environ) as client:
        action = Counting(client, RunEpisode, 'run_episode')
        goal = RunEpisode.Goal()
        goal.environment.episode_ticks = 0
        handle = action.send(goal)
        assert 'episode_ticks is 0' in action.result(handle).result.message
        arrived += handle.accepted
        repeated += action.sent > 1
        print(f'{arrived} of {goals} goals answered, {repeated} sent again', flush=True)
"""


@pytest.fixture(scope='session')
def loss(packets_library, tmp_path_factory):
    """What a process needs in its environment to lose packets."""
    settings = Path(get_package_share_directory('node_runner'), 'fastdds.xml').read_text()
    udp_only = tmp_path_factory.mktemp('dds') / 'udp_only.xml'
    udp_only.write_text(settings.replace('<profiles>', f'<profiles>{UDP_ONLY}'))
    return {
        'LD_PRELOAD': str(packets_library),
        'PACKET_LOSS': str(LOSS),
        # Shared memory loses nothing, and with LOCALHOST rmw_fastrtps always adds it.
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SYSTEM_DEFAULT',
        'FASTRTPS_DEFAULT_PROFILES_FILE': str(udp_only),
        'PYTHONPATH': os.pathsep.join([str(ROOT / 'tests'), os.environ.get('PYTHONPATH', '')]),
    }


def test_goals_are_accepted_and_answered(start, loss):
    episodes = start(['coevo_manager', 'episodes'], loss)
    episodes.wait_for_output('ready on')
    assert '/dev/shm/fastrtps' not in Path('/proc', str(episodes.pid), 'maps').read_text()
    client = start([sys.executable, '-c', CLIENT, '5'], loss)
    assert client.wait(200) == 0, client.stderr_text
    assert client.stdout_text.splitlines()[-1].startswith('5 of 5 goals')


@pytest.mark.timeout(600)
def test_a_run_is_the_same(start, loss, tmp_path):
    options = [*TOY, '--phases', '4', '--evaluators', '2']
    for name, changes in (('lossy', loss), ('whole', {})):
        run = start(['coevo_manager', 'evolve', *options, '--out', tmp_path / name], changes)
        assert run.wait(250) == 0, run.stderr_text
    assert read_files(tmp_path / 'lossy') == read_files(tmp_path / 'whole')


@pytest.mark.timeout(600)
@pytest.mark.parametrize('losing', [False, True])
def test_a_recording_is_whole_or_an_error(start, loss, tmp_path, losing):
    bag = tmp_path / 'bag'
    options = ['--world', 'robust', '--episode-ticks', '40']
    record = start(['coevo_manager', 'record', bag, *options], loss if losing else {})
    if record.wait(250) == 0:
        with AnyReader([bag], default_typestore=make_typestore()) as reader:
            for robot in ('predator', 'prey'):
                for name in ('proximity', 'camera', 'ground', 'traction', 'cmd_vel', 'neurons'):
                    assert set(stamps_of(reader, f'/{robot}/{name}')) == set(range(40))
    else:
        assert losing
        said = [line for line in record.stderr_text.splitlines() if 'in place of' not in line]
        assert len(said) == 1, said
        assert not bag.exists()
