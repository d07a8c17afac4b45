"""What is damaged: every kind of file that a command reads, and the command that reads it.

A command runs until it would begin to work: its readers are the real ones, its exit code and its
error are what a user gets.
"""

import contextlib
import hashlib
import io
import json
import multiprocessing
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import ros2
import ros2_launch
from coevo_msgs.action import Evolve

from coevo_manager import export
from coevo_manager.analysis import command as analyze
from coevo_manager.analysis import pipeline
from coevo_manager.analysis.play import tournament
from coevo_manager.analysis.play.tournament import Store
from coevo_manager.core.evolution import Evolution, load_configuration
from coevo_manager.core.evolution.sessions import read_sessions
from coevo_manager.recording import replay
from coevo_manager.recording.bag_writer import BagWriter
from coevo_manager.runs import campaign, evolve, jobs, manager
from neuro_controller.core.champions import SHIPPED
from node_runner.start import start_ros

CHECKED_BAGS = frozenset({'bag.mcap'})

Tell = Callable[[str], object]
"""Takes what a command made of its files, to be compared with what it makes of damaged ones."""

TINY = {
    'algorithm': 'hall_of_fame',
    'population': 8,
    'selected': 2,
    'phases': 3,
    'generations': 5,
    'swap_generations': 5,
    'snapshot_generations': 5,
    'episode_ticks': 50,
    'mutation_rate': 1e-05,
}


@dataclass(frozen=True)
class Subject:
    """A kind of file.

    Attributes
    ----------
    name : str
    folder : Path
        All files of the command.
    file : str
        The file, or folder of files, in it that is damaged.
    command : callable (folder, tell)
        Runs the command; returns its exit code.
    vouched : set of str
        Names of files whose damage must be noticed: what is in them is hashed.
    """

    name: str
    folder: Path
    file: str
    command: Callable[[Path, Tell], int]
    vouched: frozenset[str] = frozenset()


def _digest(*arrays) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _until(module, name: str, then: Callable = lambda *_: None):
    """Let a command end, with exit code 0, where it calls a function of its module."""

    def end(*arguments, **_):
        then(*arguments)
        sys.exit(0)

    setattr(module, name, end)


def _evolve(*options):
    def command(folder, tell):
        def planned(plan, *_):
            tell(json.dumps(plan.configuration.as_dict()))

        evolve.start_ros = lambda _: None
        _until(evolve, '_evolve', planned)
        return evolve.main([option.format(folder) for option in options])

    return command


def _campaign(folder, tell):
    read_campaign = jobs.read_campaign

    def read(path):
        found = read_campaign(path)
        tell(repr([job.configuration for job in found.jobs]))
        return found

    jobs.read_campaign = read
    _until(campaign, 'own_cluster')
    return campaign.main([str(folder / 'campaign.yaml')])


def _analyze(folder, tell):
    def collected(runs, *_):
        for run in runs:
            tables = [run.table(name).to_csv() for name in ('generations', 'phases')]
            found = [run.snapshot(g) for g in run.snapshots]
            arrays = [a for s in found for a in (s.predators, s.prey, s.fitness)]
            tell(''.join(tables) + _digest(*arrays) + repr(run.configuration) + run.versions)

    pipeline.Kernel = lambda: SimpleNamespace(version='fuzz')
    _until(pipeline, 'collect', collected)
    return analyze.main([str(folder / 'run'), '--out', 'out'])


def _export(source):
    def command(folder, tell):
        name = str(folder / source)
        code = export.main([name, '--species', 'prey', '--yaml', 'g.yaml', '--header', 'g.h'])
        if not code:
            tell(Path('g.yaml').read_text())
        return code

    return command


def _replay(folder, tell):
    from coevo_manager.recording import drawing

    drawing.draw_trajectories = lambda track, *_: tell(repr(track)) and b''
    return replay.main([str(folder / 'bag'), '--png', 'chase.png'])


