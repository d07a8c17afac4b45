"""JSON and YAML within limits."""

import json
import tracemalloc

import pytest
import yaml

from coevo_manager.core.documents import DEPTH, NODES, parse_document, read_document
from coevo_manager.core.evolution import load_configuration
from neuro_controller.core.reading import ReadingError


@pytest.mark.parametrize(
    ('text', 'value'),
    [
        ('a: 1e-05', {'a': 1e-05}),
        ('{"a":\t1e-05,\n\t"b": 2}', {'a': 1e-05, 'b': 2}),
        ('a: -.5\nb: 1.\nc: 1.5E+3\nd: -0.0', {'a': -0.5, 'b': 1.0, 'c': 1500.0, 'd': -0.0}),
        ('a: 010\nb: 1:30\nc: no\nd: 1_000', {'a': '010', 'b': '1:30', 'c': 'no', 'd': '1_000'}),
        ('a: null\nb: ~\nc:\nd: true', {'a': None, 'b': None, 'c': None, 'd': True}),
        ('a: .\nb: "1"\nc: 2020-01-01', {'a': '.', 'b': '1', 'c': '2020-01-01'}),
        ('a: &x {k: 1}\nb: {<<: *x, z: 2}', {'a': {'k': 1}, 'b': {'k': 1, 'z': 2}}),
        ('', None),
    ],
)
def test_values(text, value):
    assert parse_document(text) == value


def test_a_configuration_is_the_same_in_json_and_yaml():
    values = load_configuration({'mutation_rate': 1e-05, 'cma_sigma': 1e-06}).as_dict()
    assert parse_document(json.dumps(values, indent='\t')) == values
    assert parse_document(yaml.safe_dump(values)) == values


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('a: [', r'line 1, column 5: expected the node content'),
        ('a: 1\na: 2', "line 2, column 1: the key 'a' is given twice"),
        ('{"a": 1, "a": 2}', "the key 'a' is given twice"),
        ('- 1\n\t- 2', 'line 2, column 1: found character'),
        ('a: !!python/object:os.system x', 'tags such as .* are not understood'),
        ('a: !!int 0xff', 'tags such as'),
        ('a: &a [1, *a]', 'line 1, column 11: the alias a stands within what it names'),
        ('a: *b', 'found undefined alias'),
        ('{[1]: 2}', 'found unhashable key'),
        ('--- 1\n--- 2', 'another document'),
        ('"\x00"', 'unacceptable character #x0000'),
        ('9' * 5000, 'digits'),
        ('[' * (DEPTH + 2), f'nested deeper than {DEPTH} levels'),
        ('- ' * 50_000, f'nested deeper than {DEPTH} levels'),
        ('[' * 100_000, f'nested deeper than {DEPTH} levels'),
        ('[1' + ', 1' * NODES + ' ,a]', f'more than {NODES} values and keys'),
    ],
)
def test_what_is_refused_and_where(text, sentence):
    with pytest.raises(ValueError, match=sentence) as caught:
        parse_document(text)
    assert '\n' not in str(caught.value)


def test_an_alias_bomb_costs_nothing():
    """Nine aliases of nine aliases of nine ...: 3.5 billion values in 300 bytes."""
    text = 'a: &a [x, x, x, x, x, x, x, x, x]\n' + ''.join(
        f'{name}: &{name} [{", ".join([f"*{before}"] * 9)}]\n'
        for before, name in zip('abcdefghi', 'bcdefghij', strict=True)
    )
    tracemalloc.start()
    with pytest.raises(ValueError, match=f'more than {NODES} values'):
        parse_document(text)
    assert tracemalloc.get_traced_memory()[1] < 5e6
    tracemalloc.stop()


def test_a_document_of_another_encoding_is_said(tmp_path):
    path = tmp_path / 'c.yaml'
    path.write_bytes('a: 1'.encode('utf-16'))
    with pytest.raises(ReadingError, match=r'c\.yaml is damaged: line 1, byte 0xff is not UTF-8'):
        read_document(path)
    path.write_bytes(b'\xef\xbb\xbfa: 1')
    assert read_document(path) == {'a': 1}
    path.write_text('a: [')
    with pytest.raises(ReadingError, match=r'c\.yaml is damaged: line 1, column 5'):
        read_document(path)
