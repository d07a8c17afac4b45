"""What is wrong around a node that runs: told on its log, and to be told on /diagnostics."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from typing import cast

import yaml
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from node_runner.interface import type_name
from node_runner.start import parameter_files

PERIOD = 1.0
"""Time between two looks around, s (real time)."""

_ALWAYS_TAKEN = ('use_sim_time', 'start_type_description_service')


class Concerns:
    """Looks around once a second; to be made at the end of a node's constructor.

    It finds parameters that the node was given and does not know, parameter files that name other
    nodes only, simulated time without a clock, and topics on which others use another type.

    Parameters
    ----------
    node : Node
    command_line : sequence of str, optional
        By default ``sys.argv``.

    Attributes
    ----------
    sentences : list of str
        What is wrong now.
    """

    def __init__(self, node: Node, command_line: Sequence[str] | None = None):
        self._node = node
        self._started = [
            *_unknown_parameters(node),
            *_foreign_files(node, sys.argv if command_line is None else command_line),
        ]
        self.sentences: list[str] = []
        self._look()
        node.create_timer(PERIOD, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    @property
    def without_clock(self) -> bool:
        """Whether the node waits for the first message on /clock."""
        simulated = self._node.get_parameter('use_sim_time').value
        return simulated and self._node.get_clock().now().nanoseconds == 0

    def _look(self) -> None:
        before, self.sentences = self.sentences, [*self._started, *_other_types(self._node)]
        if self.without_clock:
            self.sentences.append('use_sim_time is set and nothing came on /clock so far')
        for sentence in self.sentences:
            if sentence not in before:
                self._node.get_logger().warning(sentence)


def _unknown_parameters(node: Node) -> Iterator[str]:
    for name in sorted(node._parameter_overrides):
        known = node.has_parameter(name) or name in _ALWAYS_TAKEN
        if not known and not name.startswith('qos_overrides.'):
            yield f'parameter {name!r} was given, and this node has none of that name'


def _foreign_files(node: Node, command_line: Sequence[str]) -> Iterator[str]:
    """Name the parameter files that hold nothing for this node."""
    full_name = node.get_fully_qualified_name()
    for file in parameter_files(command_line):
        content = yaml.safe_load(file.read_text(encoding='utf-8'))  # rcl has read it before
        names = list(_node_names(content, ''))
        if not any(_pattern(name).fullmatch(full_name) for name in names):
            found = ', '.join(names) or 'no node'
            yield f'parameter file {file} names {found}, and not this node, {full_name}'


def _node_names(content: object, prefix: str) -> Iterator[str]:
    if isinstance(content, dict):
        for key, value in content.items():
            if key == 'ros__parameters':
                yield prefix or '/'
            else:
                yield from _node_names(value, f'{prefix}/{str(key).strip("/")}')


def _pattern(name: str) -> re.Pattern[str]:
    """Return what a node name of a parameter file stands for; ``*`` is one part, ``**`` any."""
    parts = re.escape(name).replace('/\\*\\*', '(/[^/]+)*').replace('\\*', '[^/]+')
    return re.compile(parts)


def _other_types(node: Node) -> Iterator[str]:
    """Name the topics of a node on which others use another type than it does."""
    for own, verb, endpoints in (
        (node.subscriptions, 'published', node.get_publishers_info_by_topic),
        (node.publishers, 'taken', node.get_subscriptions_info_by_topic),
    ):
        for entity in own:
            expected, topic = type_name(cast(type, entity.msg_type)), entity.topic_name
            for other in sorted({e.topic_type for e in endpoints(topic)} - {expected}):
                yield f'{topic} is {expected} here, and {verb} as {other} by another node'
