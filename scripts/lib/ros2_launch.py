"""``ros2 launch`` for the declarative part of ROS 2's XML launch files.

Understood are ``arg``, ``node`` (with ``param``, ``remap``, ``env``), ``include``, ``group``,
``push_ros_namespace``, ``set_env``, the conditions ``if`` and ``unless``, and the substitutions
``$(var ...)``, ``$(env ...)``, ``$(find-pkg-share ...)`` and ``$(dirname)``. Anything else is
refused by name.
"""

import os
import re
import reprlib
import signal
import sys
import threading
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import yaml
from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
from rclpy.exceptions import NameValidationException
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_node_name import validate_node_name

from neuro_controller.core.reading import TEXT_LIMIT, read_bytes, reading
from node_runner.children import Children, executable_path

_SUBSTITUTION = re.compile(
    r'\$\((var|env|find-pkg-share|dirname)(?:\s+([^\s()]+))?(?:\s+([^()]*))?\)'
)
_shortened = reprlib.Repr()
_shortened.maxstring = 200
_show = _shortened.repr
_TRUE, _FALSE = ('true', '1'), ('false', '0')


@dataclass
class Scope:
    """What a part of a launch file is read in.

    Attributes
    ----------
    file
        The launch file.
    variables
        Values of its arguments.
    namespace
        Pushed by the groups around it.
    environment
        Variables of the environment set by ``set_env``.
    """

    file: Path
    variables: dict[str, str]
    namespace: str = ''
    environment: dict[str, str] = field(default_factory=dict)

    def text(
        self, element: ElementTree.Element, attribute: str, default: str | None = None
    ) -> str:
        """Return an attribute with its substitutions made; without a default it is required."""
        value = element.get(attribute, default)
        if value is None:
            raise ValueError(f'{self.file.name}: <{element.tag}> lacks the attribute {attribute}')
        result = _SUBSTITUTION.sub(self._substitute, value)
        if '$(' in result:
            raise ValueError(
                f'{self.file.name}: {_show(value)} has a substitution that is not supported'
            )
        return result

    def _substitute(self, match: re.Match) -> str:
        kind, name, default = match.groups()
        if kind == 'dirname':
            return str(self.file.parent)
        if kind == 'var' and name in self.variables:
            return self.variables[name]
        if kind == 'env' and (name in os.environ or default is not None):
            return os.environ.get(name, default)
        if kind == 'find-pkg-share':
            return share(name)
        raise ValueError(f'{self.file.name}: {match[0]} is not defined')

    def applies(self, element: ElementTree.Element) -> bool:
        """Return whether the conditions of an element hold."""
        for attribute, wanted in (('if', _TRUE), ('unless', _FALSE)):
            if attribute in element.attrib:
                value = self.text(element, attribute).lower()
                if value not in _TRUE + _FALSE:
                    raise ValueError(
                        f'{self.file.name}: {attribute} of <{element.tag}> is {_show(value)}, '
                        'expected true or false'
                    )
                if value not in wanted:
                    return False
        return True


@dataclass(frozen=True)
class Node:
    """A process to start: package, executable, its arguments and the variables set for it."""

    package: str
    executable: str
    arguments: list[str]
    environment: dict[str, str]


def share(package: str) -> str:
    """Return the share folder of a package; ValueError if there is no such package."""
    try:
        return get_package_share_directory(package)
    except (PackageNotFoundError, ValueError):
        raise ValueError(f'package {_show(package)} was not found') from None


def read(path: Path, values: dict[str, str]) -> list[Node]:
    """Return the nodes that a launch file starts.

    Parameters
    ----------
    path
        The file.
    values
        Arguments given to it.

    Raises
    ------
    ValueError
        The file, or an argument, makes no sense.
    """
    root = _root(path)
    known = {element.get('name') for element in _arguments(root)}
    for name in values:
        if name not in known:
            raise ValueError(
                f'{path.name} has no argument {_show(name)}; it has '
                f'{", ".join(sorted(known)) or "none"}'
            )
    try:
        return _read_children(root, Scope(path, dict(values)))
    except RecursionError:
        raise ValueError(f'{path} is nested too deeply, or includes itself') from None


def _root(path: Path) -> ElementTree.Element:
    content = read_bytes(path, TEXT_LIMIT)
    with reading(path):
        root = ElementTree.fromstring(content)
    if root.tag != 'launch':
        raise ValueError(f'{path} is not a launch file: its root is <{root.tag}>')
    return root


def _arguments(root: ElementTree.Element) -> list[ElementTree.Element]:
    return root.findall('arg') + root.findall('group/arg')


def _read_children(parent: ElementTree.Element, scope: Scope) -> list[Node]:
    nodes = []
    for element in parent:
        if not scope.applies(element):
            continue
        match element.tag:
            case 'arg':
                name = scope.text(element, 'name')
                if name not in scope.variables:
                    if 'default' not in element.attrib:
                        raise ValueError(f'{scope.file.name} needs the argument {name}:=VALUE')
                    scope.variables[name] = scope.text(element, 'default')
            case 'node':
                nodes.append(_read_node(element, scope))
            case 'include':
                values = {
                    scope.text(arg, 'name'): scope.text(arg, 'value')
                    for arg in element.iter('arg')
                }
                file = Path(scope.text(element, 'file'))
                included = Scope(file, values, scope.namespace, dict(scope.environment))
                nodes += _read_children(_root(file), included)
            case 'group':
                inner = Scope(
                    scope.file, dict(scope.variables), scope.namespace, dict(scope.environment)
                )
                nodes += _read_children(element, inner)
            case 'push_ros_namespace':
                scope.namespace = _join(scope.namespace, scope.text(element, 'namespace'))
            case 'set_env':
                scope.environment[scope.text(element, 'name')] = scope.text(element, 'value')
            case _:
                raise ValueError(f'{scope.file.name}: <{element.tag}> is not supported')
    return nodes


