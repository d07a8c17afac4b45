"""Launch files: what they name exists, and they start the system; errors are told."""

import signal
import xml.etree.ElementTree as ElementTree

import pytest
import yaml
from marxbot_msgs.msg import ArenaState
from ros_client import ros_client
from ros_processes import ROOT, process_starter, ros_environment

from marxbot_sim.interface import SIMULATOR
from neuro_controller.interface import CONTROLLER, GENOME_SERVER

SOURCES = ROOT / 'ros2_ws' / 'src'
FILES = sorted(SOURCES.glob('*/launch/*.launch.xml'))
RUNNER = [str(ROOT / 'scripts' / 'ros2'), 'launch']
PARAMETERS = {
    interface.command.split()[1]: {parameter.name for parameter in interface.parameters}
    for interface in (SIMULATOR, CONTROLLER, GENOME_SERVER)
}


@pytest.mark.parametrize('file', FILES, ids=lambda file: file.name)
def test_what_a_launch_file_names_exists(file):
    for node in ElementTree.parse(file).getroot().iter('node'):
        setup = (SOURCES / node.get('pkg') / 'setup.py').read_text()
        assert f'{node.get("exec")} = {node.get("pkg")}.' in setup
        for param in node.iter('param'):
            if 'name' in param.attrib:
                assert param.get('name') in {*PARAMETERS[node.get('exec')], 'use_sim_time'}
    for include in ElementTree.parse(file).getroot().iter('include'):
        package, *place = include.get('file').removeprefix('$(find-pkg-share ').split(')')
        included = SOURCES / package / place[0].lstrip('/')
        known = {arg.get('name') for arg in ElementTree.parse(included).getroot().iter('arg')}
        assert {arg.get('name') for arg in include.iter('arg')} <= known


def test_every_launch_file_is_read_as_it_is_installed(tmp_path):
    from ros2_launch import read

    genome = tmp_path / 'genome.yaml'
    genome.write_text('{}')
    given = {
        'hardware.launch.xml': {'genome': str(genome), 'robot': 'rover'},
        'robot.launch.xml': {'robot': 'prey'},
    }
    for file in FILES:
        assert read(file, given.get(file.name, {}))
    (node,) = read(
        SOURCES / 'neuro_controller' / 'launch' / 'hardware.launch.xml',
        {'genome': str(genome), 'robot': 'rover', 'cmd_vel': '/base/cmd_vel'},
    )
    line = ' '.join(node.arguments)
    assert '-r __ns:=/rover' in line and '-r cmd_vel:=/base/cmd_vel' in line
    assert f'--params-file {genome}' in line and '-p autostart:=false' in line


def test_the_runner_understands_conditions_groups_and_substitutions(tmp_path, monkeypatch):
    from ros2_launch import read

    monkeypatch.setenv('WHO', 'me')
    inner = tmp_path / 'inner.launch.xml'
    inner.write_text('<launch><arg name="a"/><node pkg="p" exec="$(var a)"/></launch>')
    outer = tmp_path / 'outer.launch.xml'
    outer.write_text("""<launch>
      <arg name="x" default="1"/><arg name="on" default="true"/>
      <group if="$(var on)">
        <push_ros_namespace namespace="ns_$(var x)"/>
        <set_env name="A" value="$(env WHO)"/>
        <node pkg="p" exec="one" namespace="inner" args="--flag $(env NONE none)">
          <param name="k" value=""/>
        </node>
        <include file="$(dirname)/inner.launch.xml"><arg name="a" value="two"/></include>
      </group>
      <node pkg="p" exec="three" unless="$(var on)"/>
      <node pkg="p" exec="four"/>
    </launch>""")
    one, two, four = read(outer, {'x': '7'})
    assert one.arguments == [
        '--flag',
        'none',
        '--ros-args',
        '-r',
        '__ns:=/ns_7/inner',
        '-p',
        "k:=''",
    ]
    assert one.environment == {'A': 'me'}
    assert (two.executable, two.arguments) == ('two', ['--ros-args', '-r', '__ns:=/ns_7'])
    assert (four.executable, four.arguments, four.environment) == ('four', [], {})
    assert [node.executable for node in read(outer, {'on': 'false'})] == ['three', 'four']


