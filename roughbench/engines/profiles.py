"""Profiles of a cluster in a configuration file: what every job there needs to be told.

``config.toml`` in the folder for settings of the user, or the file that ``ROUGHBENCH_CONFIG``
names::

    [profile.short]
    partition = "short"
    account = "tribology"
    walltime = "04:00:00"
    cpus = 4
    memory = "16G"
    options = ["--qos=low", "--constraint=avx2"]
    setup = "module load python/3.12"
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from roughbench.errors import RoughbenchError, explained
from roughbench.system import config_folder
from roughbench.text import on_one_line, suggestion

WALLTIME = "01:00:00"


@dataclass(frozen=True, slots=True)
class JobProfile:
    """What jobs of a cluster are told.

    Attributes
    ----------
    partition, account : str
        As Slurm knows them; empty for its defaults.
    walltime : str
        Of each job, as ``04:00:00``.
    cpus : int
        Cores of each job, and threads of each task.
    memory : str
        Of each job, as ``16G``; empty: by the estimate for the largest task.
    options : tuple of str
        Further options of ``sbatch``, as ``--qos=low``.
    setup : str
        Lines of shell that each job begins with, such as to load modules.
    """

    partition: str = ""
    account: str = ""
    walltime: str = WALLTIME
    cpus: int = 1
    memory: str = ""
    options: tuple[str, ...] = ()
    setup: str = ""

    def changed(self, **given: Any) -> JobProfile:
        """Return it with those values that are given, which are not None."""
        return replace(self, **{name: one for name, one in given.items() if one is not None})


def config_file() -> Path:
    """Return where the configuration file is, or would be."""
    own = os.environ.get("ROUGHBENCH_CONFIG")
    return Path(own) if own else config_folder() / "config.toml"


def load_profile(name: str) -> JobProfile:
    """Return a profile of the configuration file.

    Raises
    ------
    RoughbenchError
        If there is no such file or profile, or something in it is not as it must be.
    """
    path = config_file()
    where = on_one_line(str(path))
    try:
        with path.open("rb") as file:
            tree = tomllib.load(file)
    except FileNotFoundError:
        raise RoughbenchError(
            f"there is no profile {name!r}: the file {where} is not there; write it, with the "
            f'lines [profile.{name}] and partition = "..."'
        ) from None
    except OSError as error:
        raise RoughbenchError(f"{where}: cannot be read: {explained(error)}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise RoughbenchError(f"{where}: is no TOML: {on_one_line(str(error))}") from error
    profiles = tree.get("profile", {})
    if not isinstance(profiles, Mapping) or name not in profiles:
        known = [*profiles] if isinstance(profiles, Mapping) else []
        near = suggestion(name, known)
        hint = f"did you mean {near!r}?" if near else f"there are {', '.join(known) or 'none'}"
        raise RoughbenchError(f"{where}: has no profile {name!r}; {hint}")
    return _checked(profiles[name], f"{where}: profile.{name}")


def _checked(tree: object, where: str) -> JobProfile:
    """Return the profile that a table is."""
    if not isinstance(tree, Mapping):
        raise RoughbenchError(f"{where}: must be a table, [profile.NAME]")
    defaults = JobProfile()
    known = [one.name for one in fields(JobProfile)]
    values: dict[str, Any] = {}
    for key, value in tree.items():
        if key not in known:
            near = suggestion(key, known)
            hint = f"did you mean {near!r}?" if near else f"known here: {', '.join(known)}"
            raise RoughbenchError(f"{where}.{key}: unknown key; {hint}")
        default = getattr(defaults, key)
        if isinstance(default, tuple):
            if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
                raise RoughbenchError(f"{where}.{key}: must be a list of texts, got {value!r}")
            values[key] = tuple(value)
        elif type(value) is not type(default):
            kind = "a number" if isinstance(default, int) else "a text"
            raise RoughbenchError(f"{where}.{key}: must be {kind}, got {value!r}")
        else:
            values[key] = value
    if values.get("cpus", 1) < 1:
        raise RoughbenchError(f"{where}.cpus: must be at least 1, got {values['cpus']}")
    return JobProfile(**values)
