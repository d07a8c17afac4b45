"""Links between the project's own pages lead somewhere."""

import re

import pytest
from ros_processes import ROOT

PAGES = [
    *ROOT.glob('*.md'),
    *ROOT.glob('docs/**/*.md'),
    *ROOT.glob('ros2_ws/src/*/README.md'),
]


@pytest.mark.parametrize('page', PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_relative_links_exist(page):
    targets = re.findall(r'\]\((?!https?:|mailto:)([^)#]*)', page.read_text())
    assert [target for target in targets if not (page.parent / target).exists()] == []
