"""Pictures of a running chase: as an array, or in a window."""

from __future__ import annotations

from typing import Any

import numpy as np

from marxbot_sim.core.parameters import TICK, Arena


class Picture:
    """The arena as it is now, with the robots' trails.

    Parameters
    ----------
    arena : Arena
    mode : str, optional
        'rgb_array' makes pictures when asked; 'human' shows one after each tick, in real time;
        None, neither.
    """

    def __init__(self, arena: Arena, mode: str | None) -> None:
        self._arena = arena
        self._mode = mode
        self._poses: list[np.ndarray] = []
        self._scene: Any = None
        self._window: Any = None

    def begin(self, poses: np.ndarray) -> None:
        """Start anew with both robots' x, y and heading, shape (2, 3)."""
        self._poses = []
        self.add(poses)

    def add(self, poses: np.ndarray) -> None:
        """Go on to the next tick."""
        if self._mode is not None:
            self._poses.append(poses)
        if self._mode == 'human':
            self.render()

    def render(self) -> np.ndarray | None:
        """Return the picture, uint8 of shape (height, width, 3); in a window, show it."""
        if self._mode is None:
            return None
        if self._scene is None:
            from coevo_manager.recording.animation import Scene  # here: not everyone draws

            self._scene = Scene(self._arena.size, self._arena.obstacle)
        frame = self._scene.draw(self._poses, f'{(len(self._poses) - 1) * TICK:.1f} s')
        if self._mode == 'rgb_array':
            return frame
        if self._window is None:
            self._window = _Window(frame)
        self._window.show(frame)
        return None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None


class _Window:
    """A window of Matplotlib; where there is no display, Matplotlib says so once."""

    def __init__(self, frame: np.ndarray) -> None:
        from matplotlib import pyplot

        self._figure = pyplot.figure('Red Queen', figsize=(5, 5.4))
        self._image = self._figure.figimage(frame, resize=True)
        pyplot.show(block=False)

    def show(self, frame: np.ndarray) -> None:
        self._image.set_data(frame)
        self._figure.canvas.draw_idle()
        self._figure.canvas.start_event_loop(TICK)

    def close(self) -> None:
        from matplotlib import pyplot

        pyplot.close(self._figure)
