"""From a file, a text or a dict to a frozen spec, or to all its faults.

``load_spec`` is for what shall be computed, and looks whether the files are there that the
spec names. ``parse_spec`` is for the text that results carry, which may be read anywhere.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from roughbench.errors import Fault, SpecError, explained
from roughbench.program import command
from roughbench.spec.model import Spec
from roughbench.spec.reading import MAX_CHARACTERS, Document, read_yaml
from roughbench.spec.tree import (
    plain,
)
from roughbench.spec.validation import GivenSpec, build, fault_at
from roughbench.text import file_meant, on_one_line

_HDF5 = b"\x89HDF\r\n\x1a\n"
Source = str | os.PathLike[str] | Mapping[str, Any] | Spec


def load_spec(
    source: Source, overrides: Sequence[str] = (), *, folder: str | os.PathLike[str] = ""
) -> Spec:
    """Return the spec that ``source`` describes.

    Parameters
    ----------
    source : path, str, mapping or Spec
        A file; or YAML text (a str of several lines, or one that starts with ``{``); or
        the same as a mapping. Relative paths of height files start at the file's folder,
        else at the current one.
    overrides : sequence of str
        ``key=value`` each, as behind ``--set`` on the command line.
    folder : path
        Where relative paths of height files start in a text; default: the current folder.

    Raises
    ------
    SpecError
        With every fault of the spec, each with line and column where a text is at hand.

    Examples
    --------
    >>> spec = load_spec('''
    ... surface: {H: 0.7, q0: 1, q1: 128, slope: 0.1}
    ... pressures: {min: 1e-5, max: 0.2, points: 20}
    ... models:
    ...   - kind: persson
    ... ''', overrides=["surface.qr=8"])
    >>> spec.surface.q_rolloff, len(spec.pressures), spec.models[0].name
    (8.0, 20, 'persson')
    """
    if isinstance(source, Spec):
        if not overrides:
            return source
        given = GivenSpec(Document(source.as_given()), source.name, source.folder)
    elif isinstance(source, Mapping):
        given = _from_mapping(source)
    elif isinstance(source, str) and ("\n" in source or source.lstrip().startswith("{")):
        given = GivenSpec(read_yaml(source), folder=Path(folder), text=source)
    else:
        given = _from_file(source)
    return build(given, overrides)


def parse_spec(
    text: str,
    *,
    folder: str | os.PathLike[str] = "",
    outside: Mapping[str, str] | None = None,
) -> Spec:
    """Return the spec that a text is, whether the files that it names are there or not.

    Parameters
    ----------
    text : str
        YAML, such as the ``spec`` of a results file.
    folder : path
        Where relative paths start; default: the current folder.
    outside : mapping of str to str, optional
        Run no Python file that the spec names as a model, and let pass what is not installed:
        kind in the spec → kind in the results
        (:attr:`roughbench.results.Results.outside_kinds`).

    Raises
    ------
    SpecError
        With every fault of the text.
    """
    given = GivenSpec(read_yaml(text), folder=Path(folder), text=text, outside=outside)
    return build(given, (), files=False)


def _from_mapping(source: Mapping[str, Any]) -> GivenSpec:
    tree, findings = plain(source)
    given = GivenSpec(Document(tree))
    if findings:
        raise SpecError([fault_at(finding, given) for finding in findings])
    return given


def _from_file(source: str | os.PathLike[str]) -> GivenSpec:
    path = Path(source)
    name = on_one_line(os.fspath(source))
    try:
        with path.open("rb") as stream:
            data = stream.read(4 * MAX_CHARACTERS + 1)
        if data.startswith(_HDF5):
            hint = f"if it has results, see them with: {command('show', path)}"
            raise SpecError([Fault(f"is an HDF5 file, not a spec; {hint}", source=name)])
        text = data.decode("utf-8-sig")
    except FileNotFoundError:
        near = file_meant(path, first=(".yaml", ".yml"))
        hint = f" (did you mean {str(path.with_name(near))!r}?)" if near else ""
        raise SpecError([Fault(f"no such file{hint}", source=name)]) from None
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        message = "is not UTF-8 text; save it as UTF-8"
        raise SpecError([Fault(message, "", line, column, name)]) from None
    except (OSError, ValueError) as error:
        reason = explained(error) if isinstance(error, OSError) else str(error)
        raise SpecError([Fault(f"cannot be read: {reason}", source=name)]) from None
    return GivenSpec(read_yaml(text), path.stem, path.parent, name, text)
