"""What a Dask cluster lacks to go on. Dask itself waits for ever, and says nothing."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from roughbench.engines.cluster import Cluster
from roughbench.errors import IncompleteError, RoughbenchError

if TYPE_CHECKING:
    from distributed import Client

SECONDS_TO_TELL = 30.0
"""How long something may be missing before it is said."""

_SECONDS_BETWEEN_LOOKS = 2.0
_SECONDS_OF_SILENCE = 10.0
"""Workers and scheduler are heard of every second or so, also while they compute."""


class ClusterWatch:
    """Looks after scheduler and workers, from its own thread: a question may wait for ever.

    Parameters
    ----------
    client : Client
    cluster : Cluster
    refusals : list of str
        What Slurm said when it refused jobs; grows meanwhile.
    say : callable
        Told what is missing, once each.
    """

    def __init__(
        self, client: Client, cluster: Cluster, refusals: list[str], say: Callable[[str], None]
    ) -> None:
        self._client = client
        self._cluster = cluster
        self._refusals = refusals
        self._say = say
        self._monitored: set[str] = set()
        self._since: float | None = None  # something is missing
        self._heard = time.monotonic()
        self._info: dict[str, Any] | None = None
        self._last_seen: dict[str, tuple[float, float]] = {}
        self._idle = False
        self._had_workers = False
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop looking."""
        self._stop.set()

    def workers(self) -> dict[str, Any]:
        """Return what the scheduler says of the workers that can be heard, by address."""
        now = time.monotonic()
        return {
            address: worker
            for address, worker in (self._info or {}).items()
            if now - self._last_seen[address][1] < _SECONDS_OF_SILENCE
        }

    def note_progress(self) -> None:
        """Take note that something was computed just now."""
        self._since = None

    def check(self, *, waits_for: str = "") -> None:
        """Say what is missing, after half a minute, and lose patience some time.

        Parameters
        ----------
        waits_for : str
            What a worker needs for the tasks that are left; empty while there are none.

        Raises
        ------
        RoughbenchError
            If Slurm takes no job at all.
        IncompleteError
            If something has been missing for longer than the patience of the run.
        """
        missing = self._missing(waits_for)
        if not missing:
            self._since = None
            return
        now = time.monotonic()
        self._since = now if self._since is None else self._since
        waited, patience = now - self._since, self._cluster.seconds_of_patience
        if waited > patience:
            raise IncompleteError(
                f"{missing}; gave up after {patience / 60:g} minutes (--patience)"
            )
        if waited > SECONDS_TO_TELL and missing not in self._monitored:
            self._monitored.add(missing)
            self._say(f"{missing}; the run waits {patience / 60:g} minutes for it (--patience)")

    def _missing(self, waits_for: str) -> str:
        name = f"the Dask scheduler {self._cluster.name}"
        slurm = self._cluster.kind == "slurm"
        if self._refusals and not self._had_workers:
            raise RoughbenchError(
                f"Slurm's sbatch refused the job: {self._refusals[-1]}; see --partition, "
                "--account and --walltime"
            )
        if time.monotonic() - self._heard > _SECONDS_OF_SILENCE:
            return f"{name} does not answer"
        if self._info is None:
            return ""  # it has just been asked for the first time
        if not self._info and slurm:
            refused = f", and sbatch says: {self._refusals[-1]}" if self._refusals else ""
            return f"no job of Slurm is at work (squeue says what they wait for){refused}"
        if not self._info:
            return f"{name} has no workers; start some with: {self._cluster.start_worker}"
        if not self.workers():
            return (
                f"none of the {len(self._info)} workers of {name} is heard of any more: they "
                "are stopped, or cut off"
            )
        if waits_for and self._idle:
            return f"no worker of {name} takes the tasks that are left; {waits_for}"
        return ""

    def _look(self) -> None:
        while not self._stop.is_set():
            with contextlib.suppress(
                Exception
            ):  # of a connection that is lost: noticed elsewhere
                self._ask()
            self._stop.wait(_SECONDS_BETWEEN_LOOKS)

    def _ask(self) -> None:
        info = self._client.scheduler_info(n_workers=-1)["workers"]
        idle = not any(self._client.processing().values())
        now = time.monotonic()
        last_seen = {}
        for address, worker in info.items():
            last = worker.get("last_seen", now)  # by another clock than ours
            before = self._last_seen.get(address)
            last_seen[address] = before if before and before[0] == last else (last, now)
        self._last_seen = last_seen
        self._info, self._idle, self._heard = dict(info), idle, now
        self._had_workers = self._had_workers or bool(info)


def within(
    seconds: float, question: Callable[[], Any], meanwhile: Callable[[], None] | None = None
) -> Any:
    """Return the answer to a question that may wait for ever.

    Parameters
    ----------
    seconds : float
    question : callable
    meanwhile : callable, optional
        Called every second; what it raises ends the wait.

    Raises
    ------
    TimeoutError
        If it has not come within so many seconds.
    """
    answers: list[tuple[Any, BaseException | None]] = []

    def ask() -> None:
        try:
            answers.append((question(), None))
        except BaseException as error:  # noqa: BLE001, RUF100  (raised where it was asked)
            answers.append((None, error))

    thread = threading.Thread(target=ask, daemon=True)
    thread.start()
    end = time.monotonic() + seconds
    while thread.is_alive() and (left := end - time.monotonic()) > 0.0:
        thread.join(min(1.0, left))
        if meanwhile is not None and thread.is_alive():
            meanwhile()
    if not answers:
        raise TimeoutError(f"no answer within {seconds:g} s")
    answer, error = answers[0]
    if error is not None:
        raise error
    return answer
