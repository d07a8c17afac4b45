"""What scripts/soak does: runs of the tests under load, counted."""

import argparse
import contextlib
import json
import os
import re
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TESTS = {
    'processes': ['-m', 'processes'],
    'suite': [],
    'records': [
        *('tests/test_packet_loss.py', '-k', 'recording'),
        *('--count', '100', '--dist', 'load'),
    ],
}
LOADS = ('quiet', 'busy', 'one_core')
ROWS = {
    'processes quiet': 10,
    'processes busy': 10,
    'processes one_core': 10,
    'suite busy': 5,
    'suite one_core': 5,
    'records quiet': 1,
}
"""Runs of each row, a set of tests and a load."""


@contextlib.contextmanager
def busy_loops(count):
    """Keep `count` processes busy while the block runs."""
    loops = [subprocess.Popen([sys.executable, '-c', 'while True: pass']) for _ in range(count)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def run(tests, load, log):
    """Run the tests once; what happened: `passed`, `failed` (names) and `seconds`."""
    prefix = ['taskset', '-c', str(min(os.sched_getaffinity(0)))] if load == 'one_core' else []
    start = time.monotonic()
    with busy_loops(2 if load == 'busy' else 0), log.open('wb') as output:
        code = subprocess.run(
            [*prefix, ROOT / 'scripts' / 'test', '-q', *TESTS[tests]],
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
        ).returncode
    text = log.read_text(errors='replace')
    failed = re.findall(r'^(?:FAILED|ERROR) (\S+)', text, re.MULTILINE)
    counted = re.search(r'(\d+) passed', text)
    return {
        'code': code,
        'passed': int(counted[1]) if counted else 0,
        'failed': failed,
        'seconds': round(time.monotonic() - start),
    }


def results(out, row, runs):
    """Yield the results of a row's runs; those that ended before are read, the others made."""
    tests, load = row.split()
    for number in range(1, runs + 1):
        log = out / f'{tests}_{load}_{number}.log'
        summary = log.with_suffix('.json')
        if not summary.exists():
            result = run(tests, load, log)
            beside = summary.with_suffix('.part')
            beside.write_text(json.dumps(result))
            beside.rename(summary)
        result = json.loads(summary.read_text())
        outcome = 'passed' if result['code'] == 0 else f'failed: {" ".join(result["failed"])}'
        print(f'{row} {number}: {outcome}, {result["seconds"]} s', file=sys.stderr, flush=True)
        yield result


def main():
    """Make the runs and print the table; 1 if one failed."""
    parser = argparse.ArgumentParser(prog='scripts/soak', usage=argparse.SUPPRESS)
    parser.add_argument('--only', nargs='+', metavar='ROW', choices=ROWS, default=list(ROWS))
    parser.add_argument('--runs', type=int, metavar='N')
    parser.add_argument('--out', type=Path, metavar='FOLDER', default=ROOT / 'soak')
    options = parser.parse_args()
    if options.runs is not None and options.runs < 1:
        parser.error(f'--runs must be at least 1, got {options.runs}')
    options.out.mkdir(parents=True, exist_ok=True)
    table = ['| tests | load | runs | green | tests a run | seconds, median (range) | failures |']
    table.append('|---|---|--:|--:|--:|--:|---|')
    green = True
    for row in options.only:
        found = list(results(options.out, row, options.runs or ROWS[row]))
        passed = [result for result in found if result['code'] == 0]
        green = green and len(passed) == len(found)
        seconds = [result['seconds'] for result in found]
        failures = sorted({name for result in found for name in result['failed']})
        table.append(
            f'| {" | ".join(row.split())} | {len(found)} | {len(passed)} '
            f'| {max(result["passed"] for result in found)} '
            f'| {statistics.median(seconds):.0f} ({min(seconds)} to {max(seconds)}) '
            f'| {", ".join(failures) or "none"} |'
        )
    print('\n'.join(table))
    return 0 if green else 1


if __name__ == '__main__':
    sys.exit(main())
