"""Episodes over topics: equal to the headless ones bit for bit, and whole in their bags."""

import dataclasses
import io
import json
import signal

import numpy as np
import psutil
import pytest
import yaml
from action_msgs.msg import GoalStatus
from bag_stamps import stamps_of
from coevo_msgs.action import RunEpisode
from imageio_ffmpeg import count_frames_and_secs
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from mcap_ros2.reader import read_ros2_messages
from nav_msgs.msg import Odometry
from PIL import Image
from rcl_interfaces.srv import GetParameters
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointTypeEnum
from ros_client import GoalClient
from ros_processes import ROOT, has_ended, wait_until
from rosbags.highlevel import AnyReader
from sensor_msgs.msg import LaserScan

from coevo_manager.core.environment import Environment, make_environment
from coevo_manager.core.episodes import measure_pairs
from coevo_manager.core.episodes.trace import trace_pair
from coevo_manager.core.provenance import EPISODE, choose_environment
from coevo_manager.core.worlds import WORLDS
from coevo_manager.recording.bag_reader import BagReader
from coevo_manager.recording.bag_writer import BagWriter
from coevo_manager.recording.episode_player import EpisodePlayer
from coevo_manager.recording.message_types import make_typestore
from marxbot_sim.core.perturbations import Perturbations
from neuro_controller.core.champions import SHIPPED, select_champion
from neuro_controller.core.genome import random_genomes
from neuro_controller.core.snapshot import read_snapshot

RADIUS = np.float32(0.085)

CONDITIONS = {
    **{
        world: make_environment({**values, 'episode_ticks': 300})
        for world, values in WORLDS.items()
    },
    'plain': Environment(
        motor_map='printed',
        wall_contact='slide',
        infrared_response='linear',
        ground_coding='raw',
        wall_friction=0.0,
        episode_ticks=150,
    ),
    'obstacle': Environment(obstacle=True),
    'obstacle undo': Environment(obstacle=True, wall_contact='undo', episode_ticks=150),
    'pymunk': Environment(physics='pymunk', obstacle=True, episode_ticks=150),
}
PAIRS = 3


def pairs(condition):
    """The best of evolution and, for what these never do, random ones."""
    champions = read_snapshot(
        SHIPPED / ('obstacle.npz' if 'obstacle' in condition else 'open.npz')
    )
    rng = np.random.default_rng(len(condition))
    predators, prey = champions.best('predator', 2), champions.best('prey', 3)
    yield predators[0], prey[0]
    yield predators[1], prey[2]
    for _ in range(PAIRS - 2):
        yield random_genomes(2, rng)


@pytest.fixture(scope='module')
def recorded(client, tmp_path_factory):
    """A bag of a short obstacle episode, what its player saw, and the wire's type hashes."""
    path = tmp_path_factory.mktemp('bags') / 'episode'
    environment = Environment(obstacle=True, episode_ticks=120)
    predator, prey = next(pairs('obstacle'))
    with EpisodePlayer(environment) as player:
        with BagWriter(path) as bag:
            episode = player.play(predator, prey, bag)
        hashes = {}
        for topic, types in client.node.get_topic_names_and_types():
            for info in client.node.get_publishers_info_by_topic(topic):
                assert info.endpoint_type == TopicEndpointTypeEnum.PUBLISHER
                hashes[types[0]] = str(info.topic_type_hash)
    return path, episode, trace_pair(predator, prey, environment), hashes


@pytest.mark.parametrize('condition', CONDITIONS)
def test_whole_trajectories_equal_the_headless_ones_bit_for_bit(client, condition):
    environment = CONDITIONS[condition]
    captures = 0
    with EpisodePlayer(environment) as player:
        for predator, prey in pairs(condition):
            episode = player.play(predator, prey)
            trace = trace_pair(predator, prey, environment)
            assert (episode.ticks, episode.captured) == (trace.ticks, trace.captured)
            assert episode.wheels.tobytes() == trace.wheels.tobytes()
            assert episode.poses.tobytes() == trace.poses.tobytes()
            captures += episode.captured
    assert captures or environment.episode_ticks < 1000


