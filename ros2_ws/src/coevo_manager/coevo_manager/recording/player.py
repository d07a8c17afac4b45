"""Playing episodes over topics: a simulator and two controllers in processes of their own."""

import math
import os
import tempfile
import time
from contextlib import suppress
from dataclasses import asdict, dataclass

import numpy as np
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from marxbot_msgs.msg import ArenaState
from marxbot_msgs.srv import Step
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from coevo_manager.core.environment import Environment
from coevo_manager.recording.recorder import COMMANDS, GROUND_TRUTH, STATE, Recorder
from marxbot_sim.core.drive import wheel_speeds
from marxbot_sim.core.parameters import TICK
from marxbot_sim.core.simulation import ROBOTS
from neuro_controller.core.genome import GENE_RANGE, GENES, OUTPUT_BIASES
from node_runner import ask, make_executor, new_number, wait_until
from node_runner.children import Children

START_TIMEOUT = 60.0
"""How long the processes may take to start, s; the first time, kernels are compiled."""

CHUNK = 10
"""Ticks that the simulator makes at a stretch in lockstep: their messages must fit the shared
memory of the transport (512 KB), or some would be lost."""

TICK_TIMEOUT = 30.0
"""How long to wait for any progress, s."""

STANDING = np.where(np.arange(GENES) == OUTPUT_BIASES + 1, -GENE_RANGE, 0.0)
"""Genome of a robot that all but stands still: only the bias of the drive is not zero."""

ATTEMPTS = 3
"""How often an episode is played until every message of it has been received."""


@dataclass(frozen=True)
class Episode:
    """An episode as it was seen on topics.

    Attributes
    ----------
    ticks : int
        Tick at which it ended.
    captured : bool
        Whether the prey was captured then.
    poses : float32 array, shape (ticks + 1, 2, 3)
        x and y in m and heading in rad of predator and prey, from the ground truth.
    wheels : float32 array, shape (ticks, 2, 2)
        Commanded speeds of left and right wheel, rad/s.
    seconds : float
        Real time it took, s.
    """

    ticks: int
    captured: bool
    poses: np.ndarray
    wheels: np.ndarray
    seconds: float