def _launch(folder, tell):
    ros2_launch._run = lambda nodes: tell(repr(nodes)) and 0
    return ros2.main(['launch', str(folder / 'demo.launch.xml')])


def _parameters(folder, tell):
    start_ros(['controller', '--ros-args', '--params-file', str(folder / 'controller.yaml')])
    return 0


def _goal(folder, tell):
    file = folder / 'goal.yaml'  # it stands for the text of a message
    text = file.read_bytes().decode('utf-8', 'replace') if file.is_file() else ''
    try:
        plan = manager._read_goal(Evolve.Goal(configuration=text.replace('\0', ''), out='goal'))
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    tell(repr(plan.configuration))
    return 0


def _store(folder, tell):
    store = Store(folder / 'cache', 'fuzz')
    arrays = store.load('digest')
    block = SimpleNamespace(predators=range(8), prey=range(8), complexity=True)
    if arrays is None or not tournament._fits(arrays, block):
        print('played again', file=sys.stderr)
        return 2
    tell(_digest(arrays['ticks'], arrays['complexity']))
    return 0


def _sessions(folder, tell):
    tell(repr(read_sessions(folder / 'run')))
    return 0


def make(place: Path, only: list[str]) -> list[Subject]:
    """Make the files, in a process of their own, and return the subjects that are wanted."""
    files = multiprocessing.get_context('fork').Process(target=_make_files, args=(place,))
    files.start()
    files.join()
    if files.exitcode:
        raise RuntimeError('the files could not be made')
    run = place / 'runs'
    logs = frozenset({'generations.csv', 'phases.csv'})
    sealed = frozenset(path.name for path in (run / 'run' / 'snapshots').iterdir())
    stored = str(next((place / 'store').rglob('*.npz')).relative_to(place / 'store'))
    texts = place / 'texts'
    subjects = [
        Subject('evolve --config YAML', texts, 'c.yaml', _evolve('--config', '{}/c.yaml')),
        Subject('evolve --config JSON', texts, 'c.json', _evolve('--config', '{}/c.json')),
        Subject('its run.json', run, 'run/run.json', _evolve('--config', '{}/run/run.json')),
        Subject('campaign file', texts, 'campaign.yaml', _campaign),
        Subject('goal of the manager', texts, 'goal.yaml', _goal),
        Subject('run.json', run, 'run/run.json', _analyze),
        Subject('generations.csv', run, 'run/generations.csv', _analyze, logs),
        Subject('phases.csv', run, 'run/phases.csv', _analyze, logs),
        Subject('snapshots', run, 'run/snapshots', _analyze, sealed),
        Subject('run folder, resumed', run, 'run', _evolve('--resume', '{}/run')),
        Subject('checkpoints, resumed', run, 'run/checkpoint', _evolve('--resume', '{}/run')),
        Subject('sessions.json', run, 'run/sessions.json', _sessions),
        Subject('genome of a run', run, 'run/snapshots', _export('run')),
        Subject('genome file', texts, 'genome.npz', _export('genome.npz')),
        Subject('stored results', place / 'store', stored, _store),
        Subject('bag: metadata.yaml', place / 'bags', 'bag/metadata.yaml', _replay),
        Subject('bag: messages', place / 'bags', 'bag/bag.mcap', _replay, CHECKED_BAGS),
        Subject('launch file', texts, 'demo.launch.xml', _launch),
        Subject('parameter file', texts, 'controller.yaml', _parameters),
    ]
    return [s for s in subjects if not only or any(word in s.name for word in only)]


