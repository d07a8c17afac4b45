"""Fixtures that every test may use."""

import pytest
from ros_processes import process_starter, ros_environment


@pytest.fixture
def ros_env():
    """Environment of a process that talks ROS 2 with this test's processes only."""
    with ros_environment() as env:
        yield env


@pytest.fixture
def start(ros_env, tmp_path):
    """``start(['PACKAGE', 'EXECUTABLE', ...])`` or ``start([program, ...])`` -> `Process`.

    It runs in `ros_env`, its output is captured, and it is ended with the test.
    """
    with process_starter(ros_env, tmp_path) as starter:
        yield starter