class EpisodePlayer:
    """Starts a simulator and two controllers and plays episodes with them, one after the other.

    To be used as a context manager; leaving it ends the processes.

    Parameters
    ----------
    environment : Environment
    real_time_factor : float
        Simulated over real time; 0 plays in lockstep, as fast as possible, and then every episode
        equals the headless one bit for bit.
    namespace : str
        Namespace of all topics and nodes; None takes one that nothing else uses.
    node_name : str
        Name of this side's node.

    Raises
    ------
    ValueError
        The pace is out of its range, or a pair is to play several episodes.
    TimeoutError
        The processes did not start.
    """

    def __init__(
        self,
        environment=Environment(),
        real_time_factor=0.0,
        namespace=None,
        node_name='episode_player',
    ):
        if not 0 <= real_time_factor < math.inf:
            raise ValueError(
                f'real_time_factor is {real_time_factor}, expected a finite number, 0 or more'
            )
        if environment.repetitions != 1:
            raise ValueError(f'repetitions is {environment.repetitions}, expected 1 over topics')
        self._environment = environment
        self._lockstep = real_time_factor == 0
        self._pace = real_time_factor or 1.0
        self.namespace = f'/episode_{os.getpid()}_{id(self):x}' if namespace is None else namespace
        self._prefix = self.namespace.rstrip('/')
        self._node_name = node_name

    def __enter__(self):
        self._log = tempfile.TemporaryFile('w+')
        self._children = Children()
        self._node = Node(
            self._node_name, namespace=self.namespace, start_parameter_services=False
        )
        self._executor = make_executor(self._node)
        try:
            self._start_processes()
            self._make_clients()
            self._wait_for_servers()
            self._recorder = None
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        self._children.end()
        self._executor.shutdown()
        self._node.destroy_node()
        self._log.close()

    # Processes

    def _start_processes(self):
        remaps = []
        for topic in ('clock', 'tf', 'tf_static', 'diagnostics'):
            remaps += ['-r', f'/{topic}:={self._prefix}/{topic}']
        environment = self._environment
        self._start(
            'marxbot_sim',
            'simulator',
            self.namespace,
            remaps,
            {
                'lockstep': self._lockstep,
                'real_time_factor': self._pace,
                'paused': True,
                'episode_ticks': environment.episode_ticks,
                'physics': environment.physics,
                'arena.obstacle': environment.obstacle,
                'arena.wall_friction': environment.wall_friction,
                'arena.wall_contact': environment.wall_contact,
                'max_wheel_speed': max(environment.max_wheel_speeds),
                **{
                    f'perturbations.{name}': value
                    for name, value in asdict(environment.perturbations).items()
                },
            },
        )
        for robot, speed in zip(ROBOTS, environment.max_wheel_speeds, strict=True):
            self._start(
                'neuro_controller',
                'controller',
                f'{self._prefix}/{robot}',
                remaps,
                {
                    'trigger': 'sensors',
                    'sensor_timeout': TICK_TIMEOUT,
                    'max_wheel_speed': speed,
                    **environment.network_settings,
                },
            )

    def _start(self, package, executable, namespace, remaps, parameters):
        arguments = ['--ros-args', '-r', f'__ns:={namespace or "/"}', *remaps]
        for name, value in parameters.items():
            text = str(value).lower() if isinstance(value, bool) else value
            if isinstance(value, float):
                text = f'{value!r}'
            arguments += ['-p', f'{name}:={text}']
        self._children.start(package, executable, arguments, stdout=self._log, stderr=self._log)

    def _check_processes(self):
        if self._children.ended():
            self._log.seek(0)
            tail = self._log.read().strip().splitlines()[-1:]
            raise RuntimeError(f'a process of the episode ended: {" ".join(tail) or "no output"}')
        return True

    def _wait(self, condition, timeout, what):
        wait_until(self._executor, lambda: self._check_processes() and condition(), timeout, what)

    def _call(self, client, request):
        def send():
            self._check_processes()
            return client.call_async(request)

        return ask(self._executor, send, START_TIMEOUT, f'an answer of {client.srv_name}')

    def _make_clients(self):
        def client(service_type, name):
            return self._node.create_client(service_type, f'{self._prefix}/{name}')

        self._reset = client(Trigger, 'simulator/reset')
        self._step = client(Step, 'simulator/step')
        self._parameters = [
            client(SetParameters, f'{robot}/controller/set_parameters') for robot in ROBOTS
        ]
        self._states = [
            tuple(
                client(kind, f'{robot}/controller/{name}')
                for kind, name in ((ChangeState, 'change_state'), (GetState, 'get_state'))
            )
            for robot in ROBOTS
        ]

    def _wait_for_servers(self):
        for client in (self._reset, self._step, *self._parameters, *sum(self._states, ())):
            self._wait(client.service_is_ready, START_TIMEOUT, f'the start of {client.srv_name}')

    # Episodes

    def play(self, predator, prey, bag=None, on_progress=lambda tick, poses: None):
        """Play one episode.

        Parameters
        ----------
        predator, prey : array_like, shape (442,)
            Genomes.
        bag : BagWriter or None
            Where to write every message.
        on_progress : callable
            Called now and then with the tick and the poses, shape (2, 3).

        Returns
        -------
        Episode

        Raises
        ------
        ValueError
            A genome is refused by its controller.
        TimeoutError, RuntimeError
            A process ended or hangs.
        """
        self._set_genomes(predator, prey)
        if self._recorder is None:
            self._activate()
            self._recorder = self._make_recorder()
        for _ in range(ATTEMPTS):
            episode = self._play_once(on_progress)
            if self._complete():
                if bag is not None:
                    self._recorder.save(bag)
                return episode
        raise RuntimeError(
            f'messages of the episode were lost in {ATTEMPTS} attempts: {self._recorder.counts}'
        )

    def measure(self, predator, prey):
        """Play one episode that nobody records, on a new player; return its ticks per second."""
        self._set_genomes(predator, prey)
        self._activate()
        states = []
        topic = f'{self._prefix}{STATE}'
        subscription = self._node.create_subscription(ArenaState, topic, states.append, 1000)
        length = self._environment.episode_ticks

        def begun():
            states.clear()
            self._call(self._reset, Trigger.Request())
            with suppress(TimeoutError):
                self._wait(lambda: states, 1.0, 'the state')
            return states

        self._wait(begun, START_TIMEOUT, 'the start of the episode')
        started = time.monotonic()
        self._call(self._step, Step.Request(number=new_number(), ticks=length))
        self._wait(lambda: states[-1].ended, TICK_TIMEOUT + length, 'the end of the episode')
        seconds = time.monotonic() - started
        self._node.destroy_subscription(subscription)
        return states[-1].tick / seconds

    def _set_genomes(self, *genomes):
        for client, genome in zip(self._parameters, genomes, strict=True):
            genome = Parameter(
                'genome', Parameter.Type.DOUBLE_ARRAY, np.asarray(genome, np.float64).tolist()
            )
            request = SetParameters.Request(parameters=[genome.to_parameter_msg()])
            result = self._call(client, request).results[0]
            if not result.successful:
                raise ValueError(result.reason)

    def _activate(self):
        for change, look in self._states:
            for transition, wanted in (
                (Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE),
                (Transition.TRANSITION_ACTIVATE, State.PRIMARY_STATE_ACTIVE),
            ):
                # Asked for again, it is refused; so the state tells whether it was done.
                self._call(change, ChangeState.Request(transition=Transition(id=transition)))
                if self._call(look, GetState.Request()).current_state.id != wanted:
                    raise RuntimeError(f'{change.srv_name} refused transition {transition}')

    def _make_recorder(self):
        recorder = Recorder(self._node, self._prefix)
        nodes = [('simulator', self.namespace)]
        nodes += [('controller', f'{self._prefix}/{robot}') for robot in ROBOTS]
        self._wait(lambda: recorder.subscribe(nodes), START_TIMEOUT, 'the discovery of all topics')
        return recorder

    def _play_once(self, on_progress):
        recorder = self._recorder
        deadline = time.monotonic() + TICK_TIMEOUT
        while True:  # the simulator may match our subscriptions later than we match its publishers
            recorder.clear()
            self._call(self._reset, Trigger.Request())
            try:
                self._wait(recorder.begun, 1.0, 'the start of the episode')
                break
            except TimeoutError:
                if time.monotonic() > deadline:
                    raise
        started = time.monotonic()
        length = self._environment.episode_ticks
        while not recorder.state.ended:
            tick = recorder.state.tick
            ticks = min(CHUNK, length - tick) if self._lockstep else length - tick
            response = self._call(self._step, Step.Request(number=new_number(), ticks=ticks))
            if not response.success:
                raise RuntimeError(f'the simulator refused to step: {response.message}')
            self._follow(tick + ticks, on_progress)
        seconds = time.monotonic() - started
        with suppress(TimeoutError):  # what is missing then is told by the caller's check
            self._wait(self._complete, 1.0, 'the last messages')
        return self._episode(seconds)

    def _follow(self, target, on_progress):
        """Wait until the simulator has made its ticks."""
        state = self._recorder.state
        while not state.ended and state.tick < target:
            before = state.tick
            wanted = target if self._lockstep else before + 1
            self._wait(
                lambda wanted=wanted: (
                    self._recorder.state.ended or self._recorder.state.tick >= wanted
                ),
                TICK_TIMEOUT / min(self._pace, 1.0),
                f'tick {wanted} of the episode',
            )
            state = self._recorder.state
            poses = [_pose(self._recorder.last(topic).pose.pose) for topic in GROUND_TRUTH]
            on_progress(state.tick, np.array(poses))

    def _complete(self):
        return self._recorder.complete(self._recorder.state.tick, commands=self._lockstep)

    def _episode(self, seconds):
        state = self._recorder.state
        poses = np.empty((state.tick + 1, 2, 3), np.float32)
        wheels = np.zeros((state.tick, 2, 2), np.float32)
        commands = [{}, {}]
        for topic, message in self._recorder.decoded(*GROUND_TRUTH, *COMMANDS):
            tick = _tick(message.header.stamp)
            if topic in GROUND_TRUTH:
                poses[tick, GROUND_TRUTH.index(topic)] = _pose(message.pose.pose)
            else:
                twist = message.twist
                speeds, _ = wheel_speeds(twist.linear.x, twist.angular.z)
                commands[COMMANDS.index(topic)][tick] = speeds
        for robot, sent in enumerate(commands):
            for tick in range(state.tick):
                wheels[tick, robot] = sent.get(tick, wheels[tick - 1, robot] if tick else 0)
        return Episode(state.tick, state.captured, poses, wheels, seconds)


def _tick(stamp):
    """Return the tick of a stamp; the simulator's clock starts at one tick."""
    return round((stamp.sec + stamp.nanosec * 1e-9) / TICK) - 1


def _pose(pose):
    """Return x, y and heading of a geometry_msgs/Pose."""
    return pose.position.x, pose.position.y, 2 * math.atan2(pose.orientation.z, pose.orientation.w)
