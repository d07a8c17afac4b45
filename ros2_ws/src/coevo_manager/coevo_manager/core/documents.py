"""JSON and YAML that people, programs and the network hand us, within limits.

YAML is read with the scalars of JSON: a plain ``1e-05`` is a number, and ``010``, ``1:30`` or
``no`` are text, so that nothing is taken for another value than was written.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, NoReturn

import yaml

from neuro_controller.core.reading import parse_json, read_text, reading

DEPTH = 16
"""Levels that a document may be nested."""

NODES = 10_000
"""Values and keys that a document may have, once its aliases are replaced by what they name."""


def read_document(path: Path | str) -> Any:
    """Read a file that is JSON or YAML.

    Raises
    ------
    ReadingError
        One sentence.
    """
    text = read_text(path)
    with reading(path):
        return parse_document(text)


def parse_document(text: str) -> Any:
    """Return what a text says that is JSON or YAML.

    Raises
    ------
    ValueError
        It is neither, or exceeds `DEPTH` or `NODES`: what is wrong, and in which line.
    """
    try:
        return parse_json(text)
    except (ValueError, RecursionError):
        pass
    try:
        return yaml.load(text, _Loader)
    except yaml.MarkedYAMLError as error:
        _refuse(error.problem_mark, error.problem or 'it ends too soon')
    except yaml.YAMLError as error:
        raise ValueError(' '.join(str(error).split())) from None


def _refuse(mark: Any, problem: str) -> NoReturn:
    where = f'line {mark.line + 1}, column {mark.column + 1}: ' if mark is not None else ''
    raise ValueError(f'{where}{problem}') from None


class _Loader(yaml.SafeLoader):
    yaml_implicit_resolvers: dict = {}  # noqa: RUF012 (PyYAML's)

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._depth = 0
        self._nodes = 0
        self._sizes: dict[str | None, int] = {}

    def compose_node(self, parent, index):
        """Compose a node, counting what it costs."""
        event = self.peek_event()
        before = self._nodes
        if isinstance(event, yaml.AliasEvent):
            if event.anchor in self.anchors and event.anchor not in self._sizes:
                _refuse(event.start_mark, f'the alias {event.anchor} stands within what it names')
            self._nodes += self._sizes.get(event.anchor, 0)
        elif event.tag is not None:
            _refuse(event.start_mark, f'tags such as {event.tag[:60]!r} are not understood')
        self._nodes += 1
        if self._nodes > NODES:
            _refuse(event.start_mark, f'there are more than {NODES} values and keys')
        if self._depth > DEPTH:
            _refuse(event.start_mark, f'it is nested deeper than {DEPTH} levels')
        self._depth += 1
        node = super().compose_node(parent, index)
        self._depth -= 1
        if event.anchor is not None:
            self._sizes[event.anchor] = self._nodes - before
        return node

    def compose_mapping_node(self, anchor):
        """Compose a mapping whose keys differ."""
        node = super().compose_mapping_node(anchor)
        seen = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in seen:
                    _refuse(key.start_mark, f'the key {key.value[:60]!r} is given twice')
                seen.add(key.value)
        return node


for _tag, _pattern, _first in (
    ('null', '~|null|', ['~', 'n', '']),
    ('bool', 'true|false', ['t', 'f']),
    ('int', '-?(0|[1-9][0-9]*)', list('-0123456789')),
    (
        'float',
        r'-?(0|[1-9][0-9]*)?((\.[0-9]+|(?<=[0-9])\.)([eE][-+]?[0-9]+)?|(?<=[0-9])[eE][-+]?[0-9]+)',
        list('-.0123456789'),
    ),
    ('merge', '<<', ['<']),
):
    _Loader.add_implicit_resolver(
        f'tag:yaml.org,2002:{_tag}', re.compile(f'^(?:{_pattern})$'), _first
    )
