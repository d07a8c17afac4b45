"""The help that other tests lean on: own domains, a clean end."""

import signal
import subprocess
from pathlib import Path

from ros_processes import ROOT, process_starter, ros_environment, wait_until

PARTICIPANT = """
import rclpy
rclpy.init()
node = rclpy.create_node('participant')
print('here', flush=True)
rclpy.spin(node)
"""
PYTHON = ROOT / '.venv' / 'bin' / 'python'


def segments(process) -> set[str]:
    """Shared memory that a process has mapped."""
    maps = Path('/proc', str(process.pid), 'maps').read_text()
    return {line.split()[-1] for line in maps.splitlines() if '/dev/shm/fastrtps_' in line}


def test_domains_are_never_shared():
    other = (
        'from ros_processes import ros_environment\n'
        'with ros_environment() as env: print(env["ROS_DOMAIN_ID"])'
    )
    with ros_environment() as first, ros_environment() as second:
        result = subprocess.run(
            [PYTHON, '-c', other],
            env={**first, 'PYTHONPATH': str(ROOT / 'tests')},
            capture_output=True,
            text=True,
        )
        domains = {first['ROS_DOMAIN_ID'], second['ROS_DOMAIN_ID'], result.stdout.strip()}
    assert len(domains) == 3
    assert all(1 <= int(domain) <= 101 for domain in domains)


def test_killed_participants_leave_no_shared_memory_and_living_ones_keep_theirs(start, tmp_path):
    living = start([PYTHON, '-c', PARTICIPANT])
    living.wait_for_output('here')
    with (
        ros_environment() as elsewhere,
        process_starter(elsewhere, tmp_path / 'elsewhere') as start_elsewhere,
    ):
        killed = start_elsewhere([PYTHON, '-c', PARTICIPANT])
        killed.wait_for_output('here')
        left = segments(killed)
        kept = segments(living)
        assert left and kept and not left & kept
        killed.kill()
        killed.wait()
        assert any(Path(path).exists() for path in left)
    assert not any(Path(path).exists() for path in left)
    assert all(Path(path).exists() for path in kept)
    assert living.poll() is None


def test_children_that_outlive_their_parent_are_ended(ros_env, tmp_path):
    with process_starter(ros_env, tmp_path) as start:
        parent = start(['bash', '-c', 'sleep 300 & echo child $!'])
        parent.wait_for_output('child')
        child = Path('/proc', parent.stdout_text.split()[1])
        assert parent.wait(10) == 0
        assert child.exists()
    wait_until(
        lambda: not child.exists() or '\nState:\tZ' in (child / 'status').read_text(),
        'the end of the child',
    )
    assert parent.returncode != -signal.SIGKILL
