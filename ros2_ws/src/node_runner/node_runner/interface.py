"""What a node takes, says and offers: the one definition of its parameters, topics and services.

The node declares its parameters from it, ``--help`` prints it, and tests compare it with the
package's README and with the running node.
"""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

_TYPES = {
    bool: 'bool',
    int: 'int',
    float: 'double',
    str: 'string',
    RosParameter.Type.DOUBLE_ARRAY: 'double[]',
    RosParameter.Type.INTEGER_ARRAY: 'int[]',
}


@dataclass(frozen=True)
class Parameter:
    """A parameter of a node.

    Attributes
    ----------
    name : str
    default
        A bool, int, float or str, or a `rclpy.parameter.Parameter.Type` of one that is not set.
    text : str
        What it means, and its unit.
    low, high : float
        Least and highest value.
    choices : tuple of str
        The values there are.
    live : bool
        Whether it can be set while the node runs.
    """

    name: str
    default: Any
    text: str
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    live: bool = False

    @property
    def type(self) -> str:
        """Name of its type, as ROS 2 tools write it."""
        return _TYPES.get(type(self.default)) or _TYPES[self.default]

    @property
    def default_text(self) -> str:
        """The default as it is written in documents."""
        if isinstance(self.default, RosParameter.Type):
            return 'not set'
        if self.default == '':
            return 'empty'
        if isinstance(self.default, bool):
            return str(self.default).lower()
        return '.inf' if self.default == math.inf else str(self.default)

    def declare(self, node: Node) -> None:
        """Declare it to a node; ValueError if the node is started with a value out of range."""
        descriptor = ParameterDescriptor(
            description=self.text,
            read_only=not self.live,
            additional_constraints=', '.join(self._constraints()),
        )
        node.declare_parameter(self.name, self.default, descriptor)
        if not isinstance(self.default, RosParameter.Type):
            self.check(node.get_parameter(self.name).value)

    def check(self, value: Any) -> None:
        """Raise ValueError, in a sentence, for a value that is out of its range."""
        if self.choices and value not in self.choices:
            raise ValueError(
                f'{self.name} is {value!r}, expected one of {", ".join(self.choices)}'
            )
        if self._limited and not self.low <= value <= self.high:
            raise ValueError(f'{self.name} is {value}, expected a number {self._limits}')

    @property
    def _limited(self) -> bool:
        return (self.low, self.high) != (-math.inf, math.inf)

    @property
    def _limits(self) -> str:
        if self.high == math.inf:
            return f'of at least {self.low:.10g}'
        return f'from {self.low:.10g} to {self.high:.10g}'

    def line(self) -> str:
        """Return what ``--help`` says of it."""
        facts = [self.type, f'default {self.default_text}', *self._constraints()]
        if self.live:
            facts.append('live')
        return _line(self.name, ', '.join(facts), self.text)

    def _constraints(self) -> list[str]:
        constraints = [' or '.join(self.choices)] if self.choices else []
        if self._limited:
            constraints.append(self._limits)
        return constraints


@dataclass(frozen=True)
class Topic:
    """A topic that a node publishes or subscribes to.

    Attributes
    ----------
    name : str
        As the node creates it, relative to its namespace.
    type : type
        Of its messages.
    text : str
        What it tells, and its units.
    qos : QoSProfile
    """

    name: str
    type: type
    text: str
    qos: QoSProfile

    @property
    def qos_text(self) -> str:
        """Reliability, durability and depth in words."""
        best_effort = self.qos.reliability == ReliabilityPolicy.BEST_EFFORT
        latched = self.qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
        words = ['best effort' if best_effort else 'reliable']
        return ', '.join([*words, *['latched'] * latched, str(self.qos.depth)])

    def line(self) -> str:
        """Return what ``--help`` says of it."""
        return _line(self.name, f'{type_name(self.type)}; {self.qos_text}', self.text)


@dataclass(frozen=True)
class Service:
    """A service or an action that a node offers: its name, its type and what it does."""

    name: str
    type: type
    text: str

    def line(self) -> str:
        """Return what ``--help`` says of it."""
        return _line(self.name, type_name(self.type), self.text)


@dataclass(frozen=True)
class Interface:
    """All that others need to know of a node.

    Attributes
    ----------
    command : str
        Package and executable.
    text : str
        What the node is.
    parameters, subscribes, publishes, services, actions : tuple
        Of `Parameter`, `Topic`, `Topic`, `Service` and `Service`.
    """

    command: str
    text: str
    parameters: tuple[Parameter, ...] = ()
    subscribes: tuple[Topic, ...] = ()
    publishes: tuple[Topic, ...] = ()
    services: tuple[Service, ...] = ()
    actions: tuple[Service, ...] = ()

    def declare(self, node: Node) -> None:
        """Declare all parameters, and refuse values out of range that are set later.

        Raises
        ------
        ValueError
            The node is started with one.
        """
        known = {parameter.name: parameter for parameter in self.parameters}
        for parameter in self.parameters:
            parameter.declare(node)

        def check(parameters: list[RosParameter]) -> SetParametersResult:
            try:
                for parameter in parameters:
                    if parameter.name in known:
                        known[parameter.name].check(parameter.value)
            except ValueError as error:
                return SetParametersResult(successful=False, reason=str(error))
            return SetParametersResult(successful=True)

        node.add_on_set_parameters_callback(check)

    def help(self) -> str:
        """Return the text of ``--help``."""
        parts = [
            textwrap.fill(f'{self.command}: {self.text}', 99),
            f'Usage: ros2 run {self.command} [--ros-args -p NAME:=VALUE -r __ns:=/NAMESPACE ...]',
        ]
        for title, entries in (
            ('Parameters', self.parameters),
            ('Subscribes', self.subscribes),
            ('Publishes', self.publishes),
            ('Services', self.services),
            ('Actions', self.actions),
        ):
            if entries:
                parts.append('\n'.join([f'{title}:', *(entry.line() for entry in entries)]))
        return '\n\n'.join(parts)


def type_name(kind: type) -> str:
    """Return the name of a message or service type, such as ``std_msgs/msg/String``."""
    package, folder, *_ = kind.__module__.split('.')
    return f'{package}/{folder}/{kind.__name__}'


def _line(name: str, facts: str, text: str) -> str:
    return textwrap.fill(
        f'  {name} ({facts}): {text}', 99, subsequent_indent='      ', break_on_hyphens=False
    )
