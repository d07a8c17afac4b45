"""The commands of the tutorials, one after the other, as a reader types them."""

import contextlib
import os
import re
import signal
import subprocess
import sys

import pytest
from ros_processes import ROOT

BLOCK = re.compile(
    r'^```(bash|python)( title="first terminal")?\n(.*?)^```$', re.MULTILINE | re.DOTALL
)


ANSWERS = [ROOT / 'scripts' / 'ros2', 'lifecycle', 'get', '/predator/controller']
"""What succeeds once the demo is up."""


@contextlib.contextmanager
def running(command, **settings):
    """Keep a command of the first terminal running, once it is up."""
    process = subprocess.Popen(command, shell=True, start_new_session=True, **settings)
    try:
        while subprocess.run(ANSWERS, **settings).returncode:
            assert process.poll() is None
        yield
        assert process.poll() is None, 'what should keep running has ended'
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
        process.wait(60)


@pytest.mark.timeout(900)
@pytest.mark.parametrize('page', ['researcher', 'roboticist'])
def test_every_command_works(page, ros_env, tmp_path):
    blocks = BLOCK.findall((ROOT / 'docs' / 'tutorials' / f'{page}.md').read_text())
    assert len(blocks) > 3
    settings = {'cwd': tmp_path, 'env': ros_env, 'stdin': subprocess.DEVNULL}
    with contextlib.ExitStack() as stack:
        for language, first_terminal, text in blocks:
            script = text.replace('scripts/', f'{ROOT}/scripts/')
            if first_terminal:
                quiet = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL}
                stack.enter_context(running(script, **settings, **quiet))
                continue
            shell = ['bash', '-e'] if language == 'bash' else [sys.executable]
            done = subprocess.run(
                [*shell, '-c', script], capture_output=True, text=True, **settings
            )
            assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / 'chase.png').exists()
