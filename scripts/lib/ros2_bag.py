"""``ros2 bag info``."""

from datetime import UTC, datetime
from pathlib import Path

import yaml
from rosbags.rosbag2 import Reader


def bag(arguments: list[str]) -> int:
    """Print what a bag holds, as ``ros2 bag info`` does.

    Raises
    ------
    ValueError
        Bad input, or a bag that cannot be read.
    """
    if len(arguments) != 2 or arguments[0] != 'info':
        raise ValueError(f'bag takes info BAG, got {" ".join(arguments) or "nothing"}')
    path = Path(arguments[1])
    if not path.is_dir():
        raise ValueError(f'{path} is not the folder of a bag')
    try:
        with Reader(path) as reader:
            lines = list(_lines(reader, path))
    except Exception as error:  # whatever a damaged file makes of the reader
        reason = ' '.join(str(error).split())[:300] or type(error).__name__
        raise ValueError(f'{path} is not a readable bag: {reason}') from None
    print(*lines, sep='\n')
    return 0


def _lines(reader, path):
    metadata = yaml.safe_load((path / 'metadata.yaml').read_text(encoding='utf-8'))
    information = metadata['rosbag2_bagfile_information']  # the reader has checked it
    files = [path / name for name in information['relative_file_paths']]
    yield f'Files:             {", ".join(file.name for file in files)}'
    yield f'Bag size:          {sum(file.stat().st_size for file in files) / 1024:.1f} KiB'
    yield f'Storage id:        {information["storage_identifier"]}'
    yield f'ROS Distro:        {information.get("ros_distro", "unknown")}'
    yield f'Duration:          {reader.duration / 1e9:.9f}s'
    yield f'Start:             {_moment(reader.start_time)}'
    yield f'End:               {_moment(reader.end_time)}'
    yield f'Messages:          {reader.message_count}'
    title = 'Topic information: '
    for connection in sorted(reader.connections, key=lambda connection: connection.topic):
        yield (
            f'{title}Topic: {connection.topic} | Type: {connection.msgtype} | '
            f'Count: {connection.msgcount} | Serialization Format: cdr'
        )
        title = ' ' * len(title)


def _moment(nanoseconds: int) -> str:
    moment = datetime.fromtimestamp(nanoseconds // 10**9, UTC)
    return f'{moment:%b %e %Y %H:%M:%S}.{nanoseconds % 10**9:09d} ({nanoseconds / 1e9:.9f})'
