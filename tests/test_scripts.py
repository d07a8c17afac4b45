"""The commands of scripts/, as a user types them."""

import ast
import os
import re
import shutil
import subprocess

import pytest
from ros_processes import ROOT
from test_workspace import PYTHON_PACKAGES, setup_arguments

SCRIPTS = sorted(path for path in (ROOT / 'scripts').iterdir() if path.is_file())


def run(*arguments, **changes):
    """Run a command of the clone with some environment variables set, and wait for it."""
    return subprocess.run(
        [str(argument) for argument in arguments],
        cwd=ROOT,
        env={**os.environ, **changes},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=240,
    )


@pytest.mark.parametrize('script', SCRIPTS, ids=lambda path: path.name)
@pytest.mark.parametrize('option', ['--help', '-h'])
def test_help_says_how_it_is_used(script, option):
    result = run(script, option)
    assert result.returncode == 0
    assert re.search(rf'Usage: (source )?scripts/{script.name}', result.stdout)
    assert result.stderr == ''


@pytest.mark.parametrize('script', ['setup', 'lint'])
def test_unexpected_argument_is_refused(script):
    result = run(ROOT / 'scripts' / script, '--fast')
    assert result.returncode == 2
    assert result.stderr == f'{script}: takes no arguments, got --fast\n'


def test_setup_does_nothing_the_second_time():
    assert run('scripts/setup').returncode == 0
    stamps = [ROOT / '.venv' / '.complete', ROOT / 'ros2_ws' / 'install' / '.complete']
    before = [path.stat().st_mtime_ns for path in stamps]
    result = run('scripts/setup')
    assert (result.returncode, result.stderr) == (0, '')
    assert [path.stat().st_mtime_ns for path in stamps] == before


def bare_clone(folder):
    """Make a clone that holds no more than setup reads first."""
    shutil.copytree(ROOT / 'scripts', folder / 'scripts')
    shutil.copy(ROOT / 'requirements.lock', folder)
    return folder


@pytest.mark.parametrize('name', ['with a space', 'Dörte', "queen's", 'a=b', 'a,b', '50%'])
def test_setup_refuses_a_path_that_ros_cannot_be_built_in(tmp_path, name):
    """Each of these names broke the build, or the scripts that colcon writes."""
    clone = bare_clone(tmp_path / name)
    (tmp_path / 'link').symlink_to(clone)
    for way in (clone, tmp_path / 'link'):
        result = run('bash', '-c', 'source "$1"', 'bash', way / 'scripts' / 'activate')
        assert (result.returncode, result.stderr.count('\n')) == (2, 1)
        assert result.stderr.startswith(f"setup: this clone is in '{way}'")
    assert {path.name for path in clone.iterdir()} == {'scripts', 'requirements.lock'}


def test_setup_names_what_is_wrong_with_the_python(tmp_path):
    clone = bare_clone(tmp_path / 'clone')
    result = run(clone / 'scripts' / 'setup', PYTHON='python3.99')
    assert result.returncode == 2
    assert result.stderr.count('\n') == 1
    assert 'python3.99 was not found' in result.stderr
    assert {path.name for path in clone.iterdir()} == {'scripts', 'requirements.lock'}


def test_environment_is_what_the_lock_file_says():
    python = ROOT / '.venv' / 'bin' / 'python'
    installed = run(python, '-m', 'pip', 'list', '--format=freeze').stdout
    names = {line.lower().replace('_', '-').replace('.', '-') for line in installed.split()}
    pins = (ROOT / 'requirements.lock').read_text().splitlines()
    missing = [
        pin
        for pin in pins
        if not pin.startswith('#') and pin.lower().replace('_', '-').replace('.', '-') not in names
    ]
    assert not missing
    assert run(python, '-m', 'pip', 'check').returncode == 0


