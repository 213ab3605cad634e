"""What operating systems do each in their own way: all of it, in one place.

Linux has all that is used here; macOS and Windows, and some file systems, have less. Each
function says what is done where something is missing.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
import platform
import signal
import sys
import threading
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import IO

_PROC = Path("/proc")
_NO_SUCH_SYNC = {errno.EBADF, errno.EINVAL, errno.ENOTSUP}

ENDING_SIGNALS: frozenset[int] = frozenset(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
    if hasattr(signal, name)
)
"""Those that end a run: SIGHUP is of POSIX, SIGBREAK of Windows."""
HANG_UP: int | None = getattr(signal, "SIGHUP", None)
ALARM: int = getattr(signal, "SIGALRM", signal.SIGINT)
"""The signal of :func:`set_alarm`."""

_timers: list[threading.Timer] = []


# -- processor and memory --------------------------------------------------------------


def available_cores() -> int:
    """Return the number of cores that this process may use; all, where nobody tells."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def free_memory() -> int | None:
    """Bytes of the machine's memory that can be had without swapping; None if nobody tells."""
    size = entry(_PROC / "meminfo", "MemAvailable:")
    if size is None and sys.platform != "linux":
        with contextlib.suppress(ImportError):
            import psutil

            size = int(psutil.virtual_memory().available)
    return size


def memory_limits() -> Iterator[tuple[int, str]]:
    """Yield what is left of the limits of this process, and the option of ulimit that sets it.

    Windows has none.
    """
    try:
        import resource
    except ImportError:
        return
    for kind, used, option in (
        (resource.RLIMIT_AS, "VmSize:", "-v"),
        (resource.RLIMIT_DATA, "VmData:", "-d"),
    ):
        limit, _ = resource.getrlimit(kind)
        if limit != resource.RLIM_INFINITY:
            yield limit - (entry(_PROC / "self/status", used) or 0), option


def restart_peak_memory() -> None:
    """Let :func:`peak_memory` count from now on; only Linux can."""
    with contextlib.suppress(OSError):
        (_PROC / "self/clear_refs").write_text("5", encoding="ascii")


def peak_memory() -> int:
    """Return the most bytes that this process has held; 0 where nobody tells."""
    peak = entry(_PROC / "self/status", "VmHWM:")
    if peak is not None:
        return peak
    try:
        import resource
    except ImportError:
        with contextlib.suppress(ImportError, AttributeError):
            import psutil

            return int(psutil.Process().memory_info().peak_wset)
        return 0
    found = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return found if sys.platform == "darwin" else found * 1024


def processor() -> str:
    """Return the name of the processor, or of its kind."""
    with contextlib.suppress(OSError):
        for line in (_PROC / "cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def kind_of_platform() -> str:
    """Return system and kind of processor, such as ``Linux x86_64``; no name, no version."""
    return f"{platform.system()} {platform.machine()}"


def entry(path: Path, name: str) -> int | None:
    """Bytes in a line such as ``MemAvailable:   1000 kB``; None where there is none."""
    try:
        for line in path.read_text(encoding="utf-8").splitlines():
            words = line.split()
            if words[:1] == [name]:
                return int(words[1]) * (1024 if words[2:] == ["kB"] else 1)
    except (OSError, ValueError, IndexError):
        pass
    return None


# -- files -----------------------------------------------------------------------------


def sync_folder(folder: Path) -> None:
    """Have the names in a folder survive a power cut.

    Windows opens no folders, and some file systems of networks sync none: there it is left to
    them.
    """
    if not hasattr(os, "O_DIRECTORY"):
        return
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _NO_SUCH_SYNC:
            raise
    finally:
        os.close(descriptor)


def set_permissions(descriptor: int, mode: int) -> None:
    """Give an open file its permissions; Windows knows none."""
    if hasattr(os, "fchmod"):
        os.fchmod(descriptor, mode)


def is_read_only(folder: Path) -> bool:
    """Whether a file system can only be read; False where nobody tells before it is tried."""
    return hasattr(os, "statvfs") and bool(os.statvfs(folder).f_flag & os.ST_RDONLY)


def open_for_lock(path: Path) -> int:
    """Return a descriptor of a file, made where there is none, and never through a link.

    Windows has no flag for the latter, and lets only few make links.

    Raises
    ------
    OSError
        If the system refuses.
    """
    flags = os.O_RDWR | os.O_CREAT
    for name in ("O_NOFOLLOW", "O_CLOEXEC", "O_NOINHERIT", "O_BINARY"):
        flags |= getattr(os, name, 0)
    return os.open(path, flags, 0o666)


def touch(descriptor: int) -> None:
    """Give an open file a new time stamp; Windows does not by descriptor, and it stays.

    Raises
    ------
    OSError
        If the system refuses.
    """
    if os.utime in os.supports_fd:
        os.utime(descriptor)


def readable_text(file: IO[bytes]) -> str:
    """Return the text of a file; without its first byte where another process has locked it.

    A lock of Windows keeps others from reading that.
    """
    try:
        return file.read().decode()
    except PermissionError:
        file.seek(1)
        return file.read().decode()


def write_any_text(*streams: object) -> None:
    """Let streams take any text: what their encoding lacks is written as its number.

    Windows gives a pipe the encoding of the country, which has no letters of formulas.
    """
    for stream in streams:
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")


def removes_open_files() -> bool:
    """Whether a file can be removed while a process has it open; not on Windows."""
    return os.name == "posix"


def split_dataset(path: str) -> tuple[str, str]:
    """Return file and dataset of ``heights.h5:/name``; the dataset is empty for other names.

    The colon behind the letter of a drive, on Windows, is none before a dataset.

    Examples
    --------
    >>> split_dataset("heights.h5:/a/b"), split_dataset("heights.npy")
    (('heights.h5', '/a/b'), ('heights.npy', ''))
    """
    drive, rest = os.path.splitdrive(path)
    file, colon, dataset = rest.rpartition(":/")
    return (drive + file, "/" + dataset) if colon else (path, "")


def config_folder() -> Path:
    """Return the folder for settings of the user, as the system has it."""
    if sys.platform == "win32":
        base = Path(os.environ.get("APPDATA") or Path.home() / "AppData" / "Roaming")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Application Support"
    else:
        base = Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config")
    return base / "roughbench"


# -- signals and processes -------------------------------------------------------------


@contextlib.contextmanager
def blocked(signals: Collection[int]) -> Iterator[None]:
    """Block signals in this thread and in processes that it starts; Windows cannot."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def set_alarm(seconds: float) -> None:
    """Have the handler of :data:`ALARM` called after so many seconds; 0 for never.

    Where the system has no alarm a thread calls it.
    """
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)
        return
    while _timers:
        _timers.pop().cancel()
    if seconds > 0.0:
        timer = threading.Timer(seconds, signal.raise_signal, (ALARM,))
        timer.daemon = True
        _timers.append(timer)
        timer.start()


def start_resource_tracker() -> None:
    """Start the process that Python has beside spawned ones; Windows has none."""
    if os.name == "posix":
        from multiprocessing import resource_tracker

        resource_tracker.ensure_running()
