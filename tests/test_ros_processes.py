"""The help that other tests lean on: own domains, a clean end."""

import signal
import subprocess
from pathlib import Path

from ros_processes import ROOT, own_lines, process_starter, ros_environment, wait_until

PYTHON = ROOT / '.venv' / 'bin' / 'python'


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


def test_only_lines_about_shared_memory_are_left_out():
    dds = '\x1b[37;1m2026-12-01 \x1b[31;1m[\x1b[37;1mRTPS_TRANSPORT_SHM\x1b[31;1m Error] ...\n'
    assert own_lines(f'first\n{dds}\nsecond') == 'first\n\nsecond'


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
