"""Mutations of files: any bytes, texts that are nearly right, and arrays that are wrong."""

import io
import os
import random
import re
import warnings
import zipfile
from pathlib import Path

import numpy as np

WORDS = (
    *('-1', '0', '1e-05', '1e400', 'NaN', '.inf', '010', '0x10', '1_000', '1:30', '9' * 5000),
    *('1.5', 'true', 'no', 'null', '~', '""', "'", '"', '[]', '{}', '[', ']', '{', '}', ':', ','),
    *('*a', '&a', '!!int', '!!python/object:x', '#', '- ', '? ', '<<', '%', '\t', '\r\n', '\x00'),
    *('\x07', '\u2028', '\u00e9', '\U0001f400', '<', '>', '&x;', '</launch>', '$(var x)'),
    *('$(env HOME)', '/', '../..', 'x' * 300, '[' * 50, '{a: ' * 50),
)


def mutate(path: Path, rng: random.Random) -> str:
    """Damage a file, or a folder of files, in one way; returns what was done."""
    if path.is_dir():
        path = rng.choice(sorted(p for p in path.rglob('*') if p.is_file()))
    kinds = [*BYTES] * 2 + [*PLACES]
    if path.suffix == '.npz':
        kinds += [*ARRAYS] * 4
    elif path.suffix != '.mcap':
        kinds += [*TEXTS] * 3
    kind = rng.choice(kinds)
    kind(path, rng)
    return f'{path.name}: {kind.__name__.strip("_")}'


def _bytes(change):
    def mutation(path, rng):
        content = bytearray(path.read_bytes())
        path.write_bytes(bytes(change(content, rng)))

    mutation.__name__ = change.__name__
    return mutation


def _span(content, rng, longest=200):
    start = rng.randrange(len(content) + 1)
    return start, min(len(content), start + rng.randint(1, longest))


def flip_a_bit(content, rng):
    if content:
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    return content


def set_bytes(content, rng):
    for _ in range(rng.randint(1, 8)):
        if content:
            content[rng.randrange(len(content))] = rng.randrange(256)
    return content


def insert_bytes(content, rng):
    place = rng.randrange(len(content) + 1)
    return content[:place] + rng.randbytes(rng.randint(1, 50)) + content[place:]


def delete_a_span(content, rng):
    start, end = _span(content, rng)
    return content[:start] + content[end:]


def repeat_a_span(content, rng):
    start, end = _span(content, rng)
    return content[:end] + content[start:end] * rng.randint(1, 20) + content[end:]


def zero_a_span(content, rng):
    start, end = _span(content, rng)
    return content[:start] + bytes(end - start) + content[end:]


def cut_the_end(content, rng):
    return content[: rng.randrange(len(content) + 1)]


def cut_the_start(content, rng):
    return content[rng.randrange(len(content) + 1) :]


def append_bytes(content, rng):
    return content + rng.randbytes(rng.randint(1, 5000))


def be_random(content, rng):
    return rng.randbytes(rng.randint(0, 2000))


BYTES = tuple(
    map(
        _bytes,
        (
            *(flip_a_bit, set_bytes, insert_bytes, delete_a_span, repeat_a_span, zero_a_span),
            *(cut_the_end, cut_the_start, append_bytes, be_random),
        ),
    )
)


def be_a_folder(path, rng):
    path.unlink()
    path.mkdir()


def be_missing(path, rng):
    path.unlink()


def be_a_pipe(path, rng):
    path.unlink()
    os.mkfifo(path)


def be_a_link_to_itself(path, rng):
    path.unlink()
    path.symlink_to(path)


def be_endless(path, rng):
    path.unlink()
    path.symlink_to('/dev/zero')


PLACES = (be_a_folder, be_missing, be_a_pipe, be_a_link_to_itself, be_endless)


def _text(change):
    def mutation(path, rng):
        path.write_bytes(change(path.read_text('utf-8', 'replace'), rng))

    mutation.__name__ = change.__name__
    return mutation


def replace_a_value(text, rng):
    found = list(re.finditer(r'[\w.+-]+', text))
    if not found:
        return b''
    match = rng.choice(found)
    return (text[: match.start()] + rng.choice(WORDS) + text[match.end() :]).encode()


def insert_a_word(text, rng):
    place = rng.randrange(len(text) + 1)
    return (text[:place] + rng.choice(WORDS) + text[place:]).encode()


def _lines(text, rng, change):
    lines = text.splitlines(keepends=True)
    if lines:
        change(lines, rng.randrange(len(lines)))
    return ''.join(lines).encode()


def repeat_a_line(text, rng):
    return _lines(text, rng, lambda lines, k: lines.insert(k, lines[k]))


def drop_a_line(text, rng):
    return _lines(text, rng, lambda lines, k: lines.pop(k))


def swap_lines(text, rng):
    def change(lines, k):
        other = rng.randrange(len(lines))
        lines[k], lines[other] = lines[other], lines[k]

    return _lines(text, rng, change)


def indent_a_line(text, rng):
    def change(lines, k):
        lines[k] = rng.choice(('\t', ' ', '    ')) + lines[k]

    return _lines(text, rng, change)


def nest_deeply(text, rng):
    bracket = rng.choice(('[', '{', '{"a": ', '- ', '<group>', '('))
    return _inserted(text, rng, bracket * rng.choice((20, 2000, 60_000)))


