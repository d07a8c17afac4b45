"""Which version of the program this is, where it runs from a checkout."""

from __future__ import annotations

import functools
import subprocess
from pathlib import Path


@functools.cache
def source_commit() -> str:
    """Return the commit of this file's checkout, with '-dirty' after changes; '' without one."""
    here = Path(__file__).resolve()
    if not _git(here.parent, 'ls-files', here.name):  # of another project, or of none
        return ''
    return _git(here.parent, 'describe', '--always', '--dirty', '--exclude=*', '--abbrev=12')


def _git(folder: Path, *arguments: str) -> str:
    try:
        done = subprocess.run(
            ['git', '-C', str(folder), *arguments],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=10,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ''
    return done.stdout.strip() if done.returncode == 0 else ''