def test_ros2_lists_the_declared_executables():
    declared = {
        (package, entry.partition('=')[0].strip())
        for package in PYTHON_PACKAGES
        for entry in ast.literal_eval(setup_arguments(package)['entry_points'])['console_scripts']
    }
    listed = {
        tuple(line.split())
        for line in run('scripts/ros2', 'pkg', 'executables').stdout.splitlines()
    }
    assert {entry for entry in listed if entry[0] in PYTHON_PACKAGES} == declared
    for package in PYTHON_PACKAGES:
        lines = run('scripts/ros2', 'pkg', 'executables', package).stdout.splitlines()
        assert lines == sorted(f'{package} {name}' for owner, name in declared if owner == package)


def test_ros2_lists_packages_of_workspace_and_environment():
    names = run('scripts/ros2', 'pkg', 'list').stdout.split()
    assert {*PYTHON_PACKAGES, 'coevo_msgs', 'marxbot_msgs', 'rclpy', 'std_msgs'} <= set(names)
    assert names == sorted(names)


@pytest.mark.parametrize(
    ('arguments', 'named'),
    [
        (['run', 'no_such_package', 'evolve'], "'no_such_package'"),
        (['run', 'coevo_manager', 'no_such_executable'], "'no_such_executable'"),
        (['run', 'coevo_manager'], 'executable'),
        (['pkg', 'executables', 'no_such_package'], "'no_such_package'"),
        (['pkg', 'prefix'], 'prefix'),
        (['bag', 'record'], 'bag takes info BAG'),
        (['bag', 'info', '/nowhere'], '/nowhere is not the folder of a bag'),
        (['topic', 'pub'], "'pub'"),
        ([], 'command'),
    ],
)
def test_ros2_says_in_one_sentence_what_is_wrong(arguments, named):
    result = run('scripts/ros2', *arguments)
    assert result.returncode == 2
    assert result.stdout == ''
    assert result.stderr.count('\n') == 1
    assert named in result.stderr


def test_ros2_names_a_middleware_that_is_not_installed():
    result = run('scripts/ros2', 'pkg', 'list', RMW_IMPLEMENTATION='rmw_of_mine')
    assert result.returncode == 2
    assert result.stderr == (
        "ros2: RMW_IMPLEMENTATION is 'rmw_of_mine', which is not installed; there is "
        'rmw_fastrtps_cpp\n'
    )


def test_versions_are_told():
    (package, *_) = PYTHON_PACKAGES
    version = ast.literal_eval(setup_arguments(package)['version'])
    assert run('scripts/ros2', '--version').stdout.startswith(f'Red Queen {version}, commit ')
    told = run('scripts/ros2', 'run', 'coevo_manager', 'evolve', '--version').stdout
    assert told == f'evolve of Red Queen {version}\n'


@pytest.mark.parametrize(
    ('typed', 'expected'),
    [
        ('lau', {'launch'}),
        ('run neuro', {'neuro_controller'}),
        ('run coevo_manager re', {'record', 'replay'}),
        ('launch coevo_manager d', {'demo.launch.xml'}),
        ('topic e', {'echo'}),
    ],
)
def test_the_shell_completes(typed, expected):
    words = f'scripts/ros2 {typed}'.split()
    script = (
        'source scripts/lib/completion.bash; '
        f'COMP_WORDS=({" ".join(words)}); COMP_CWORD={len(words) - 1}; _red_queen_ros2; '
        'printf "%s\\n" "${COMPREPLY[@]}"'
    )
    assert set(run('bash', '-c', script).stdout.split()) == expected


def test_activate_is_not_run_but_sourced():
    result = run('scripts/activate')
    assert result.returncode == 2
    assert result.stderr == 'activate: is to be sourced: source scripts/activate\n'