def bomb(text, rng):
    """Hand over a few hundred bytes that stand for thousands of millions of values."""
    levels = 'bcdefghij'
    if rng.random() < 0.3:
        entities = ''.join(
            f'<!ENTITY {name} "{f"&{before};" * 10}">'
            for before, name in zip('a' + levels, levels, strict=False)
        )
        return f'<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">{entities}]><launch>&j;</launch>'.encode()
    kinds = ('[{}]', '{{x: [{}]}}', '{{<<: [{}]}}')
    kind = rng.choice(kinds)
    first = '{k: 1}' if kind == kinds[2] else '[x, x, x]'
    aliases = ''.join(
        f'{name}: &{name} ' + kind.format(', '.join([f'*{before}'] * 9)) + '\n'
        for before, name in zip('a' + levels, levels, strict=False)
    )
    return f'a: &a {first}\n{aliases}'.encode()


def refer_to_itself(text, rng):
    return _inserted(text, rng, '&a [*a]')


def grow(text, rng):
    return text.encode() + rng.choice((b'#', b'\n', b'x', b' ', b'- a\n', b'a: 1\n')) * 3_000_000


def other_encoding(text, rng):
    encoding = rng.choice(('utf-16', 'utf-32', 'latin-1', 'cp037', 'utf-8-sig', 'shift-jis'))
    return (text + '\u00e9' * (encoding == 'latin-1')).encode(encoding, 'replace')


def windows_lines(text, rng):
    return text.replace('\n', rng.choice(('\r\n', '\r'))).encode()


def tabs(text, rng):
    return text.replace('  ', '\t').encode()


def _inserted(text, rng, what):
    found = [match.end() for match in re.finditer(r'[:=,>] ?', text)] or [0]
    place = rng.choice(found)
    return (text[:place] + what + text[place:]).encode()


TEXTS = tuple(
    map(
        _text,
        (
            *(replace_a_value, replace_a_value, insert_a_word, repeat_a_line, drop_a_line),
            *(swap_lines, indent_a_line, nest_deeply, bomb, refer_to_itself, grow),
            *(other_encoding, windows_lines, tabs),
        ),
    )
)


def _arrays(change):
    def mutation(path, rng):
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
        name = rng.choice(sorted(arrays))
        members = change(arrays, name, rng)
        compressions = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
        with warnings.catch_warnings():
            warnings.simplefilter('ignore')
            with zipfile.ZipFile(path, 'w', rng.choice(compressions)) as file:
                for member, content in members:
                    file.writestr(f'{member}.npy', content)

    mutation.__name__ = change.__name__
    return mutation


def _npy(array, **header):
    file = io.BytesIO()
    if array.dtype.hasobject:
        np.lib.format.write_array(file, array, allow_pickle=True)
        return file.getvalue()
    facts = {'descr': array.dtype.str, 'fortran_order': False, 'shape': array.shape, **header}
    np.lib.format.write_array_header_1_0(file, facts)
    return file.getvalue() + array.tobytes()


def _members(arrays):
    return [(name, _npy(array)) for name, array in arrays.items()]


def drop_an_array(arrays, name, rng):
    arrays.pop(name)
    return _members(arrays)


def rename_an_array(arrays, name, rng):
    arrays[name + 's'] = arrays.pop(name)
    return _members(arrays)


def repeat_an_array(arrays, name, rng):
    return [*_members(arrays), (name, _npy(arrays[name]))]


def other_shape(arrays, name, rng):
    array = arrays[name]
    shapes = (array[None], array.ravel()[:1], array.ravel()[:0], array.T[..., None], array.ravel())
    arrays[name] = rng.choice(shapes)
    return _members(arrays)


def other_type(arrays, name, rng):
    kinds = (np.complex64, 'U3', 'S3', np.float16, np.int8, bool, np.float64, '>f4')
    try:
        arrays[name] = arrays[name].astype(rng.choice(kinds))
    except ValueError:
        arrays[name] = np.zeros(arrays[name].shape)
    return _members(arrays)


def objects(arrays, name, rng):
    arrays[name] = np.array([rng, {}], object)
    return _members(arrays)


def other_numbers(arrays, name, rng):
    array = np.array(arrays[name])
    if array.dtype.kind in 'fiu':
        values = (-1, 1e9) if array.dtype.kind != 'f' else (-1, 1e30, np.nan, np.inf, 7)
        start = rng.randrange(max(array.size, 1))
        with np.errstate(all='ignore'):
            array.reshape(-1)[start : start + 3] = np.array(rng.choice(values)).astype(array.dtype)
    arrays[name] = array
    return _members(arrays)


def promise_too_much(arrays, name, rng):
    shape = rng.choice(((60_000, 60_000), (2**40,), (2**62, 4), (-1,), (0, 2**60), (10**30,)))
    return [
        (other, _npy(array, **({'shape': shape} if other == name else {})))
        for other, array in arrays.items()
    ]


def odd_header(arrays, name, rng):
    headers = ({'descr': 'what'}, {'shape': 'x'}, {'descr': '|O'}, {'descr': [('a', '<f4')]})
    header = rng.choice(headers)
    return [
        (other, _npy(array, **(header if other == name else {})))
        for other, array in arrays.items()
    ]


def expand(arrays, name, rng):
    arrays[name] = np.zeros(2**26, np.float32)
    return _members(arrays)


ARRAYS = tuple(
    map(
        _arrays,
        (
            *(drop_an_array, rename_an_array, repeat_an_array, other_shape, other_type, objects),
            *(other_numbers, other_numbers, promise_too_much, odd_header, expand),
        ),
    )
)
