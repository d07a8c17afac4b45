"""Readers of files: what is read, and that everything else is one sentence."""

import io
import os
import zipfile

import numpy as np
import pytest

from neuro_controller.core.reading import (
    ReadingError,
    parse_json,
    read_arrays,
    read_bytes,
    read_text,
    reading,
)


def npy(array, **header):
    """The bytes of an .npy file, its header changed."""
    file = io.BytesIO()
    facts = {'descr': array.dtype.str, 'fortran_order': False, 'shape': array.shape, **header}
    np.lib.format.write_array_header_1_0(file, facts)
    return file.getvalue() + array.tobytes()


def archive(path, members, compression=zipfile.ZIP_STORED):
    with zipfile.ZipFile(path, 'w', compression) as file:
        for name, content in members:
            file.writestr(name, content)
    return path


@pytest.mark.parametrize('save', [np.savez, np.savez_compressed])
def test_arrays_come_back_as_numpy_wrote_them(tmp_path, save):
    arrays = {
        'fortran': np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        'text': np.array('né'),
        'empty': np.zeros((0, 442), np.float32),
        'scalar': np.int64(7),
    }
    save(tmp_path / 'a.npz', **arrays)
    found = read_arrays(tmp_path / 'a.npz')
    assert found.keys() == arrays.keys()
    for name, array in arrays.items():
        np.testing.assert_array_equal(found[name], array)
        assert found[name].dtype == np.asarray(array).dtype


def test_headers_that_promise_too_much_are_read_before_the_data(tmp_path):
    """14 GB are promised; with the limit that is set here, reserving them would raise."""
    small = np.zeros(4, np.float32)
    path = archive(tmp_path / 'a.npz', [('a.npy', npy(small, shape=(60_000, 60_000)))])
    with pytest.raises(ReadingError, match=r'a\.npy says that it has 14400000000 bytes of data'):
        read_arrays(path)
    zeros = npy(np.zeros(2**25, np.float32))
    path = archive(tmp_path / 'b.npz', [('b.npy', zeros)], zipfile.ZIP_DEFLATED)
    assert path.stat().st_size < 2**18
    with pytest.raises(ReadingError, match='at most 67108864'):
        read_arrays(path)


@pytest.mark.parametrize(
    ('members', 'sentence'),
    [
        ([], 'it lacks the array a'),
        ([('a.npy', npy(np.zeros(3)))] * 2, 'two arrays of one name'),
        ([('a.npy', b'nonsense')], 'magic'),
        ([('a.npy', npy(np.zeros(3))[:-1])], 'says that it has 24 bytes of data, expected 23'),
        ([('a.npy', npy(np.zeros(3), shape=(3, -1)))], r'has the shape \(3, -1\)'),
        ([('a.npy', npy(np.zeros(3), shape=(3, 'x')))], 'shape'),
        ([('a.npy', npy(np.zeros(3), descr='|O'))], 'holds object, expected numbers'),
        ([('a.npy', npy(np.zeros(3, complex)))], 'holds complex128'),
        ([('a.npy', npy(np.zeros(3), descr='what'))], 'what'),
        ([('a.npy', b'\x93NUMPY\x09\x00' + b'0' * 40)], 'unknown format version'),
    ],
)
@pytest.mark.filterwarnings('ignore:Duplicate name')
def test_other_arrays_are_refused(tmp_path, members, sentence):
    path = archive(tmp_path / 'a.npz', members)
    with pytest.raises(ReadingError, match=f'a.npz is damaged: .*({sentence})'):
        read_arrays(path, ['a'])


def test_a_wrong_byte_in_the_data_is_found(tmp_path):
    np.savez(tmp_path / 'a.npz', a=np.arange(1000))
    content = bytearray((tmp_path / 'a.npz').read_bytes())
    content[4000] ^= 1
    (tmp_path / 'a.npz').write_bytes(content)
    with pytest.raises(ReadingError, match='Bad CRC-32'):
        read_arrays(tmp_path / 'a.npz')


def test_what_is_no_file_is_said(tmp_path):
    os.mkfifo(tmp_path / 'pipe')
    (tmp_path / 'text').write_bytes('a\nb\u00e9'.encode('latin-1'))
    for path, sentence in (
        ('none', 'none cannot be read: No such file'),
        ('', 'cannot be read: Is a directory'),
        ('text/more', 'cannot be read: Not a directory'),
        ('text', r'text is damaged: line 2, byte 0xe9 is not UTF-8'),
        ('/dev/zero', '/dev/zero cannot be read: Is a device'),
    ):
        with pytest.raises(ReadingError, match=sentence):
            read_text(tmp_path / path, 1000)
    assert read_bytes(tmp_path / 'pipe', 1000) == b''
    with pytest.raises(ReadingError, match='pipe'):
        read_arrays(tmp_path / 'pipe')


def test_a_guard_makes_one_short_sentence_of_anything():
    for error in (ValueError('a\nb\n'), KeyError('k'), MemoryError(), RecursionError('x' * 9999)):
        with pytest.raises(ReadingError) as caught, reading('f'):
            raise error
        assert str(caught.value).startswith('f is damaged: ')
        assert '\n' not in str(caught.value)
        assert len(str(caught.value)) < 400
    with pytest.raises(KeyboardInterrupt), reading('f'):
        raise KeyboardInterrupt


def test_json_is_read_as_json():
    assert parse_json('{"a":\t1e-05, "b": [null, true]}') == {'a': 1e-05, 'b': [None, True]}
    for text in ('{"a": 1, "a": 2}', '{"a": NaN}', '{"a": -Infinity}', '{a: 1}', '[', '9' * 5000):
        with pytest.raises(ValueError):
            parse_json(text)