def _join(outer: str, inner: str) -> str:
    if not inner or inner.startswith('/'):
        return inner or outer
    return f'{outer.rstrip("/")}/{inner}'


def _read_node(element: ElementTree.Element, scope: Scope) -> Node:
    arguments = scope.text(element, 'args', '').split()
    ros = []
    if 'name' in element.attrib:
        name = scope.text(element, 'name')
        _check(validate_node_name, name, scope, element)
        ros += ['-r', f'__node:={name}']
    namespace = _join(scope.namespace, scope.text(element, 'namespace', ''))
    if namespace:
        namespace = f'/{namespace.strip("/")}'
        _check(validate_namespace, namespace, scope, element)
        ros += ['-r', f'__ns:={namespace}']
    environment = dict(scope.environment)
    for child in element:
        if not scope.applies(child):
            continue
        match child.tag:
            case 'param' if 'from' in child.attrib:
                file = scope.text(child, 'from')
                if not Path(file).is_file():
                    raise ValueError(f'{scope.file.name}: parameter file {file} does not exist')
                ros += ['--params-file', file]
            case 'param':
                ros += [
                    '-p',
                    f'{scope.text(child, "name")}:={_parameter(scope.text(child, "value"))}',
                ]
            case 'remap':
                ros += ['-r', f'{scope.text(child, "from")}:={scope.text(child, "to")}']
            case 'env':
                environment[scope.text(child, 'name')] = scope.text(child, 'value')
            case _:
                raise ValueError(f'{scope.file.name}: <{child.tag}> in <node> is not supported')
    if ros:
        arguments += ['--ros-args', *ros]
    return Node(scope.text(element, 'pkg'), scope.text(element, 'exec'), arguments, environment)


def _check(
    validate: Callable[[str], bool], name: str, scope: Scope, element: ElementTree.Element
) -> None:
    try:
        validate(name)
    except NameValidationException as error:
        reason = str(error).splitlines()[0].rstrip(':')
        raise ValueError(
            f'{scope.file.name}: {_show(name)} of <{element.tag}> is no name in ROS: {reason}'
        ) from None


def _parameter(value: str) -> str:
    """Return a value so that ROS, which reads it as YAML, takes all of a text for that text."""
    try:
        meant = yaml.safe_load(value)
    except yaml.YAMLError:
        meant = None
    as_it_is = meant == value or isinstance(meant, bool | int | float) or value.startswith('[')
    if as_it_is and value and '#' not in value:
        return value
    return "'" + value.replace("'", "''") + "'"


def find(package: str, file: str) -> Path:
    """Return the path of a package's launch file; ValueError names those there are."""
    folder = Path(share(package), 'launch')
    if not (folder / file).is_file():
        names = ', '.join(sorted(path.name for path in folder.glob('*.xml'))) or 'none'
        raise ValueError(
            f'package {_show(package)} has no launch file {_show(file)}; it has {names}'
        )
    return folder / file


def launch(arguments: list[str]) -> int:
    """Start what a launch file names; ``--show-args`` prints its arguments instead.

    Returns
    -------
    int
        0 when every process ended well, or a signal ended them; 1 when one failed.

    Raises
    ------
    ValueError
        Bad input.
    """
    show = '--show-args' in arguments
    positional = [text for text in arguments if ':=' not in text and text != '--show-args']
    if len(positional) == 1 and Path(positional[0]).is_file():
        path = Path(positional[0])
    elif len(positional) == 2:
        path = find(*positional)
    else:
        raise ValueError('launch needs a package and a launch file, or the path of one')
    if show:
        _show_arguments(path)
        return 0
    values = dict(text.split(':=', 1) for text in arguments if ':=' in text)
    nodes = read(path, values)
    for node in nodes:
        executable_path(node.package, node.executable)
    return _run(nodes)


def _show_arguments(path: Path) -> None:
    for element in _arguments(_root(path)):
        default = (
            f'default {element.get("default")!r}' if 'default' in element.attrib else 'needed'
        )
        print(f'{element.get("name")}: {element.get("description", "")} ({default})')


def _run(nodes: list[Node]) -> int:
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    failed = False
    with Children() as children:
        running = {}
        for node in nodes:
            process = children.start(
                node.package,
                node.executable,
                node.arguments,
                env={**os.environ, **node.environment},
            )
            running[process] = f'{node.package} {node.executable}'
            print(f'launch: started {running[process]} (process {process.pid})', flush=True)
        while running and not stop.wait(0.1):
            for process in [process for process in running if process.poll() is not None]:
                name = running.pop(process)
                failed |= process.returncode != 0
                print(f'launch: {name} ended with {process.returncode}', file=sys.stderr)
    return int(failed)