def test_a_bag_holds_every_message_of_every_topic(recorded):
    path, episode, trace, _ = recorded
    with AnyReader([path], default_typestore=make_typestore()) as reader:
        counts = {c.topic: c.msgcount for c in reader.connections}
        per_tick = {'proximity', 'camera', 'ground', 'traction', 'cmd_vel', 'neurons'}
        for robot in ('predator', 'prey'):
            for name in per_tick:
                stamps = set(stamps_of(reader, f'/{robot}/{name}'))
                assert stamps == set(range(episode.ticks))
            for name in ('odom', 'ground_truth', 'joint_states'):
                assert counts[f'/{robot}/{name}'] == episode.ticks + 1
            assert counts[f'/{robot}/leds'] == counts[f'/{robot}/robot_description'] == 1
        assert counts['/clock'] == counts['/arena/markers'] == episode.ticks + 1
        for robot, name in enumerate(('predator', 'prey')):
            readings = np.full((episode.ticks, 37), np.nan, np.float32)
            for connection, _, data in reader.messages():
                prefix, topic = connection.topic.rsplit('/', 1)
                if prefix != f'/{name}' or topic not in per_tick - {'cmd_vel', 'neurons'}:
                    continue
                message = reader.deserialize(data, connection.msgtype)
                stamp = message.header.stamp
                tick = round(stamp.sec * 10 + stamp.nanosec * 1e-8) - 1
                match topic:
                    case 'proximity':
                        readings[tick, :24] = message.ranges - RADIUS
                    case 'camera':
                        readings[tick, 24:32] = message.sectors
                    case 'ground':
                        readings[tick, 32:36] = message.darkness
                    case 'traction':
                        readings[tick, 36] = message.wrench.force.x
            expected = trace.readings[:, robot].copy()
            expected[:, :24][expected[:, :24] > 0.1] = np.inf
            assert readings.tobytes() == expected.tobytes()


