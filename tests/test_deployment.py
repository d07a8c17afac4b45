"""Deployment is a swap: an evolved controller on a robot that is not the simulator."""

import ast
import sys
from pathlib import Path

from ros_processes import ROOT, wait_until

STANDIN = Path(__file__).with_name('robot_standin.py')


def test_the_standin_shares_no_code_with_the_simulator():
    modules = set()
    for node in ast.walk(ast.parse(STANDIN.read_text())):
        if isinstance(node, ast.Import):
            modules.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            modules.add(node.module)
    packages = {name.partition('.')[0] for name in modules}
    assert not packages & {'marxbot_sim', 'coevo_manager', 'neuro_controller', 'node_runner'}


def test_a_champion_catches_prey_that_stand_before_strange_robots(start, tmp_path):
    genome = tmp_path / 'predator.yaml'
    export = ['coevo_manager', 'export', 'shipped/open', '--species', 'predator', '--yaml', genome]
    assert start(export).wait() == 0
    runner = [str(ROOT / 'scripts' / 'ros2'), 'launch', 'neuro_controller', 'hardware.launch.xml']
    robots = []
    for name, turn in (('left', '1'), ('right', '-1')):
        namespace = ['--ros-args', '-r', f'__ns:=/{name}']
        robots.append(start([sys.executable, STANDIN, '7', turn, *namespace]))
        start([*runner, f'robot:={name}', f'genome:={genome}', 'autostart:=true'])
    for robot in robots:
        wait_until(lambda r=robot: 'caught after' in r.stdout_text, 'the capture')