def test_ros2_becomes_the_executable(tmp_path):
    """The same process, so that signals reach it and its exit code is the command's."""
    prefix = tmp_path / 'echoes'
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    (index / 'echoes').touch()
    executable = prefix / 'lib' / 'echoes' / 'echo'
    executable.parent.mkdir(parents=True)
    executable.write_text('#!/bin/sh\necho $$ "$@"\nexit 7\n')
    executable.chmod(0o755)
    command = subprocess.Popen(
        [ROOT / 'scripts' / 'ros2', 'run', 'echoes', 'echo', '--option', 'two words'],
        env={**os.environ, 'AMENT_PREFIX_PATH': str(prefix)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
    )
    output, _ = command.communicate(timeout=60)
    assert output == f'{command.pid} --option two words\n'
    assert command.returncode == 7


def test_ros2_hands_over_to_an_installed_one(tmp_path):
    installed = tmp_path / 'ros2'
    installed.write_text('#!/bin/sh\necho "installed: $*"\nexit 7\n')
    installed.chmod(0o755)
    path = f'{ROOT}/scripts:{tmp_path}:{os.environ["PATH"]}'
    result = run('scripts/ros2', 'topic', 'list', PATH=path)
    assert (result.returncode, result.stdout) == (7, 'installed: topic list\n')


def test_ros2_hands_over_on_a_path_with_a_space_but_not_to_another_clone(tmp_path):
    clone, other = tmp_path / 'another clone' / 'scripts', tmp_path / 'with a space'
    for folder in (clone / 'lib', other):
        folder.mkdir(parents=True)
    shutil.copy(ROOT / 'scripts' / 'lib' / 'ros2.py', clone / 'lib')
    for script, says in ((clone / 'ros2', 'clone'), (other / 'ros2', 'installed')):
        script.write_text(f'#!/bin/sh\necho {says}\n')
        script.chmod(0o755)
    path = f'{clone}:{ROOT}/scripts:{{}}{os.environ["PATH"]}'
    assert (
        run('scripts/ros2', 'pkg', 'list', PATH=path.format(f'{other}:')).stdout == 'installed\n'
    )
    assert 'marxbot_sim' in run('scripts/ros2', 'pkg', 'list', PATH=path.format('')).stdout


@pytest.mark.parametrize('name', ['PYTHONPATH', 'LD_LIBRARY_PATH', 'CMAKE_PREFIX_PATH'])
def test_an_empty_path_never_stands_for_the_current_folder(name):
    enter = f'source scripts/lib/common.sh; enter_workspace; echo ":${{{name}:-none}}:"'
    result = run('bash', '-c', enter, **{name: ''})
    assert '::' not in result.stdout


@pytest.mark.parametrize(
    ('given', 'expected'),
    [({}, 'LOCALHOST'), ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}, 'SUBNET')],
)
def test_discovery_stays_on_this_machine_unless_told(given, expected):
    names = ('ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_STATIC_PEERS', 'ROS_LOCALHOST_ONLY')
    unset = ' '.join(f'-u {name}' for name in names if name not in given)
    enter = 'source scripts/lib/common.sh; enter_workspace; echo $ROS_AUTOMATIC_DISCOVERY_RANGE'
    result = run('bash', '-c', f"env {unset} bash -c '{enter}'", **given)
    assert result.stdout.strip() == expected


def test_ros2_tells_what_a_bag_holds(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    bag, types = tmp_path / 'bag', get_typestore(Stores.ROS2_JAZZY)
    message = types.types['std_msgs/msg/Bool'](data=True)
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for topic, count in (('/b', 3), ('/a', 1)):
            connection = writer.add_connection(topic, 'std_msgs/msg/Bool', typestore=types)
            data = types.serialize_cdr(message, 'std_msgs/msg/Bool')
            for number in range(count):
                writer.write(connection, (10 + number) * 10**8, data)
    lines = run('scripts/ros2', 'bag', 'info', bag).stdout.splitlines()
    told = dict(line.split(':', 1) for line in lines if not line.startswith(' '))
    assert told['Files'].strip() == 'bag.mcap'
    assert told['Storage id'].strip() == 'mcap'
    assert told['Messages'].strip() == '4'
    assert told['Start'].strip() == 'Jan  1 1970 00:00:01.000000000 (1.000000000)'
    assert [line.split('Topic: ')[1] for line in lines[-2:]] == [
        f'{topic} | Type: std_msgs/msg/Bool | Count: {count} | Serialization Format: cdr'
        for topic, count in (('/a', 1), ('/b', 3))
    ]
    (bag / 'metadata.yaml').write_text('rosbag2_bagfile_information: {version: x}')
    result = run('scripts/ros2', 'bag', 'info', bag)
    assert result.returncode == 2
    assert f'{bag} is not a readable bag: ' in result.stderr
    assert result.stderr.count('\n') == 1
