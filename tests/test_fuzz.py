"""Damaged files of every kind that a command reads."""

import subprocess

import pytest
from ros_processes import ROOT


@pytest.mark.timeout(900)
def test_a_hundred_damaged_files(tmp_path):
    """`scripts/fuzz` without arguments plays two thousand."""
    result = subprocess.run(
        [ROOT / 'scripts' / 'fuzz', '--cases', '100', '--keep', tmp_path / 'faults'],
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.splitlines()[-1].split()[:2] == ['all', '100']
