"""The processes that play episodes over topics: a simulator and two controllers."""

import os
import tempfile
from dataclasses import asdict

import numpy as np
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from marxbot_msgs.srv import Step
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from coevo_manager.core.episodes.numbering import episode_numbers
from marxbot_sim.core.parameters import ROBOTS
from node_runner import ask, make_executor, new_number, wait_until
from node_runner.children import Children

START_TIMEOUT = 60.0
"""How long the processes may take to start, s; the first time, kernels are compiled."""

TICK_TIMEOUT = 30.0
"""How long to wait for any progress, s."""


class EpisodeProcesses:
    """A simulator and two controllers in processes of their own, and a node that speaks to them.

    To be used as a context manager; leaving it ends the processes.

    Parameters
    ----------
    environment : Environment
    real_time_factor : float
        Simulated over real time; 0: lockstep.
    namespace : str or None
        Namespace of all topics and nodes; None takes one that nothing else uses.

    Attributes
    ----------
    node : rclpy.node.Node
    prefix : str
        The namespace, without a slash at its end.

    Raises
    ------
    TimeoutError, RuntimeError
        The processes did not start.
    """

    def __init__(self, environment, real_time_factor, namespace=None):
        self._environment = environment
        self._real_time_factor = real_time_factor
        self._namespace = namespace or f'/episode_{os.getpid()}_{id(self):x}'
        self.prefix = self._namespace.rstrip('/')

    def __enter__(self):
        self._log = tempfile.TemporaryFile('w+')
        self._children = Children()
        self.node = Node(
            'episode_player', namespace=self._namespace, start_parameter_services=False
        )
        self._executor = make_executor(self.node)
        try:
            self._start_simulator()
            for robot, speed in zip(ROBOTS, self._environment.max_wheel_speeds, strict=True):
                self._start_controller(robot, speed)
            self._find_services()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        self._children.end()
        self._executor.shutdown()
        self.node.destroy_node()
        self._log.close()

    # Start

    def _start_simulator(self):
        environment = self._environment
        perturbations = asdict(environment.perturbations)
        parameters = {
            'lockstep': self._real_time_factor == 0,
            'real_time_factor': self._real_time_factor or 1.0,
            'paused': True,
            'episode_ticks': environment.episode_ticks,
            'reliable_sensors': True,
            'physics': environment.physics,
            'arena.obstacle': environment.obstacle,
            'arena.wall_friction': environment.wall_friction,
            'arena.wall_contact': environment.wall_contact,
            'max_wheel_speed': max(environment.max_wheel_speeds),
            **{f'perturbations.{name}': value for name, value in perturbations.items()},
        }
        self._start('marxbot_sim', 'simulator', self._namespace, parameters)

    def _start_controller(self, robot, max_wheel_speed):
        parameters = {
            'trigger': 'sensors',
            'reliable_sensors': True,
            'sensor_timeout': TICK_TIMEOUT,
            'max_wheel_speed': max_wheel_speed,
            **self._environment.network_settings,
        }
        self._start('neuro_controller', 'controller', f'{self.prefix}/{robot}', parameters)

    def _start(self, package, executable, namespace, parameters):
        arguments = ['--ros-args', '-r', f'__ns:={namespace}']
        for topic in ('clock', 'tf', 'tf_static', 'diagnostics'):
            arguments += ['-r', f'/{topic}:={self.prefix}/{topic}']
        for name, value in parameters.items():
            text = str(value).lower() if isinstance(value, bool) else value
            if isinstance(value, float):
                text = f'{value!r}'
            arguments += ['-p', f'{name}:={text}']
        self._children.start(package, executable, arguments, stdout=self._log, stderr=self._log)

    def _find_services(self):
        def client(service_type, name):
            found = self.node.create_client(service_type, f'{self.prefix}/{name}')
            self.wait(found.service_is_ready, START_TIMEOUT, f'the start of {found.srv_name}')
            return found

        self._reset = client(Trigger, 'simulator/reset')
        self._pause = client(SetBool, 'simulator/pause')
        self._step = client(Step, 'simulator/step')
        self._simulator_parameters = client(SetParameters, 'simulator/set_parameters')
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

    @property
    def names(self):
        """Names and namespaces of the nodes."""
        controllers = [('controller', f'{self.prefix}/{robot}') for robot in ROBOTS]
        return [('simulator', self._namespace), *controllers]

    # Waiting

    def wait(self, condition, timeout, what):
        """Spin until a condition holds.

        Raises
        ------
        TimeoutError
            `what` did not happen in time.
        RuntimeError
            A process ended.
        """

        def holds():
            self._check()
            return condition()

        wait_until(self._executor, holds, timeout, what)

    def _check(self):
        if self._children.ended():
            self._log.seek(0)
            tail = self._log.read().strip().splitlines()[-1:]
            raise RuntimeError(f'a process of the episode ended: {" ".join(tail) or "no output"}')

    def _call(self, client, request):
        def send():
            self._check()
            return client.call_async(request)

        return ask(self._executor, send, START_TIMEOUT, f'an answer of {client.srv_name}')

    # What they are told

    def set_genomes(self, predator, prey):
        """Give the controllers their genomes, and the episode its random draws.

        Raises
        ------
        ValueError
            A genome is refused.
        """
        for client, genome in zip(self._parameters, (predator, prey), strict=True):
            genes = np.asarray(genome, np.float64).tolist()
            self._set(client, Parameter('genome', Parameter.Type.DOUBLE_ARRAY, genes))
        numbers = episode_numbers(np.array([prey, predator], np.float32)).astype(np.int64)
        draws = Parameter('episode_numbers', Parameter.Type.INTEGER_ARRAY, numbers.tolist())
        self._set(self._simulator_parameters, draws)

    def _set(self, client, parameter):
        request = SetParameters.Request(parameters=[parameter.to_parameter_msg()])
        result = self._call(client, request).results[0]
        if not result.successful:
            raise ValueError(result.reason)

    def activate(self):
        """Configure and activate both controllers."""
        for change, look in self._states:
            for transition, wanted in (
                (Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE),
                (Transition.TRANSITION_ACTIVATE, State.PRIMARY_STATE_ACTIVE),
            ):
                # Asked for again, it is refused; so the state tells whether it was done.
                self._call(change, ChangeState.Request(transition=Transition(id=transition)))
                if self._call(look, GetState.Request()).current_state.id != wanted:
                    raise RuntimeError(f'{change.srv_name} refused transition {transition}')

    def reset(self):
        """Begin an episode, paused."""
        self._call(self._pause, SetBool.Request(data=True))
        self._call(self._reset, Trigger.Request())

    def step(self, ticks):
        """Let the simulator make some ticks and pause again.

        Raises
        ------
        RuntimeError
            It refuses.
        """
        response = self._call(self._step, Step.Request(number=new_number(), ticks=ticks))
        if not response.success:
            raise RuntimeError(f'the simulator refused to step: {response.message}')
