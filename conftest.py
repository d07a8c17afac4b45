"""Fixtures that every test may use, and what is done when all have ended."""

import subprocess

import pytest
from ros_processes import ROOT, clean_shared_memory, process_starter, ros_environment

MARKERS = {'browser': {'page'}, 'processes': {'ros_env', 'env'}}
"""Markers, and the fixtures whose tests bear them."""


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


@pytest.fixture(scope='module')
def env():
    """As `ros_env`, one for all tests of a module."""
    with ros_environment() as environment:
        yield environment


@pytest.fixture(scope='module')
def starter(env, tmp_path_factory):
    """As `start`, in `env`; what it started is ended with the module."""
    with process_starter(env, tmp_path_factory.mktemp('processes')) as the_starter:
        yield the_starter


@pytest.fixture(scope='module')
def client(env):
    """A `RosClient` in `env`."""
    from ros_client import ros_client  # here, so that tests without ROS load none of it

    with ros_client(env) as the_client:
        yield the_client


@pytest.fixture(scope='session')
def packets_library(tmp_path_factory):
    """The compiled tests/packets.c, to be preloaded."""
    library = tmp_path_factory.mktemp('packets') / 'packets.so'
    source = ROOT / 'tests' / 'packets.c'
    subprocess.run(
        ['cc', '-Wall', '-Werror', '-shared', '-fPIC', '-o', library, source, '-ldl'], check=True
    )
    return library


def pytest_collection_modifyitems(items):
    """Mark the tests that open web pages or start ROS processes, by their fixtures."""
    for item in items:
        for marker, fixtures in MARKERS.items():
            if not fixtures.isdisjoint(item.fixturenames):
                item.add_marker(marker)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Count a skipped test as failed: it proves nothing."""
    report = yield
    if report.skipped and not hasattr(report, 'wasxfail'):
        report.outcome = 'failed'
    return report


def pytest_sessionfinish(session):
    """Remove what killed participants left in shared memory, once all workers are done."""
    if not hasattr(session.config, 'workerinput'):
        clean_shared_memory()
