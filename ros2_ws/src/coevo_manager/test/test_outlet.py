"""Output whose reader goes away."""

import os
import subprocess
import sys

from coevo_manager.outlet import Outlet


def test_what_is_read_arrives(capsys):
    print('one', file=Outlet(), flush=True)
    assert capsys.readouterr().out == 'one\n'


def test_a_reader_that_has_gone_is_no_error():
    """Nor when the process ends, which flushes what was printed before."""
    code = (
        'import sys; from coevo_manager.outlet import Outlet\n'
        'outlet = Outlet()\n'
        'sys.stdin.readline()\n'
        'for _ in range(3): print("x" * 100_000, file=outlet, flush=True)\n'
        'outlet.write("y" * 10)\n'
    )
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(p for p in sys.path if p)}
    process = subprocess.Popen(
        [sys.executable, '-c', code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
    )
    process.stdout.close()
    errors = process.communicate(b'go\n')[1]
    assert (process.returncode, errors) == (0, b'')


def test_a_closed_output_is_no_error(monkeypatch):
    monkeypatch.setattr(sys, 'stdout', None)
    print('one', file=Outlet(), flush=True)


def test_a_full_disk_is_no_error():
    with open('/dev/full', 'w') as full:  # noqa: PTH123
        print('one', file=Outlet(full), flush=True)
