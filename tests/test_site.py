"""The documentation site is built whole, and every link within it leads somewhere."""

import subprocess

from docs_hooks import API
from ros_processes import ROOT

import red_queen as rq


def test_site_builds_without_a_warning():
    result = subprocess.run(
        [ROOT / 'scripts' / 'docs'], stdin=subprocess.DEVNULL, capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
    page = (ROOT / 'site' / 'reference' / 'api.html').read_text()
    assert 'id="coevo_manager.core.episodes.play.evaluate_pairs"' in page


def test_every_public_name_is_on_the_page():
    shown = {name for names in API.values() for name in names}
    assert shown == set(rq.__all__) - {'SPECIES', 'WORLDS', '__version__'}
