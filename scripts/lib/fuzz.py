"""Damaged files, handed to the real commands: what `scripts/fuzz` does."""

import argparse
import collections
import contextlib
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import fuzz_mutations
import fuzz_subjects
from fuzz_subjects import Subject

CPU_SECONDS = 20
WALL_SECONDS = 120
MEMORY = 2**29
"""What one case may need, the last beside what the program itself takes, bytes."""

_ADDRESSES = 2**32

LONGEST = 1000
"""Characters of a sentence; the longest names every key of a configuration."""

OUTCOMES = ('refused', 'as before', 'otherwise', 'fault')


@dataclass(frozen=True)
class Outcome:
    """What became of a case: one of `OUTCOMES`, and why it is a fault."""

    kind: str
    reason: str = ''


def run(subject: Subject, folder: Path, expected: str | None, changed: str = '') -> Outcome:
    """Run the command of a subject on its files, in a process with limits.

    Parameters
    ----------
    subject : Subject
    folder : Path
        Its files.
    expected : str or None
        What the undamaged files gave; None where that is to be found out.
    changed : str
        Name of the file that was changed.
    """
    with tempfile.TemporaryDirectory(prefix='fuzz') as scratch:
        child = os.fork()
        if not child:
            _in_child(subject, folder, Path(scratch))
        _, status, used = os.wait4(child, 0)
        errors = Path(scratch, 'stderr').read_text(errors='replace')
        seen = Path(scratch, 'seen')
        given = seen.read_text() if seen.exists() else ''
    lines = [line for line in errors.splitlines() if line.strip()]
    if os.WIFSIGNALED(status):
        return Outcome('fault', f'ended by {signal.Signals(os.WTERMSIG(status)).name}')
    code = os.WEXITSTATUS(status)
    if code not in (0, 2):
        return Outcome('fault', f'exit code {code}: {lines[-1] if lines else ""}')
    if used.ru_maxrss * 1024 > _pages(1) + MEMORY:
        return Outcome('fault', f'it took {used.ru_maxrss / 1024:.0f} MB of memory')
    if code == 2:
        if len(lines) != 1:
            return Outcome('fault', f'{len(lines)} lines of error: {" | ".join(lines)[:300]}')
        if len(lines[0]) > LONGEST:
            return Outcome('fault', f'an error of {len(lines[0])} characters')
        return Outcome('refused', lines[0])
    if expected is None:
        return Outcome('as before', given)
    if given == expected:
        return Outcome('as before')
    if changed in subject.vouched:
        return Outcome('fault', f'damage of {changed} was not noticed')
    return Outcome('otherwise')


def _pages(column: int) -> int:
    """Return the memory of this process, bytes: its addresses (0) or what is resident (1)."""
    return int(Path('/proc/self/statm').read_text().split()[column]) * resource.getpagesize()


def _in_child(subject: Subject, folder: Path, scratch: Path) -> None:
    """Run the command and end the process."""
    code = 70
    try:
        for number, name in ((1, 'stdout'), (2, 'stderr')):
            os.dup2(os.open(scratch / name, os.O_WRONLY | os.O_CREAT), number)
        limit = _pages(0) + _ADDRESSES
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS))
        signal.alarm(WALL_SECONDS)
        os.chdir(scratch)
        code = subject.command(folder, lambda text: Path(scratch, 'seen').write_text(text))
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 70
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def fuzz(
    cases: int,
    seed: int,
    only: list[str],
    keep: Path | None,
    tell: Callable[[str], None] = lambda line: None,
) -> dict[str, collections.Counter]:
    """Run cases, each a mutation that follows from the seed and its number; Ctrl-C ends that.

    Returns
    -------
    dict
        Kind of file -> how often each of `OUTCOMES` came out.
    """
    table: dict[str, collections.Counter] = {}
    with tempfile.TemporaryDirectory(prefix='fuzz') as place:
        subjects = fuzz_subjects.make(Path(place), only)
        before = {}
        for subject in subjects:
            outcome = run(subject, subject.folder, None)
            if outcome.kind != 'as before':
                raise RuntimeError(f'{subject.name}, undamaged: {outcome.reason}')
            before[subject.name] = outcome.reason
            table[subject.name] = collections.Counter()
        with contextlib.suppress(KeyboardInterrupt):
            for number in range(cases):
                subject = subjects[number % len(subjects)]
                rng = random.Random(f'{seed} {number}')
                copy = Path(place, 'case')
                shutil.copytree(subject.folder, copy)
                done = fuzz_mutations.mutate(copy / subject.file, rng)
                outcome = run(subject, copy, before[subject.name], done.partition(':')[0])
                table[subject.name][outcome.kind] += 1
                if outcome.kind == 'fault':
                    tell(f'case {number}, {subject.name}, {done}: {outcome.reason}')
                    if keep:
                        keep.mkdir(parents=True, exist_ok=True)
                        subprocess.run(['cp', '-a', copy, keep / f'{number}'], check=True)
                shutil.rmtree(copy)
    return table


def main() -> int:
    """Run the script."""
    parser = argparse.ArgumentParser(prog='fuzz')
    parser.add_argument('--cases', type=int, default=2000)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--only', nargs='+', default=[])
    parser.add_argument('--keep', type=Path, default=Path('fuzz-faults'))
    options = parser.parse_args()
    table = fuzz(
        options.cases,
        options.seed,
        options.only,
        options.keep,
        lambda line: print(line, flush=True),
    )
    print(f'{"file":30}' + ''.join(f'{name:>12}' for name in ('cases', *OUTCOMES)))
    total = collections.Counter()
    for name, counts in [*table.items(), ('all', total)]:
        if counts is not total:
            total.update(counts)
        numbers = (counts.total(), *(counts[kind] for kind in OUTCOMES))
        print(f'{name:30}' + ''.join(f'{number:12}' for number in numbers))
    return int(total['fault'] > 0)


if __name__ == '__main__':
    sys.exit(main())
