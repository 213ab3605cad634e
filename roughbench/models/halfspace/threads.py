"""Loops run in blocks on a fixed number of threads."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

Blocks = Sequence[tuple[int, int]]
"""Ranges of tile rows, tiles or grid rows, one for each thread."""


class ThreadTeam:
    """Runs a loop over blocks on a fixed number of threads.

    The calling thread takes the last block. Idle threads sleep, they do not spin.
    """

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None

    def split(self, rows: NDArray[np.int64]) -> tuple[Blocks, Blocks]:
        """Blocks of tile rows that share the tiles evenly, and the tiles of each."""
        targets = np.linspace(0, rows[-1], self.threads + 1)[1:-1]
        inner = np.searchsorted(rows, targets)
        ends = [0, *(int(i) for i in inner), len(rows) - 1]
        row_blocks = list(itertools.pairwise(ends))
        return row_blocks, [(int(rows[a]), int(rows[b])) for a, b in row_blocks]

    def even(self, n_rows: int) -> Blocks:
        """Blocks of equally many rows."""
        ends = np.linspace(0, n_rows, self.threads + 1).astype(int).tolist()
        return list(itertools.pairwise(ends))

    def run(self, loop: Callable[..., Any], blocks: Blocks, *args: Any) -> list[Any]:
        """Run ``loop(a, b, *args)`` for every block; results in block order."""
        if self._pool is None:
            return [loop(a, b, *args) for a, b in blocks]
        others = [self._pool.submit(loop, a, b, *args) for a, b in blocks[:-1]]
        last = loop(*blocks[-1], *args)
        return [*(other.result() for other in others), last]

    def sum(self, loop: Callable[..., Any], blocks: Blocks, *args: Any) -> NDArray[np.float64]:
        """Run ``loop`` and add its sums in block order."""
        return np.add.reduce(np.array(self.run(loop, blocks, *args), dtype=np.float64), axis=0)
