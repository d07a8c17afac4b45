"""Bags: their checksums, what damage and full disks make of them."""

import os

import numpy as np
import pytest
from full_disk import full_disk
from mcap.stream_reader import StreamReader
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message

from coevo_manager.recording.bag_reader import BagReader
from coevo_manager.recording.bag_writer import BagWriter

TICKS = 200


def write_bag(path, ticks=TICKS):
    """Write a bag of one topic with poses that hardly compress."""
    rng = np.random.default_rng(1)
    with BagWriter(path) as bag:
        bag.attach('notes.txt', 'text/plain', b'a note')
        bag.add_topic('/odom', 'nav_msgs/msg/Odometry', QoSProfile(depth=10))
        for tick in range(ticks):
            message = Odometry()
            message.header.stamp.sec = tick
            message.pose.covariance = rng.random(36)
            bag.write('/odom', serialize_message(message))


def test_a_bag_reads_back(tmp_path):
    write_bag(tmp_path / 'bag')
    with BagReader(tmp_path / 'bag') as bag:
        assert [round(when, 6) for _, when, _ in bag.messages()] == list(range(TICKS))
        assert bag.attachment('notes.txt') == b'a note'
        assert bag.attachment('other.txt') is None
        with pytest.raises(ValueError, match='holds no episode'):
            bag.episode()
    assert [path.name for path in tmp_path.iterdir()] == ['bag']


def test_every_chunk_and_the_whole_have_a_checksum(tmp_path):
    write_bag(tmp_path / 'bag')
    with (tmp_path / 'bag' / 'bag.mcap').open('rb') as file:
        records = list(StreamReader(file, emit_chunks=True).records)
    sums = [r.uncompressed_crc for r in records if type(r).__name__ == 'Chunk']
    assert sums and all(sums)
    assert next(r for r in records if type(r).__name__ == 'DataEnd').data_section_crc


def test_damage_at_any_place_is_one_sentence(tmp_path):
    write_bag(tmp_path / 'bag')
    rng = np.random.default_rng(7)
    found = 0
    for name in ('bag.mcap', 'metadata.yaml'):
        path = tmp_path / 'bag' / name
        sound = path.read_bytes()
        for _ in range(60):
            damaged = bytearray(sound)
            damaged[rng.integers(len(sound))] ^= 1 << rng.integers(8)
            path.write_bytes(
                damaged if rng.random() < 0.8 else damaged[: rng.integers(len(sound))]
            )
            try:
                with BagReader(tmp_path / 'bag') as bag:
                    messages = [data for _, _, data in bag.messages()]
            except ValueError as error:
                assert len(str(error).splitlines()) == 1, error
                found += 1
            else:  # in what tells nothing of the messages
                assert name == 'metadata.yaml' or len(messages) == TICKS
        path.write_bytes(sound)
    assert found > 60


@pytest.mark.timeout(60)
@pytest.mark.parametrize('name', ['bag.mcap', 'metadata.yaml', 'more.db3'])
def test_a_pipe_is_not_waited_for(tmp_path, name):
    write_bag(tmp_path / 'bag')
    path = tmp_path / 'bag' / name
    path.unlink(missing_ok=True)
    os.mkfifo(path)
    with pytest.raises(ValueError, match=f'{name}'), BagReader(tmp_path / 'bag'):
        pass


def test_a_damaged_chunk_is_found(tmp_path):
    write_bag(tmp_path / 'bag')
    path = tmp_path / 'bag' / 'bag.mcap'
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with (
        pytest.raises(ValueError, match=r'^[^\n]*bag is damaged: [^\n]+$'),
        BagReader(tmp_path / 'bag'),
    ):
        pass


@pytest.mark.parametrize('size', [0, 100, 10_000, 40_000])
def test_a_full_disk_leaves_nothing(tmp_path, size):
    write_bag(tmp_path / 'sound')
    assert (tmp_path / 'sound' / 'sound.mcap').stat().st_size > 40_000
    with (
        full_disk(size),
        pytest.raises(RuntimeError, match=r'bag cannot be written: File too large$'),
    ):
        write_bag(tmp_path / 'bag')
    assert [path.name for path in tmp_path.iterdir()] == ['sound']
