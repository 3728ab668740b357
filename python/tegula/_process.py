"""Threads of the process: there are none in a process that was forked after its parent had computed."""

from __future__ import annotations

import os

_threads_of: int | None = None


def use_threads() -> None:
    """Refuses to compute in a process that was forked after its parent had computed: the threads are not there."""
    global _threads_of
    if _threads_of is None:
        _threads_of = os.getpid()
    if _threads_of != os.getpid():
        raise RuntimeError(
            "this process was forked from one that has computed with tegula already, whose threads it does not have: start "
            'processes with multiprocessing.get_context("spawn") or "forkserver"'
        )
