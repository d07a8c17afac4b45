"""Pages of docs/ of which a script writes a part: that between two lines ``<!-- NAME -->``."""

import argparse
import math
import re
from pathlib import Path

from coevo_manager.core.evolution.files import write_whole


class MarkedPage:
    """A page with a part that is written anew.

    Parameters
    ----------
    path : Path
    name : str
        What its two marks say.

    Raises
    ------
    ValueError
        The page does not have two marks: one sentence.
    """

    def __init__(self, path, name):
        self._path = path
        self._mark = f'<!-- {name} -->\n'
        self._text = path.read_text() if path.is_file() else ''
        found = self._text.count(self._mark)
        if found != 2:
            raise ValueError(f'{path} has {found} lines {self._mark.strip()}, not 2')

    def fill(self, text):
        """Write the page with this text between its marks."""
        pattern = f'{re.escape(self._mark)}.*{re.escape(self._mark)}'
        part = f'{self._mark}\n{text}\n{self._mark}'
        page = re.sub(pattern, lambda _: part, self._text, flags=re.DOTALL)
        write_whole(self._path, page.encode())


def make_parser(program):
    """Make the command line of a script that fills a page from run folders."""
    parser = argparse.ArgumentParser(prog=program, add_help=False)
    parser.add_argument('page', type=Path)
    parser.add_argument('runs', type=Path, nargs='+')
    return parser


def markdown(header, rows):
    """Return a Markdown table; all cells are text."""
    lines = [header, ['---'] * len(header), *rows]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)


def probability(p):
    """Return the text of a probability; '' where it is NaN."""
    return '' if math.isnan(p) else '< 0.001' if p < 0.001 else f'{p:.3f}'
