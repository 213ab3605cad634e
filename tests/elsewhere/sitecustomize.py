"""Takes from a Python on Linux what other systems lack, before anything is imported.

Python imports this by itself where its folder is on PYTHONPATH: in worker processes too.
"""

import os
import pathlib
import signal
import sys
from typing import Any

for name in ("fcntl", "resource", "pyfftw", "psutil"):
    sys.modules[name] = None  # type: ignore[assignment]  # its import fails
for module, names in (
    (os, ("sched_getaffinity", "fchmod", "statvfs")),
    (os, ("O_NOFOLLOW", "O_CLOEXEC", "O_DIRECTORY")),
    (signal, ("SIGHUP", "SIGALRM", "setitimer", "pthread_sigmask")),
):
    for name in names:
        delattr(module, name)
os.supports_fd.discard(os.utime)

_read_text = pathlib.Path.read_text


def _without_proc(self: pathlib.Path, *args: Any, **options: Any) -> str:
    if self.is_absolute() and self.parts[1:2] in (("proc",), ("sys",)):
        raise FileNotFoundError(self)
    return _read_text(self, *args, **options)


pathlib.Path.read_text = _without_proc  # type: ignore[method-assign]