class Dice:
    """An evaluator that throws dice: what is in the files is nothing to their readers."""

    def __init__(self, environment) -> None:
        self.environment = environment
        self.slots = 1
        self.longest_lineage = 100
        self._rng = np.random.default_rng(1)
        self._thrown: list[tuple[int, np.ndarray]] = []

    def submit(self, work) -> int:
        """Throw the capture ticks of a batch or a lineage."""
        ticket = int(self._rng.integers(2**62))
        longest = self.environment.episode_ticks
        ticks = self._rng.integers(1, longest, len(work), np.int32, endpoint=True)
        self._thrown.append((ticket, ticks))
        return ticket

    def collect(self, timeout=None) -> tuple[int, np.ndarray] | None:
        """Hand over what was thrown first."""
        return self._thrown.pop(0) if self._thrown else None

    def cancel(self) -> None:
        """Forget all work."""
        self._thrown.clear()


def _make_files(place: Path) -> None:
    configuration = load_configuration(TINY)
    Evolution(configuration, Dice(configuration.make_environment()), place / 'runs' / 'run').run()
    texts = place / 'texts'
    texts.mkdir()
    values = load_configuration({}).as_dict()
    (texts / 'c.json').write_text(json.dumps(values, indent='\t'))
    lines = [f'{name}: {json.dumps(value)}' for name, value in values.items()]
    (texts / 'c.yaml').write_text('# a run\n' + '\n'.join(lines) + '\n')
    (texts / 'goal.yaml').write_text('{population: 32, selected: 8, mutation_rate: 1e-05}')
    (texts / 'campaign.yaml').write_text(
        'out: runs\npreset: quick\nconfiguration: &shared\n  population: 32\n  phases: 200\n'
        'conditions:\n  standard: {}\n  few: {<<: *shared, selected: 2}\n'
        'environments: [open, obstacle]\nseeds: [1, 2, 3]\nretries: 1\n'
    )
    (texts / 'demo.launch.xml').write_text(LAUNCH)
    shutil.copy(SHIPPED / 'open.npz', texts / 'genome.npz')
    settings = str(texts / 'controller.yaml')
    with contextlib.redirect_stdout(io.StringIO()):
        export.main([str(texts / 'genome.npz'), '--species', 'prey', '--yaml', settings])
    rng = np.random.default_rng(1)
    store = Store(place / 'store' / 'cache', 'fuzz')
    store.save(
        'digest',
        ticks=rng.integers(1, 50, (8, 8), np.int32),
        complexity=rng.random((8, 8, 2), np.float32),
    )
    (place / 'bags').mkdir()
    _make_bag(place / 'bags' / 'bag')


LAUNCH = """<launch>
  <arg name="rate" default="1.0" description="pace"/>
  <arg name="obstacle" default="false"/>
  <node pkg="marxbot_sim" exec="simulator" name="sim">
    <param name="real_time_factor" value="$(var rate)"/>
    <param name="obstacle" value="$(var obstacle)"/>
  </node>
  <group if="$(var obstacle)">
    <push_ros_namespace namespace="prey"/>
    <node pkg="neuro_controller" exec="controller"><remap from="a" to="b"/></node>
  </group>
</launch>
"""


def _make_bag(path: Path) -> None:
    """Write a bag of a short episode, in which the robots drive straight on."""
    from marxbot_msgs.msg import ArenaState
    from nav_msgs.msg import Odometry
    from rclpy.qos import QoSProfile
    from rclpy.serialization import serialize_message

    with BagWriter(path) as bag:
        bag.add_topic('/arena/state', 'marxbot_msgs/msg/ArenaState', QoSProfile(depth=1))
        for robot in ('predator', 'prey'):
            bag.add_topic(f'/{robot}/ground_truth', 'nav_msgs/msg/Odometry', QoSProfile(depth=1))
        for tick in range(40):
            state = ArenaState(size=3.0)
            state.header.stamp.sec = tick
            bag.write('/arena/state', serialize_message(state))
            for side, robot in ((-1, 'predator'), (1, 'prey')):
                odometry = Odometry()
                odometry.header.stamp.sec = tick
                odometry.pose.pose.position.x = side * (1 - tick / 50)
                odometry.pose.pose.orientation.w = 1.0
                bag.write(f'/{robot}/ground_truth', serialize_message(odometry))
