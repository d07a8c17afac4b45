"""Dask clusters: one of our own, which nobody else can use, and those that run already."""

import contextlib
import logging
import re
from collections.abc import Iterator

TIMEOUT = 30
"""How long a scheduler may take to answer, s."""

_ADDRESS = re.compile(r'((tcp|tls)://)?(\[[0-9A-Fa-f:.]+\]|[\w.-]+):(\d{1,5})')


class ClusterError(ValueError):
    """A cluster cannot be used; one sentence that says why."""


@contextlib.contextmanager
def own_cluster(workers: int) -> Iterator:
    """Start worker processes on this machine and connect to them; they end with the context.

    They talk TLS with credentials that are made for them alone, so that no other user of this
    machine can hand them work, and they serve no web page.

    Parameters
    ----------
    workers : int
        Processes.

    Yields
    ------
    distributed.Client

    Raises
    ------
    ClusterError
        The processes cannot be started.
    """
    import dask
    from distributed import Client, LocalCluster
    from distributed.security import Security

    pages: dict[str, list[str]] = {
        f'distributed.{kind}.http.routes': [] for kind in ('scheduler', 'worker')
    }
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(pages))
        try:
            cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                memory_limit=0,
                dashboard_address=':0',
                silence_logs=logging.CRITICAL,
                security=Security.temporary(),
            )
            client = Client(stack.enter_context(cluster))
        except (OSError, RuntimeError) as error:
            reason = ' '.join(str(error).split())[:300]
            raise ClusterError(f'worker processes cannot be started: {reason}') from None
        yield stack.enter_context(client)


def connect(address: str):
    """Connect to the scheduler of a running cluster, as a distributed.Client.

    A ``tls://`` address needs the credentials that Dask's configuration names, such as
    ``DASK_DISTRIBUTED__COMM__TLS__CA_FILE`` (docs/analysis.md).

    Raises
    ------
    ClusterError
        Nothing answers there, or not to us.
    """
    from distributed import Client
    from distributed.security import Security

    match = _ADDRESS.fullmatch(address)
    if not match or int(match[4]) > 65535:
        raise ClusterError(
            f'dask is {address[:60]!r}, expected the address of a scheduler such as '
            'tls://HOST:8786 or tcp://HOST:8786'
        )
    logging.getLogger('distributed').setLevel(logging.CRITICAL)
    try:
        # Before there is a client: one that is half made leaves its thread running, and hangs the
        # next when it is collected.
        credentials = Security().get_connection_args('client')
        if match[2] == 'tls' and credentials['ssl_context'] is None:
            raise ValueError('its clients need credentials, and Dask is configured with none')
        return Client(address, timeout=TIMEOUT)
    except (OSError, ValueError, TypeError) as error:
        reason = ' '.join(str(error).split())[:300]
        raise ClusterError(f'dask is {address}: no scheduler answers there ({reason})') from None
