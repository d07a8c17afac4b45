"""The packages' READMEs state the parameters that the nodes declare, with their defaults."""

import re
from dataclasses import fields

from ros_processes import ROOT

from marxbot_sim import node_parameters
from neuro_controller import controller
from neuro_controller.core.limits import Limits


def documented(package):
    """Parameter -> default as the package's README states it."""
    text = (ROOT / 'ros2_ws' / 'src' / package / 'README.md').read_text()
    rows = re.findall(r'^\| `([\w.]+)` \| (?:bool|int|double|string) \| (\S+) \|', text, re.M)
    return {name: default.strip('`') for name, default in rows}


def written(value):
    """A default as a README writes it."""
    if value == '':
        return 'empty'
    if isinstance(value, bool):
        return str(value).lower()
    return '.inf' if value == float('inf') else str(value)


def test_the_simulators_readme_states_its_parameters():
    declared = {name: default for name, (default, _) in node_parameters._PARAMETERS.items()}
    for group, kind in node_parameters._GROUPS.items():
        declared |= {f'{group}.{field.name}': field.default for field in fields(kind)}
    assert documented('marxbot_sim') == {name: written(v) for name, v in declared.items()}


def test_the_controllers_readme_states_its_parameters():
    tables = {**controller._NETWORK, **controller._FIXED}
    declared = {name: default for name, (default, _) in tables.items()}
    declared |= {f'limits.{field.name}': field.default for field in fields(Limits)}
    declared |= {'use_sim_time': False, 'run': ''}  # of every node, and of the genome server
    assert documented('neuro_controller') == {name: written(v) for name, v in declared.items()}