@pytest.mark.parametrize(
    ('value', 'given'),
    [
        ('', "''"),
        ('a #b', "'a #b'"),
        ('#1', "'#1'"),
        ("it's #1", "'it''s #1'"),
        ('x: y', "'x: y'"),
        ('null', "'null'"),
        ('1.0', '1.0'),
        ('true', 'true'),
        ('[1, 2]', '[1, 2]'),
        ('runs/standard-3', 'runs/standard-3'),
    ],
)
def test_a_text_reaches_the_node_whole(value, given):
    from ros2_launch import _parameter

    assert _parameter(value) == given
    text = yaml.safe_load(given)
    assert text == value or not isinstance(text, str)


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        (
            '<launch><node pkg="p" exec="e" namespace="a b"/></launch>',
            "'/a b' of <node> is no name in ROS: Invalid namespace: namespace must not contain",
        ),
        (
            '<launch><node pkg="p" exec="e" name="1st"/></launch>',
            "'1st' of <node> is no name in ROS: Invalid node name: node name must not start with",
        ),
        ('<launch><node pkg="p"/></launch>', '<node> lacks the attribute exec'),
        ('<launch><timer/></launch>', '<timer> is not supported'),
        ('<launch><arg name="a"/></launch>', 'needs the argument a:=VALUE'),
        ('<launch><node pkg="$(var b)" exec="e"/></launch>', '$(var b) is not defined'),
        (
            '<launch><node pkg="$(eval 1)" exec="e"/></launch>',
            'substitution that is not supported',
        ),
        ('<launch><node pkg="p" exec="e" if="maybe"/></launch>', 'expected true or false'),
        ('<launch', 'is damaged: unclosed token'),
        ('<lunch/>', 'its root is <lunch>'),
        (
            '<launch><node pkg="p" exec="e"><param from="/no/file"/></node></launch>',
            'parameter file /no/file does not exist',
        ),
    ],
)
def test_a_bad_launch_file_is_refused_in_a_sentence(tmp_path, text, sentence):
    from ros2_launch import read

    file = tmp_path / 'bad.launch.xml'
    file.write_text(text)
    with pytest.raises(ValueError, match=r'^[^\n]*$') as error:
        read(file, {})
    assert sentence in str(error.value)


def wait_for_ticks(client, topic, ticks):
    states = client.listen(ArenaState, topic)
    client.until(lambda: states and states[-1].tick >= ticks, f'{ticks} ticks on {topic}')
    return states


def test_two_demos_play_side_by_side_and_hear_nothing_of_each_other(tmp_path):
    demo = [*RUNNER, 'coevo_manager', 'demo.launch.xml', 'real_time_factor:=4.0']
    with (
        ros_environment() as env,
        ros_environment() as other_env,
        process_starter(env, tmp_path / 'a') as start,
        process_starter(other_env, tmp_path / 'b') as start_other,
    ):
        process = start([*demo, 'obstacle:=true', 'predator:=obstacle.predator'])
        other = start_other(demo)
        for environment, obstacle in ((env, True), (other_env, False)):
            with ros_client(environment) as client:
                states = wait_for_ticks(client, '/arena/state', 20)
                count = client.node.count_publishers
                client.until(lambda n=count: n('/prey/cmd_vel'), 'the controllers')
                wait_for_ticks(client, '/arena/state', 20)
                assert {state.obstacle for state in states} == {obstacle}
                assert count('/prey/cmd_vel') == count('/clock') == 1
        for demo_process, number in ((process, signal.SIGINT), (other, signal.SIGTERM)):
            demo_process.send_signal(number)
            assert demo_process.wait() == 0
            assert 'Traceback' not in demo_process.stderr_text


def test_two_demos_in_one_domain_keep_to_their_namespaces(tmp_path):
    file = tmp_path / 'two.launch.xml'
    file.write_text("""<launch>
      <group><push_ros_namespace namespace="one"/>
        <node pkg="marxbot_sim" exec="simulator"><remap from="/clock" to="/one/clock"/></node>
      </group>
      <group><push_ros_namespace namespace="two"/>
        <node pkg="marxbot_sim" exec="simulator"><remap from="/clock" to="/two/clock"/></node>
      </group>
    </launch>""")
    with ros_environment() as env, process_starter(env, tmp_path / 'p') as start:
        start([*RUNNER, file])
        with ros_client(env) as client:
            for name in ('one', 'two'):
                wait_for_ticks(client, f'/{name}/arena/state', 2)
                assert client.node.count_publishers(f'/{name}/clock') == 1
            assert client.node.count_publishers('/clock') == 0


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (['coevo_manager', 'nothing.xml'], 'it has demo.launch.xml, evaluators.launch.xml'),
        (['no_package', 'x.xml'], "package 'no_package' was not found"),
        (['coevo_manager', 'demo.launch.xml', 'colour:=red'], "has no argument 'colour'"),
        (['neuro_controller', 'robot.launch.xml'], 'needs the argument robot:=VALUE'),
        ([], 'launch needs a package and a launch file'),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(start, arguments, sentence):
    process = start([*RUNNER, *arguments])
    assert process.wait(40) == 2
    assert sentence in process.stderr_text
    assert len(process.stderr_text.strip().splitlines()) == 1


def test_the_arguments_of_a_file_can_be_shown(start):
    process = start([*RUNNER, 'coevo_manager', 'demo.launch.xml', '--show-args'])
    assert process.wait(40) == 0
    assert "real_time_factor: simulated over real time (default '1.0')" in process.stdout_text
