"""How evaluators and runs talk to each other."""

import os


def choose_transport() -> None:
    """Let this process, and those it starts, talk over UDP, unless its user chose otherwise.

    On one machine that costs less processor time a request than Fast DDS's shared memory does, and
    a killed process leaves nothing in /dev/shm. Call it before rclpy is initialised.
    """
    if 'FASTRTPS_DEFAULT_PROFILES_FILE' not in os.environ:
        os.environ.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
