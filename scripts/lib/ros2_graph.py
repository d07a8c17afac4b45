"""The commands of ``ros2`` that ask running nodes: node, topic, param, lifecycle, service."""

import argparse
import functools
import statistics
import sys
import time
from array import array
from collections import deque
from collections.abc import Callable
from importlib import import_module
from typing import Any, NoReturn

import numpy as np
import yaml
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter, get_parameter_value, parameter_value_to_python
from rclpy.qos import QoSProfile, ReliabilityPolicy

from node_runner import ask, make_executor, new_number, run_ros, wait_until

PATIENCE = 10.0
"""How long a node, a topic's publisher or an answer may take to come, s."""

LOOK = 1.0
"""How long nothing new may be discovered before a list is held to be complete, s."""


class Graph:
    """A node of the command's own, and what it asks of others."""

    def __init__(self) -> None:
        self.node = Node('ros2_command', start_parameter_services=False, enable_rosout=False)
        self._executor = make_executor(self.node)

    def wait(self, condition: Callable[[], Any], what: str, timeout: float = PATIENCE) -> None:
        """Spin until a condition holds; TimeoutError naming `what` if it does not."""
        wait_until(self._executor, condition, timeout, what)

    def look(self) -> None:
        """Discover what there is."""
        seen, quiet_since = -1, time.monotonic()

        def complete() -> bool:
            nonlocal seen, quiet_since
            there = len(self.node.get_node_names()) + len(self.node.get_topic_names_and_types())
            if there != seen:
                seen, quiet_since = there, time.monotonic()
            return time.monotonic() - quiet_since > LOOK

        self.wait(complete, 'the end of discovery')

    def call(self, service_type: Any, name: str, request: Any) -> Any:
        """Return the answer of a service."""
        client = self.node.create_client(service_type, name)
        self.wait(client.service_is_ready, f'the start of {name}')
        if getattr(request, 'number', None) == 0:
            request.number = new_number()
        send = functools.partial(client.call_async, request)
        return ask(self._executor, send, PATIENCE, f'an answer of {name}')

    def type_of(self, topic: str) -> str:
        """Return the type of a topic's messages, once somebody publishes it."""
        self.wait(lambda: self._publishers(topic), f'a publisher of {topic}')
        return min(info.topic_type for info in self._publishers(topic))

    def _publishers(self, topic: str) -> list[Any]:
        return self.node.get_publishers_info_by_topic(topic)

    def listen(self, topic: str, type_name: str | None, take: Callable[[Any], None]) -> None:
        """Hear a topic with what its publishers offer.

        Where the type is given, a publisher may take any time to come. It is waited for all the
        same: what was latched is only heard by those who ask for it.
        """
        kind = interface(type_name or self.type_of(topic))
        self.wait(lambda: self._publishers(topic), f'a publisher of {topic}', float('inf'))
        offers = [info.qos_profile for info in self._publishers(topic)]
        best_effort = any(o.reliability == ReliabilityPolicy.BEST_EFFORT for o in offers)
        qos = QoSProfile(depth=100)
        if best_effort:
            qos.reliability = ReliabilityPolicy.BEST_EFFORT
        if len({o.durability for o in offers}) == 1:
            qos.durability = offers[0].durability
        self.node.create_subscription(kind, topic, take, qos)


def interface(name: str) -> Any:
    """Return the class of a type such as ``std_msgs/msg/String`` or ``std_srvs/srv/Trigger``."""
    try:
        package, folder, kind = name.split('/')
        return getattr(import_module(f'{package}.{folder}'), kind)
    except (ValueError, ImportError, AttributeError):
        raise ValueError(f'the type {name!r} is not known') from None


def plain(value: Any) -> Any:
    """Return a message as dicts, lists and numbers."""
    if hasattr(value, 'get_fields_and_field_types'):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, np.ndarray | array):
        return value.tolist()
    if isinstance(value, bytes):
        return list(value)
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    return value


