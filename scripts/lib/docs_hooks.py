"""What the documentation site adds to docs/: the project's other pages, and generated reference.

Pages outside docs/ are shown where `OUTSIDE` says, files that pages link to are copied, and links
are turned to where their targets are shown. So one page serves the repository's reader and the
site's. Diagrams are drawn when the site is built, since the theme would load a program for them
from elsewhere.
"""

import functools
import html
import os
import re
import subprocess
import sys
from pathlib import Path

import mermaidx
from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ROOT / 'ros2_ws' / 'src'

OUTSIDE = {
    **{path: f'project/{path.name}' for path in ROOT.glob('*.md')},
    **{path: f'packages/{path.parent.name}.md' for path in PACKAGES.glob('*/README.md')},
    ROOT / 'examples' / 'README.md': 'examples/README.md',
}
"""Pages outside docs/ -> their place in the site."""

DIAGRAM = re.compile('<pre class="mermaid"><code>(.*?)</code></pre>', re.DOTALL)

LINK = re.compile(r'\]\((?!https?:|mailto:|#)([^)#\s]*)(#[^)\s]*)?\)')

API = {
    'Runs and genomes': ('read_run', 'read_snapshot', 'select_champion', 'random_genomes'),
    'Where episodes are played': ('Environment', 'Perturbations', 'make_environment'),
    'Episodes': (
        'evaluate_pairs',
        'evaluate_matrix',
        'measure_pairs',
        'fitness',
        'trace_pair',
        'trace_pairs',
    ),
    'Pictures': ('plot_chase', 'animate_chase'),
    'Evolution': ('evolve', 'resume', 'Configuration'),
    'Analysis': ('analyze',),
    'What they return': (
        'Champion',
        'Replication',
        'Snapshot',
        'Trace',
        'Outcome',
        'GenerationStats',
        'PhaseStats',
        'RunFolderError',
    ),
}
"""The names of `red_queen`, in the order of the page; a test compares it with them."""


def on_files(files, config):
    """Add the pages from outside docs/, the files that pages link to, and the generated pages."""
    for path, place in OUTSIDE.items():
        files.append(File.generated(config, place, content=path.read_text()))
    pages = [*OUTSIDE, *(ROOT / 'docs').rglob('*.md')]
    linked = {
        target
        for page in pages
        for match in LINK.finditer(page.read_text())
        if (target := _target(page, match[1])).is_file()
        and target not in OUTSIDE
        and not target.is_relative_to(ROOT / 'docs')
    }
    for target in sorted(linked):
        files.append(File.generated(config, _place(target), abs_src_path=str(target)))
    files.append(File.generated(config, 'reference/commands.md', content=_commands()))
    files.append(File.generated(config, 'reference/api.md', content=_api()))
    return files


def on_page_markdown(markdown, page, config, files):
    """Turn links to where the site shows their targets."""
    sources = {place: path for path, place in OUTSIDE.items()}
    source = sources.get(page.file.src_uri, ROOT / 'docs' / page.file.src_uri)

    def turn(match):
        target = _target(source, match[1])
        place = os.path.relpath(_place(target), Path(page.file.src_uri).parent)
        return f']({place}{match[2] or ""})'

    return LINK.sub(turn, markdown)


def on_page_content(content, page, config, files):
    """Draw the page's diagrams."""
    return DIAGRAM.sub(lambda match: _draw(html.unescape(match[1])), content)


@functools.cache
def _draw(diagram):
    return f'<div style="background: white">{mermaidx.render(diagram).svg()}</div>'


def _target(page, link):
    target = (page.parent / link).resolve()
    return target / 'README.md' if (target / 'README.md').is_file() else target


def _place(target):
    """Return where the site shows a file."""
    if target in OUTSIDE:
        return OUTSIDE[target]
    if target.is_relative_to(ROOT / 'docs'):
        return str(target.relative_to(ROOT / 'docs'))
    return f'files/{target.relative_to(ROOT)}'


def _commands():
    """Return a page with what every command says of itself."""
    lines = ['# Commands and options', '', 'What each says when it is asked for `--help`.', '']
    lines += ['## Executables', '']
    for path in sorted((ROOT / 'ros2_ws' / 'install').glob('*/lib/*/*')):
        if not path.is_file() or not os.access(path, os.X_OK):
            continue
        lines += _help(f'{path.parent.name} {path.name}', [path, '--help'])
    lines += ['## Scripts', '']
    for path in sorted(path for path in (ROOT / 'scripts').iterdir() if path.is_file()):
        lines += _help(f'scripts/{path.name}', [path, '--help'])
    return '\n'.join(lines)


def _help(title, command):
    told = subprocess.run(
        [str(part) for part in command],
        env={**os.environ, 'COLUMNS': '96'},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=120,
    )
    if told.returncode:
        sys.exit(f'docs: {title} --help failed: {told.stderr}')
    return [f'### {title}', '', '```text', told.stdout.rstrip(), '```', '']


def _api():
    """Return a page of the library's public names."""
    import red_queen
    from red_queen import environments

    parts = [(title, red_queen, names) for title, names in API.items()]
    parts.append(('red_queen.environments', environments, environments.__all__))
    lines = ['# Python API', '', 'Everything is imported from `red_queen`, or as headed.', '']
    for title, module, names in parts:
        lines += [f'## {title}', '']
        for name in names:
            public = getattr(module, name)
            lines += [f'::: {public.__module__}.{public.__qualname__}', '']
    return '\n'.join(lines)
