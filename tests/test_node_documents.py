"""Each package's README states what its nodes take, say and offer, and the nodes do."""

import re

import pytest
from ros_processes import ROOT

from coevo_manager.recording.episodes import EPISODES
from coevo_manager.runs.manager import MANAGER
from marxbot_sim.interface import SIMULATOR
from neuro_controller.interface import CONTROLLER, GENOME_SERVER
from node_runner.interface import type_name
from robot_senses.interface import ADAPTER

PACKAGES = {
    'marxbot_sim': [SIMULATOR],
    'neuro_controller': [CONTROLLER, GENOME_SERVER],
    'robot_senses': [ADAPTER],
}
NODES = [SIMULATOR, CONTROLLER, GENOME_SERVER, ADAPTER, MANAGER, EPISODES]


def rows(package):
    """The cells of the rows of the tables of a package's README."""
    text = (ROOT / 'ros2_ws' / 'src' / package / 'README.md').read_text()
    for line in re.findall(r'^\| `.*\|$', text, re.M):
        yield [cell.strip() for cell in re.split(r'(?<!\\)\|', line)[1:-1]]


@pytest.mark.parametrize('package', PACKAGES)
def test_the_readme_states_the_parameters(package):
    documented = {
        name.strip('`'): (kind, default.strip('`'))
        for name, kind, default, *_ in (row for row in rows(package) if len(row) == 4)
        if re.fullmatch(r'bool|int|double|string|(?:int|double)\[\]', kind)
    }
    declared = {
        parameter.name: (parameter.type, parameter.default_text)
        for interface in PACKAGES[package]
        for parameter in interface.parameters
    }
    assert documented.pop('use_sim_time', None) in (None, ('bool', 'false'))  # of every node
    assert documented == declared


@pytest.mark.parametrize('package', PACKAGES)
def test_the_readme_states_the_topics(package):
    documented = {
        row[0].strip('`').removesuffix('` (in)'): (row[1], row[2])
        for row in rows(package)
        if len(row) == 4 and re.search(r'effort|reliable|latched', row[2])
    }
    declared = {
        re.sub('^(predator|prey)/', '', topic.name): (
            type_name(topic.type).replace('/msg/', '/'),
            topic.qos_text,
        )
        for interface in PACKAGES[package]
        for topic in (*interface.subscribes, *interface.publishes)
    }
    assert documented == declared


@pytest.mark.parametrize('interface', NODES, ids=lambda interface: interface.command)
def test_help_states_everything_and_starts_nothing(start, interface):
    process = start([*interface.command.split(), '--help'])
    assert process.wait() == 0
    for entry in (
        *interface.parameters,
        *interface.subscribes,
        *interface.publishes,
        *interface.services,
        *interface.actions,
    ):
        assert entry.line() in process.stdout_text
    assert process.stderr_text == ''


def test_the_running_simulator_is_as_defined(starter, client):
    starter(['marxbot_sim', 'simulator'])
    node, name = client.node, 'simulator'

    def there(names_and_types):
        common = ('/rosout', '/parameter_events', '/simulator/')
        found = {(n, tuple(t)) for n, t in names_and_types(name, '/')}
        return {(n, t) for n, t in found if not n.startswith(common)}

    def defined(topics):
        return {(f'/{topic.name.lstrip("/")}', (type_name(topic.type),)) for topic in topics}

    for entries, names_and_types in (
        (SIMULATOR.publishes, node.get_publisher_names_and_types_by_node),
        (SIMULATOR.subscribes, node.get_subscriber_names_and_types_by_node),
    ):
        client.until(lambda: ('simulator', '/') in node.get_node_names_and_namespaces(), 'it')
        client.until(
            lambda e=entries, n=names_and_types: there(n) == defined(e), 'what is defined'
        )
    services = {
        service.name.replace('~', '/simulator'): [type_name(service.type)]
        for service in SIMULATOR.services
    }

    def offered():
        return dict(node.get_service_names_and_types_by_node(name, '/'))

    client.until(lambda: {**offered(), **services} == offered(), 'what is defined')