def fill(message: Any, values: Any) -> Any:
    """Set fields of a message from a mapping; ValueError names what does not fit."""
    fields = message.get_fields_and_field_types()
    if not isinstance(values, dict):
        raise ValueError(f'{values!r} was given, expected a mapping of {", ".join(fields)}')
    for name, value in values.items():
        if name not in fields:
            raise ValueError(f'there is no field {name!r}, expected one of {", ".join(fields)}')
        old = getattr(message, name)
        if isinstance(old, float) and type(value) is int:
            value = float(value)
        try:
            if hasattr(old, 'get_fields_and_field_types'):
                fill(old, value)
                continue
            if isinstance(old, bool | int | float | str) and type(value) is not type(old):
                raise TypeError
            setattr(message, name, value)
        except (AssertionError, TypeError, OverflowError):
            raise ValueError(f'{name} is {value!r}, expected {fields[name]}') from None
    return message


# Commands


def node_list(graph: Graph, options: argparse.Namespace) -> int:
    """Print the names of all nodes."""
    graph.look()
    names = graph.node.get_node_names_and_namespaces()
    full = {f'{namespace.rstrip("/")}/{name}' for name, namespace in names}
    print(*sorted(full - {graph.node.get_fully_qualified_name()}), sep='\n')
    return 0


def topic_list(graph: Graph, options: argparse.Namespace) -> int:
    """Print the names of all topics, with their types if asked for."""
    graph.look()
    for name, types in sorted(graph.node.get_topic_names_and_types()):
        print(f'{name} [{", ".join(types)}]' if options.show_types else name)
    return 0


def topic_echo(graph: Graph, options: argparse.Namespace) -> int:
    """Print messages as YAML."""
    heard = []

    def take(message: Any) -> None:
        for part in options.field.split('.') if options.field else ():
            message = getattr(message, part)
        text = yaml.safe_dump(plain(message), sort_keys=False)
        print(text.removesuffix('...\n') + '---', flush=True)
        heard.append(True)

    graph.listen(options.topic, options.type, take)
    graph.wait(lambda: options.once and heard, f'a message on {options.topic}', float('inf'))
    return 0


def topic_hz(graph: Graph, options: argparse.Namespace) -> int:
    """Print once a second how often messages come."""
    times: deque[float] = deque(maxlen=options.window)
    graph.listen(options.topic, None, lambda _: times.append(time.monotonic()))
    while True:
        end = time.monotonic() + 1
        graph.wait(lambda end=end: time.monotonic() > end, 'the end of a second')
        gaps = [after - before for before, after in zip(times, list(times)[1:], strict=False)]
        if gaps:
            print(f'average rate: {1 / statistics.fmean(gaps):.3f}')
            print(
                f'\tmin: {min(gaps):.3f}s max: {max(gaps):.3f}s '
                f'std dev: {statistics.pstdev(gaps):.5f}s window: {len(times)}',
                flush=True,
            )


def service_call(graph: Graph, options: argparse.Namespace) -> int:
    """Call a service and print its answer."""
    kind = interface(options.type)
    request = fill(kind.Request(), yaml.safe_load(options.values) or {})
    print(f'requester: making request: {request!r}\n')
    print(f'response:\n{graph.call(kind, options.service, request)!r}\n')
    return 0


_VALUES = {
    Parameter.Type.BOOL: 'Boolean value is',
    Parameter.Type.INTEGER: 'Integer value is',
    Parameter.Type.DOUBLE: 'Double value is',
    Parameter.Type.STRING: 'String value is',
    Parameter.Type.BYTE_ARRAY: 'Byte values are',
    Parameter.Type.BOOL_ARRAY: 'Boolean values are',
    Parameter.Type.INTEGER_ARRAY: 'Integer values are',
    Parameter.Type.DOUBLE_ARRAY: 'Double values are',
    Parameter.Type.STRING_ARRAY: 'String values are',
}


def param_get(graph: Graph, options: argparse.Namespace) -> int:
    """Print a parameter."""
    request = GetParameters.Request(names=[options.parameter])
    values = graph.call(GetParameters, f'{options.node}/get_parameters', request).values
    if not values or Parameter.Type(values[0].type) == Parameter.Type.NOT_SET:
        print('Parameter not set')
        return 1
    value = parameter_value_to_python(values[0])
    print(f'{_VALUES[Parameter.Type(values[0].type)]}: {plain(value)}')
    return 0


