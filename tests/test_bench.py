"""scripts/bench: it measures, in its quick form."""

import json

import pytest
from ros_processes import ROOT


@pytest.mark.timeout(600)
def test_it_measures_the_kernel_and_the_loop_through_services(start, tmp_path):
    results = tmp_path / 'results.json'
    sections = ('batch', 'services')
    bench = start([ROOT / 'scripts' / 'bench', '--quick', '--only', *sections, '--json', results])
    assert bench.wait(480) == 0, bench.stderr_text
    measured = json.loads(results.read_text())['results']
    for name in ('small batches : large, open', 'evolve : kernel'):
        assert name in measured
    assert all(value > 0 for result in measured.values() for value in result['values'])
