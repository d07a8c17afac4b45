"""The chase as an animation: a GIF, or a film by ffmpeg."""

import contextlib
import errno
import io
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from coevo_manager.core.species import COLOURS
from coevo_manager.recording.drawing import RobotArtists, draw_arena
from marxbot_sim.core.parameters import TICK

FRAMES_PER_SECOND = 10
TRAIL = 50
"""Ticks of a robot's trail."""

CODECS = {
    '.mp4': ['-c:v', 'libx264', '-pix_fmt', 'yuv420p'],
    '.webm': ['-c:v', 'libvpx-vp9', '-pix_fmt', 'yuv420p'],
}
"""What ffmpeg is told for each kind of film."""


@dataclass(frozen=True)
class Pace:
    """Which ticks of an episode an animation shows, and how fast.

    Attributes
    ----------
    ticks : list of int
        One for each frame.
    rate : float
        Frames a second.
    """

    ticks: list
    rate: float

    @classmethod
    def of(cls, track, rate):
        """Return the pace that shows a track at `rate` times real time."""
        step = max(1, round(rate / (TICK * FRAMES_PER_SECOND)))
        last = len(track.poses) - 1
        return cls([*range(0, last, step), last], min(FRAMES_PER_SECOND, rate / (TICK * step)))


class Scene:
    """The arena with its robots; only what moves is drawn anew, over a copy of all else.

    Parameters
    ----------
    size : float
        Side of the arena, m.
    obstacle : bool
    """

    def __init__(self, size, obstacle):
        self._figure, axes = draw_arena(size, obstacle)
        self._title = axes.set_title(' ')
        self._trails = [axes.plot([], [], color=color, lw=1.5)[0] for color in COLOURS.values()]
        self._robots = [RobotArtists(axes, color) for color in COLOURS.values()]
        bodies = [artist for robot in self._robots for artist in robot.artists]
        self._moving = [self._title, *self._trails, *bodies]
        for artist in self._moving:
            artist.set_animated(True)
        self._canvas = FigureCanvasAgg(self._figure)
        self._canvas.draw()
        self._still = self._canvas.copy_from_bbox(self._figure.bbox)

    def draw(self, poses, title):
        """Return a picture, uint8 array of shape (height, width, 3).

        Parameters
        ----------
        poses : sequence of float arrays, shape (2, 3)
            Of the episode up to that time; the last `TRAIL` ticks leave trails.
        title : str
        """
        self._canvas.restore_region(self._still)
        self._title.set_text(title)
        seen = np.array(poses[-TRAIL - 1 :])
        for number, (robot, trail) in enumerate(zip(self._robots, self._trails, strict=True)):
            robot.move(seen[-1, number])
            trail.set_data(*seen[:, number, :2].T)
        for artist in self._moving:
            self._figure.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


def draw_frames(track, ticks):
    """Yield a picture (uint8 array, (height, width, 3)) for each tick."""
    scene = Scene(track.size, track.obstacle)
    for tick in ticks:
        title = track.title if tick == ticks[-1] else f'{tick * TICK:.1f} s'
        yield scene.draw(track.poses[: tick + 1], title)


def make_gif(track, pace, advance=lambda: None):
    """Return an animated GIF (bytes); `advance` is called after each frame."""
    frames = []
    for frame in draw_frames(track, pace.ticks):
        image = Image.fromarray(frame)
        palette = frames[0] if frames else image.quantize(64)
        frames.append(image.quantize(palette=palette, dither=Image.Dither.NONE))
        advance()
    content = io.BytesIO()
    frames[0].save(
        content,
        format='GIF',
        save_all=True,
        append_images=frames[1:],
        duration=round(1000 / pace.rate),
        loop=0,
        optimize=False,
    )
    return content.getvalue()


def make_film(track, pace, suffix, advance=lambda: None):
    """Return a film (bytes); `advance` is called after each frame.

    Parameters
    ----------
    suffix : str
        One of `CODECS`.

    Raises
    ------
    OSError
        ffmpeg fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        film = Path(folder, f'film{suffix}')
        encoder = None
        for frame in draw_frames(track, pace.ticks):
            height, width = (side - side % 2 for side in frame.shape[:2])
            if encoder is None:
                encoder = _start_encoder(film, width, height, pace.rate)
            try:
                encoder.stdin.write(frame[:height, :width].tobytes())
            except BrokenPipeError:
                break
            advance()
        _, complaint = encoder.communicate()
        if encoder.returncode:
            reason = ' '.join(complaint.decode(errors='replace').split())
            raise OSError(errno.EIO, f'ffmpeg failed: {reason}', film.name)
        return film.read_bytes()


def _start_encoder(film, width, height, rate):
    raw = ['-f', 'rawvideo', '-pix_fmt', 'rgb24', '-s', f'{width}x{height}', '-r', f'{rate:g}']
    called = [find_ffmpeg(), '-loglevel', 'error']
    command = [*called, *raw, '-i', '-', *CODECS[film.suffix], str(film)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)


def find_ffmpeg():
    """Return the machine's ffmpeg, or that of the Python package imageio-ffmpeg, or None."""
    found = shutil.which('ffmpeg')
    if found is None:
        with contextlib.suppress(ImportError, RuntimeError):
            from imageio_ffmpeg import get_ffmpeg_exe

            found = get_ffmpeg_exe()
    return found