def test_a_bag_has_the_wires_types_and_qos_and_simulated_time(recorded):
    path, episode, _, hashes = recorded
    metadata = yaml.safe_load((path / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
    assert metadata['storage_identifier'] == 'mcap'
    assert metadata['relative_file_paths'] == [f'{path.name}.mcap']
    assert (
        metadata['duration']['nanoseconds'] in episode.ticks * 100_000_000 + np.arange(2) * 10**8
    )
    for entry in metadata['topics_with_message_count']:
        topic = entry['topic_metadata']
        assert topic['type_description_hash'] == hashes[topic['type']], topic['name']
        (qos,) = topic['offered_qos_profiles']
        assert qos['reliability'] == 'reliable'
        latched = topic['name'].endswith(('leds', 'robot_description', '/state', '/tf_static'))
        assert qos['durability'] == ('transient_local' if latched else 'volatile')


def test_a_bag_reads_back_with_mcap_ros2_support(recorded):
    path, _, trace, _ = recorded
    mcap = io.BytesIO((path / f'{path.name}.mcap').read_bytes())
    messages = read_ros2_messages(mcap, topics=['/predator/camera'])
    by_stamp = {
        (m.ros_msg.header.stamp.sec, m.ros_msg.header.stamp.nanosec): m.ros_msg.sectors
        for m in messages
    }
    sectors = np.array([by_stamp[stamp] for stamp in sorted(by_stamp)], np.float32)
    assert sectors.tobytes() == np.ascontiguousarray(trace.readings[:, 0, 24:32]).tobytes()


def run(starter, *arguments):
    process = starter(['coevo_manager', *map(str, arguments)])
    process.wait()
    assert 'Traceback' not in process.stderr_text
    return process


def make_environment_of(record):
    fields = record['environment']
    return Environment(**{**fields, 'perturbations': Perturbations(**fields['perturbations'])})


def test_record_reports_the_capture_and_replay_draws_it(starter, tmp_path):
    champions = [
        select_champion(text, species)
        for text, species in (('shipped/open', 'predator'), ('shipped/open:0:1', 'prey'))
    ]
    environment, _ = choose_environment(champions, {'episode_ticks': 200})
    trace = trace_pair(*(champion.genome for champion in champions), environment)
    bag = tmp_path / 'bag'
    options = '--prey', 'shipped/open:0:1', '--episode-ticks', 200
    process = run(starter, 'record', bag, *options)
    assert process.returncode == 0, process.stderr_text
    outcome = 'prey captured' if trace.captured else 'prey got away'
    assert f'{outcome} at tick {trace.ticks} of 200' in process.stdout_text
    assert 'episode_ticks is 200, in place of 1000 where the prey evolved' in process.stderr_text
    with BagReader(bag) as reader:
        record = json.loads(reader.attachment(EPISODE))
    assert make_environment_of(record) == environment
    for champion in champions:
        genome = np.array(record[champion.species]['genome'], np.float32)
        assert genome.tobytes() == champion.genome.tobytes()
        assert record[champion.species]['configuration'] == champion.origin.configuration

    png, gif = tmp_path / 'a.png', tmp_path / 'a.gif'
    assert run(starter, 'replay', bag, '--png', png, '--gif', gif, '--rate', 5).returncode == 0
    with Image.open(png) as image:
        image.load()
        assert len(set(np.asarray(image.convert('L')).ravel().tolist())) > 50
    with Image.open(gif) as image:
        assert image.n_frames == -(-trace.ticks // 5) + 1

    assert (
        str(champions[1]) in run(starter, 'replay', bag, '--png', tmp_path / 'b.png').stdout_text
    )

    again = run(starter, 'record', bag, *options)
    assert again.returncode == 2
    assert f'{bag} exists, expected a new name' in again.stderr_text
    again = run(starter, 'replay', bag, '--png', png)
    assert again.returncode == 2 and 'exists' in again.stderr_text


@pytest.mark.parametrize('suffix', ['mp4', 'webm'])
def test_replay_makes_films(recorded, starter, tmp_path, suffix):
    path, episode, _, _ = recorded
    film = tmp_path / f'a.{suffix}'
    process = run(starter, 'replay', path, '--film', film, '--rate', 5)
    assert process.returncode == 0, process.stderr_text
    frames = -(-episode.ticks // 5) + 1
    assert count_frames_and_secs(film) == (frames, pytest.approx(frames / 10, abs=0.1))


def test_replay_publishes_what_was_recorded(recorded, starter, client):
    path, episode, _, _ = recorded
    qos = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
    truth, scans = [], []
    client.node.create_subscription(Odometry, '/prey/ground_truth', truth.append, 1000)
    client.node.create_subscription(LaserScan, '/predator/proximity', scans.append, qos)
    process = starter(['coevo_manager', 'replay', path, '--rate', '2'])
    client.until(lambda: process.poll() is not None, 'the end of the replay')
    assert process.returncode == 0
    assert len(truth) > 10 and len(scans) > 10  # those from before the discovery are missing
    assert truth[-1].pose.pose.position.x == episode.poses[-1, 1, 0]


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (['record', 'new', '--predator', '/nowhere'], '/nowhere does not exist'),
        (['record', 'new', '--episode-ticks', '0'], 'episode_ticks is 0'),
        (['record', 'new', '--real-time-factor', '-1'], 'real_time_factor is -1.0'),
        (['record', 'new', '--real-time-factor', '1e-9'], 'expected 0 or a number from 0.001'),
        (
            ['record', 'new', '--namespace', 'a/b'],
            "namespace is 'a/b': namespace must be absolute",
        ),
        (['record', 'new', '--namespace', '//'], "namespace is '//': "),
        (['record', 'no/folder/new'], 'no/folder is no folder'),
        (['replay', '/nowhere'], '/nowhere is not the folder of a bag'),
        (['replay', '.', '--png', 'new.png'], '. is not a bag: it has no metadata.yaml'),
        (['replay', '.', '--rate', '0'], 'rate is 0.0'),
        (['replay', '.', '--gif', 'new.png'], 'expected one that ends in .gif'),
        (['replay', '.', '--film', 'new.avi'], 'expected one that ends in .mp4 or .webm'),
        (['export', 'shipped/open', '--species', 'prey'], 'nothing to write'),
        (['export', 'shipped/none', '--species', 'prey', '--yaml', 'x'], 'does not exist'),
        (['export', 'shipped/open', '--species', 'cat'], 'invalid choice'),
        (
            ['export', 'shipped/open', '--species', 'prey', '--header', 'no/x.h'],
            'No such file or directory',
        ),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(starter, tmp_path, arguments, sentence):
    executable = f'{ROOT}/ros2_ws/install/coevo_manager/lib/coevo_manager/{arguments[0]}'
    there = ['/bin/bash', '-c', 'cd "$0" && exec "$@"', tmp_path]
    process = starter([*there, executable, *arguments[1:]])
    assert process.wait() == 2
    assert sentence in process.stderr_text
    assert len(process.stderr_text.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_exported_parameters_drive_a_controller_as_they_are(starter, client, tmp_path):
    file = tmp_path / 'prey.yaml'
    arguments = ['--species', 'prey', '--yaml', file]
    assert run(starter, 'export', 'shipped/open', *arguments).returncode == 0
    ros_arguments = ['-r', '__ns:=/exported', '-p', 'autostart:=true', '--params-file', file]
    starter(['neuro_controller', 'controller', '--ros-args', *ros_arguments])
    names = ['genome', 'motor_map', 'max_wheel_speed', 'episode_ticks']
    values = client.call(GetParameters, '/exported/controller/get_parameters', names=names).values
    genome = read_snapshot(SHIPPED / 'open.npz').best('prey', 1)[0]
    assert np.array_equal(np.asarray(values[0].double_array_value, np.float32), genome)
    assert values[1].string_value == 'signed'
    assert values[2].double_value == 10.0
    assert values[3].integer_value == 1000
    state = client.call(GetState, '/exported/controller/get_state').current_state
    assert state.id == State.PRIMARY_STATE_ACTIVE


def test_the_action_plays_cancels_and_refuses(starter, client, tmp_path):
    process = starter(['coevo_manager', 'episodes'])
    action = GoalClient(client, RunEpisode, 'run_episode')
    feedback = []

    def send(ticks, **changes):
        goal = RunEpisode.Goal(predator=predator, prey=prey, **changes)
        goal.environment.obstacle = True
        goal.environment.episode_ticks = ticks
        return action.send(goal, lambda message: feedback.append(message.feedback))

    def result(handle):
        response = action.result(handle)
        return response.status, response.result

    predator, prey = next(pairs('obstacle'))
    environment = Environment(obstacle=True, episode_ticks=80)
    trace = trace_pair(predator, prey, environment)
    _, complexity = measure_pairs([predator], [prey], [0], [0], environment)
    bag = tmp_path / 'bag'
    running = send(80, bag=str(bag))
    status, refused = result(send(80))
    assert status == GoalStatus.STATUS_ABORTED and 'is being played' in refused.message
    status, answer = result(running)
    assert status == GoalStatus.STATUS_SUCCEEDED and answer.success
    assert (answer.capture_tick, answer.captured) == (trace.ticks, trace.captured)
    assert answer.prey_fitness == pytest.approx(trace.ticks / 80)
    assert answer.predator_complexity == pytest.approx(complexity[0, 0], rel=1e-5)
    assert answer.prey_complexity == pytest.approx(complexity[0, 1], rel=1e-5)
    assert feedback and feedback[-1].tick == trace.ticks
    assert feedback[-1].prey.x == trace.poses[-1, 1, 0]
    with BagReader(bag) as reader:
        record = json.loads(reader.attachment(EPISODE))
    assert record['environment'] == dataclasses.asdict(environment)
    assert record['prey']['genome'] == prey.tolist()

    status, answer = result(send(0))
    assert status == GoalStatus.STATUS_ABORTED and 'episode_ticks is 0' in answer.message
    status, answer = result(send(80, bag=str(bag)))
    assert status == GoalStatus.STATUS_ABORTED and 'exists' in answer.message

    feedback.clear()
    running = send(500_000, real_time_factor=2.0)
    client.until(lambda: feedback, 'feedback')
    action.cancel(running)
    status, answer = result(running)
    assert status == GoalStatus.STATUS_CANCELED and not answer.success
    process.send_signal(signal.SIGINT)
    assert process.wait() == 0


def test_an_interrupted_recording_leaves_nothing(starter, tmp_path):
    arguments = ['--real-time-factor', '1', '--episode-ticks', '500000']
    process = starter(['coevo_manager', 'record', tmp_path / 'bag', *arguments])
    wait_until(lambda: list(tmp_path.iterdir()), 'the start of the bag')
    process.send_signal(signal.SIGINT)
    assert process.wait() == 130
    assert process.stderr_text.splitlines()[-1] == 'record: interrupted, there is no bag'
    assert not list(tmp_path.iterdir())


def test_a_killed_simulator_ends_the_episode_with_a_sentence(starter, tmp_path):
    bag = tmp_path / 'bag'
    process = starter(
        ['coevo_manager', 'record', bag, '--real-time-factor', '1', '--episode-ticks', '500000']
    )
    family = psutil.Process(process.pid)

    def simulators():
        return [p for p in family.children(recursive=True) if 'simulator' in ' '.join(p.cmdline())]

    wait_until(lambda: simulators() and len(family.children()) == 3, 'three processes')
    others = family.children()
    simulators()[0].kill()
    assert process.wait() == 1
    assert 'a process of the episode ended' in process.stderr_text
    assert all(has_ended(process) for process in others)
    assert not bag.exists() and not list(tmp_path.glob('.bag*'))
