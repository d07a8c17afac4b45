"""Real ROS 2 processes in tests: an environment no other test shares, and a clean end."""

import contextlib
import os
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parent.parent
PATIENCE = 120.0
"""How long anything may take, s; a limit for what hangs, also where the machine is very busy.
The first time, a process compiles its kernels."""

END_TIMEOUT = 10.0
"""How long a process may take to end after SIGTERM before it is killed, s."""

FIRST_PORT, PORTS_EACH = 7400, 250
"""Where the UDP ports of DDS begin, and how many a domain has."""


@cache
def _workspace_environment() -> dict[str, str]:
    """``os.environ`` with the built workspace on its paths."""
    enter = f'source {ROOT}/scripts/lib/common.sh && enter_workspace && env -0'
    output = subprocess.run(
        ['bash', '-c', enter], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, check=True
    ).stdout.decode()
    return dict(entry.split('=', 1) for entry in output.split('\0') if entry)


@contextlib.contextmanager
def ros_environment() -> Iterator[dict[str, str]]:
    """Yield an environment with a ROS_DOMAIN_ID that no other test of this machine has now.

    A domain is held by its port: DDS takes the UDP port of that number, the test the TCP port, so
    that workers and concurrent suites, of any user, never share one.
    """
    for domain in range(1, 102):
        with socket.socket() as port:
            try:
                port.bind(('127.0.0.1', FIRST_PORT + PORTS_EACH * domain))
            except OSError:
                continue
            yield {
                **_workspace_environment(),
                'ROS_DOMAIN_ID': str(domain),
                'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
            }
            return
    raise RuntimeError('all ROS domains from 1 to 101 are taken by other tests')


def own_lines(text: str) -> str:
    """What a process printed, less the lines of Fast DDS about ports in shared memory.

    Participants of all domains of a machine take the next free one. Where it is another's, or was
    left by a killed process, Fast DDS says so and takes another (its issues 1095 and 6117).
    """
    lines = text.splitlines(keepends=True)
    return ''.join(line for line in lines if 'RTPS_TRANSPORT_SHM' not in line)


class Process(subprocess.Popen):
    """A process with its output in files, that can be read while it runs.

    Attributes
    ----------
    stdout_path, stderr_path : Path
    """

    def __init__(self, arguments: Sequence[str | Path], env: Mapping[str, str], folder: Path):
        self.stdout_path, self.stderr_path = folder / 'stdout', folder / 'stderr'
        with self.stdout_path.open('wb') as stdout, self.stderr_path.open('wb') as stderr:
            super().__init__(
                [str(argument) for argument in arguments],
                env=env,
                stdin=subprocess.DEVNULL,
                stdout=stdout,
                stderr=stderr,
                start_new_session=True,
            )

    @property
    def stdout_text(self) -> str:
        """What it printed so far."""
        return self.stdout_path.read_text(errors='replace')

    @property
    def stderr_text(self) -> str:
        """What it printed on stderr so far."""
        return own_lines(self.stderr_path.read_text(errors='replace'))

    def wait(self, timeout: float | None = PATIENCE) -> int:
        """Wait for its end and return its exit code; subprocess.TimeoutExpired if it has none."""
        return super().wait(timeout)

    def wait_for_output(self, text: str, timeout: float = PATIENCE) -> None:
        """Wait until it printed `text` on stdout or stderr; fails when it ends without it."""
        wait_until(
            lambda: text in self.stdout_text + self.stderr_text or self.poll() is not None,
            f'{text!r} from {self.args}',
            timeout,
        )
        if text not in self.stdout_text + self.stderr_text:
            raise AssertionError(
                f'{self.args} ended with {self.returncode} and never printed {text!r}:\n'
                f'{self.stdout_text}{self.stderr_text}'
            )

    def end(self) -> int:
        """End it, kill what it left behind, and return its exit code."""
        if self.poll() is None:
            self.terminate()
            try:
                self.wait(END_TIMEOUT)
            except subprocess.TimeoutExpired:
                self.kill()
                self.wait()
        with contextlib.suppress(ProcessLookupError):  # children that outlived it
            os.killpg(self.pid, signal.SIGKILL)
        return self.returncode


def wait_until(condition: Callable[[], object], what: str, timeout: float = PATIENCE) -> None:
    """Wait for a condition, polled each 20 ms; AssertionError naming `what` after `timeout` s."""
    deadline = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f'waited {timeout} s in vain for {what}')
        time.sleep(0.02)


def has_ended(process: psutil.Process) -> bool:
    """Tell whether a process has ended, be it that nobody asks how: process 1 of a container."""
    try:
        return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


@contextlib.contextmanager
def process_starter(env: Mapping[str, str], folder: Path) -> Iterator[Callable[..., Process]]:
    """Yield ``start(arguments, changes=None)``; what it started is ended when the block is left.

    `arguments` are ``[PACKAGE, EXECUTABLE, ...]`` of the workspace or a whole command line,
    `changes` variables of the environment to set otherwise.
    """
    started: list[Process] = []

    def start(
        arguments: Sequence[str | Path], changes: Mapping[str, str] | None = None
    ) -> Process:
        place = folder / f'process_{len(started)}'
        place.mkdir(parents=True)
        process = Process(_command(arguments), {**env, **(changes or {})}, place)
        started.append(process)
        return process

    try:
        yield start
    finally:
        for process in reversed(started):
            process.terminate()
        for process in reversed(started):
            process.end()


def _command(arguments: Sequence[str | Path]) -> list[str | Path]:
    package, *rest = arguments
    install = ROOT / 'ros2_ws' / 'install' / package
    if os.sep in str(package) or not install.is_dir():
        return list(arguments)
    return [install / 'lib' / package / rest[0], *rest[1:]]


def clean_shared_memory() -> None:
    """Remove the shared memory of participants that were killed; living ones keep theirs.

    Only while no participant starts: the tool may take a port that one is about to open, of any
    domain, for that of a dead one. It knows ports by their locks; those that lost theirs are
    removed here.
    """
    subprocess.run(
        [ROOT / '.venv' / 'bin' / 'fastdds', 'shm', 'clean'],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        check=True,
    )
    for port in Path('/dev/shm').glob('fastrtps_port*[0-9]'):
        if not any(Path(f'{port}_{lock}').exists() for lock in ('el', 'sl')):
            port.unlink(missing_ok=True)
            Path('/dev/shm', f'sem.{port.name}_mutex').unlink(missing_ok=True)