def param_set(graph: Graph, options: argparse.Namespace) -> int:
    """Set a parameter."""
    request = SetParameters.Request()
    parameter = Parameter(options.parameter).to_parameter_msg()
    parameter.value = get_parameter_value(options.value)
    request.parameters = [parameter]
    result = graph.call(SetParameters, f'{options.node}/set_parameters', request).results[0]
    if result.successful:
        print('Set parameter successful')
        return 0
    print(f'Setting parameter failed: {result.reason}')
    return 1


def lifecycle_get(graph: Graph, options: argparse.Namespace) -> int:
    """Print the state of a lifecycle node."""
    state = graph.call(GetState, f'{options.node}/get_state', GetState.Request()).current_state
    print(f'{state.label} [{state.id}]')
    return 0


def lifecycle_set(graph: Graph, options: argparse.Namespace) -> int:
    """Let a lifecycle node make a transition."""
    service = f'{options.node}/get_available_transitions'
    answer = graph.call(GetAvailableTransitions, service, GetAvailableTransitions.Request())
    available = [description.transition for description in answer.available_transitions]
    for description in answer.available_transitions:
        transition = description.transition
        if options.transition in (transition.label, str(transition.id)):
            request = ChangeState.Request(transition=transition)
            done = graph.call(ChangeState, f'{options.node}/change_state', request).success
            if not done:  # it is refused too where it was done and only the answer was lost
                state = graph.call(GetState, f'{options.node}/get_state', GetState.Request())
                done = state.current_state.id == description.goal_state.id
            if done:
                print('Transitioning successful')
                return 0
            print('Transitioning failed')
            return 1
    print('Unknown transition requested, available ones are:')
    for transition in available:
        print(f'- {transition.label} [{transition.id}]')
    return 1


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise ValueError(f'{self.prog.removeprefix("ros2 ")}: {message}')


_ARGUMENTS: dict[str, dict[str, Any]] = {
    'topic': {},
    'type': {'help': 'such as std_msgs/msg/String'},
    'optional type': {'help': 'such as std_msgs/msg/String; by default that of its publisher'},
    'service': {},
    'values': {'nargs': '?', 'default': '{}', 'help': 'of the request, as YAML'},
    'node': {'help': 'its full name, such as /predator/controller'},
    'parameter': {},
    'value': {'help': 'as YAML'},
    'transition': {'help': 'such as configure, activate, deactivate'},
    '--once': {'action': 'store_true', 'help': 'end after one message'},
    '--field': {'help': 'print this part of the messages only, such as pose.pose.position'},
    '--show-types': {'action': 'store_true', 'help': 'with their types'},
    '--window': {'type': int, 'default': 10000, 'help': 'messages to average over'},
}

COMMANDS: dict[str, dict[str, tuple[Callable, tuple[str, ...]]]] = {
    'node': {'list': (node_list, ())},
    'topic': {
        'list': (topic_list, ('--show-types',)),
        'echo': (topic_echo, ('topic', 'optional type', '--once', '--field')),
        'hz': (topic_hz, ('topic', '--window')),
    },
    'service': {'call': (service_call, ('service', 'type', 'values'))},
    'param': {
        'get': (param_get, ('node', 'parameter')),
        'set': (param_set, ('node', 'parameter', 'value')),
    },
    'lifecycle': {
        'get': (lifecycle_get, ('node',)),
        'set': (lifecycle_set, ('node', 'transition')),
    },
}


def carry_out(command: str, arguments: list[str]) -> int:
    """Carry out a command such as ``topic`` with its verb and arguments."""
    parser = _Parser(prog=f'ros2 {command}')
    verbs = parser.add_subparsers(required=True, metavar='VERB')
    for verb, (work, names) in COMMANDS[command].items():
        part = verbs.add_parser(verb, help=work.__doc__, description=work.__doc__)
        part.set_defaults(work=work)
        for name in names:
            settings = _ARGUMENTS[name]
            if name == 'optional type':
                part.add_argument('type', nargs='?', **settings)
            else:
                short = ['-t'] if name == '--show-types' else []
                part.add_argument(*short, name, **settings)
    options = parser.parse_args(arguments)
    return run_ros(lambda: options.work(Graph(), options), [sys.argv[0]])
