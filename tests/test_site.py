"""The documentation site is built whole, its links lead somewhere, and it needs no network."""

import re
import subprocess

import pytest
from browser import ask, open_browser
from docs_hooks import API
from ros_processes import ROOT

import red_queen as rq


@pytest.fixture(scope='module')
def site():
    """The folder of the site, built without a warning."""
    result = subprocess.run(
        [ROOT / 'scripts' / 'docs'], stdin=subprocess.DEVNULL, capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
    return ROOT / 'site'


def test_the_reference_has_the_functions(site):
    page = (site / 'reference' / 'api.html').read_text()
    assert 'id="coevo_manager.core.episodes.play.evaluate_pairs"' in page


def test_no_page_loads_anything_from_elsewhere(site):
    loading = re.compile(
        r'<(?:script|img|iframe)[^>]*\ssrc="https?:|<link[^>]*stylesheet[^>]*https?:'
    )
    pages = list(site.rglob('*.html'))
    assert len(pages) > 30
    assert [page for page in pages if loading.search(page.read_text())] == []


@pytest.fixture
def page():
    with open_browser() as browser:
        browser.set_network_conditions(offline=True, latency=0, throughput=0)
        yield browser


def test_the_diagram_is_drawn_without_a_network(site, page):
    page.get((site / 'architecture.html').as_uri())
    assert ask(page, "document.querySelector('svg.flowchart').clientWidth") > 400
    drawn = ask(page, "document.querySelector('svg.flowchart').textContent")
    assert 'the compiled kernel' in drawn and 'every topic' in drawn
    assert page.get_log('browser') == []


def test_every_public_name_is_on_the_page():
    shown = {name for names in API.values() for name in names}
    assert shown == set(rq.__all__) - {'SPECIES', 'WORLDS', '__version__'}
