"""Kernels compiled once per machine: a cache on disk that no change of a source outlives."""

import contextlib
import hashlib
import inspect
from pathlib import Path

import numba
from numba.core.caching import FunctionCache

INLINED = {'forceinline': True, '_nrt': False}
"""How Numba compiles the parts of kernels."""


def compile_kernel(function):
    """Compile a function that Python calls, without the GIL, and keep the result on disk.

    Numba's own cache looks only at the file of the function itself. This one also looks at every
    other source in the folders of the functions that it calls, directly or not, so a changed
    constant or callee is compiled again. Several processes may compile and load at once.

    Parameters
    ----------
    function : callable
        What ``numba.njit`` takes.

    Returns
    -------
    callable
        The compiled function; the function itself where ``NUMBA_DISABLE_JIT`` is set.
    """
    dispatcher = numba.njit(nogil=True)(function)
    if dispatcher is not function:
        dispatcher._cache = _KernelCache(function)  # type: ignore[attr-defined]
    return dispatcher


def kernel_part(function):
    """Compile a function that kernels call: inlined there, and without counting references.

    Numba counts who refers to an array by atomic operations of some 20 cycles each, dozens in a
    tick where LLVM does not see that they cancel. A part of a kernel, and whatever it calls, only
    borrows its arrays: it can neither make one nor return one.

    Parameters
    ----------
    function : callable
        What ``numba.njit`` takes.
    """
    return numba.njit(**INLINED)(function)  # type: ignore[call-overload]


class _KernelCache(FunctionCache):
    """Numba's cache of one function, valid for one state of all sources that it depends on."""

    def __init__(self, function):
        super().__init__(function)
        self._cache_file._source_stamp = source_stamp(function)

    def save_overload(self, sig, data):
        """Keep what was compiled; on a full disk the next process compiles again."""
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)


def source_stamp(function):
    """Return a digest of all sources that a function depends on; compiled functions will do."""
    function = getattr(function, 'py_func', function)
    digest = hashlib.sha256()
    for folder in sorted(_folders(function, set())):
        for source in sorted(folder.glob('*.py')):
            digest.update(source.read_bytes())
    return digest.hexdigest()


def _folders(function, visited):
    """Return the folders of a function's source and of those of all functions that it calls."""
    visited.add(function)
    folders = {Path(inspect.getfile(function)).parent}
    for name in function.__code__.co_names:
        callee = function.__globals__.get(name)
        callee = getattr(callee, 'py_func', callee)
        if inspect.isfunction(callee) and callee not in visited:
            folders |= _folders(callee, visited)
    return folders
