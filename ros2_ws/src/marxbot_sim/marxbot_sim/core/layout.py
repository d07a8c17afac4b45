"""Rows of the arrays that the kernels work on.

Every array is float32 of shape (rows, 16). Lane k < 8 holds the predator of episode k, lane k + 8
its prey, so that `swap_halves` shows each robot its opponent.
"""

from marxbot_sensors import MARXBOT

X, Y, COSINE, SINE, CONTACT = range(5)
BODY_ROWS = 5
"""`bodies`: position, m; heading as a unit vector; 1 where the last tick touched a
wall or the obstacle, else 0."""

LEFT, RIGHT = range(2)
WHEEL_ROWS = 2
"""`wheels`: speeds of the wheels, rad/s, positive forward."""

HALF_SIZE, WALL_FRICTION, RIM_TURN, UNDO = range(4)
ARENA_ROWS = 4
"""`arena`: half of the arena's side, m; Coulomb coefficient; turn for what friction takes of a
tick's sliding, rad/m; 1 where a move that would end inside something is undone, else 0."""

INFRARED, CAMERA, GROUND, TOUCH = (MARXBOT.rows(sensor).start for sensor in MARXBOT.sensors[:4])
"""`readings`, in the order and the units of the robot's sensors: 24 infrared distances from the
rim, m (above the range: nothing seen); 8 camera sectors, 0..1; 4 ground sensors, darkness 0..1; 1
while in contact; then what further sensors read."""

READING_ROWS = MARXBOT.readings
