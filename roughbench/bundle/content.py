"""What stands in a bundle, and under which names."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import IO

from roughbench import figures
from roughbench.bundle.archive import BUNDLE, write_archive
from roughbench.bundle.environment import pinned, requirements
from roughbench.fits import RESAMPLES
from roughbench.outputs import check_output
from roughbench.publish import make_folder, publish, refusals_named
from roughbench.report import make_report
from roughbench.results import Results
from roughbench.runner import origins, spec_in
from roughbench.seal import sha256_of
from roughbench.source_files import origin_of
from roughbench.spec import MeasuredSurface, Spec
from roughbench.store import load

_README = """\
{name}
{line}
{file}: the results, HDF5; roughbench, xarray, h5py and HDFView open it
spec.yaml: what was to be computed
figures/, report.html: drawn from the results alone
environment.json: versions, processors and code that computed them, as far as that is known
requirements.txt: the same packages, for pip
SHA256SUMS: of every file, for sha256sum -c
{inputs}
To compute it again, and see how far that is from what stands here:

    python -m venv env
    env/bin/pip install -r requirements.txt
    env/bin/roughbench reproduce {file}
"""


def make_bundle(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    names: Sequence[str] = (),
    folder: str | os.PathLike[str] | None = None,
    reference: str | None = None,
    resamples: int = RESAMPLES,
) -> Path:
    """Pack a results file and all that belongs to it into one archive.

    The same results give the same bytes, with the same software on the same machine.

    Parameters
    ----------
    path : path
        A results file.
    output : path
        A zip archive; one that is there is replaced.
    names : sequence of str
        Figures to draw; default: all that the results allow.
    folder : path, optional
        Where relative paths in the spec start, see :func:`roughbench.runner.spec_in`.
    reference, resamples
        Of the report.

    Returns
    -------
    Path
        ``output``.

    Raises
    ------
    RoughbenchError
        If the results, or files that their spec names, cannot be read, or the archive not be
        written; it is then as it was.
    """
    source = Path(path)
    target = check_output(output, BUNDLE, [source])
    results = load(source)
    spec = spec_in(results, source, folder)
    inputs, elsewhere = _inputs(spec)
    content: dict[str, bytes | Path] = {source.name: source, **inputs}
    content["spec.yaml"] = results.spec_text.encode()
    used = origins(source)
    installed = pinned(["roughbench", *_distributions(results)])
    content["environment.json"] = _environment(used, installed)
    content["requirements.txt"] = requirements(source.name, installed, _one(used)).encode()
    content["README.txt"] = _readme(results, source.name, inputs, elsewhere).encode()
    content["report.html"] = make_report(
        [source], reference=reference, resamples=resamples
    ).encode()
    with tempfile.TemporaryDirectory(prefix="roughbench-") as drawn:
        for name in names or figures.available(results):
            for file in figures.render(results, name, drawn, source.name):
                content[f"figures/{file.name}"] = file
        content["SHA256SUMS"] = _sums(content).encode()
        top = source.stem

        def write(file: IO[bytes]) -> None:
            write_archive(file, {f"{top}/{name}": one for name, one in content.items()})

        make_folder(target.parent)
        with refusals_named(target):
            publish(write, target)
    return Path(output)


def _inputs(spec: Spec) -> tuple[dict[str, Path], dict[str, str]]:
    """Return the files that a spec names, by their names in the archive.

    Returns
    -------
    (dict of str to Path, dict of str to str)
        The files; and of those that do not lie below the spec's folder, under which name the
        spec looks for them.
    """
    found: dict[str, Path] = {}
    elsewhere: dict[str, str] = {}
    base = Path(os.path.abspath(spec.folder))  # noqa: PTH100  (links stay as they are)
    for file in dict.fromkeys(_named_files(spec)):
        path = Path(os.path.abspath(file))  # noqa: PTH100
        if path.is_relative_to(base):
            found[path.relative_to(base).as_posix()] = path
        else:
            name = f"inputs/{path.name}"
            number = 1
            while name in found:
                number += 1
                name = f"inputs/{number}-{path.name}"
            found[name] = path
            elsewhere[name] = os.path.relpath(path, base)
    return found, elsewhere


def _named_files(spec: Spec) -> Iterator[Path]:
    for _, variant in spec.experiments():
        if isinstance(variant.surface, MeasuredSurface):
            yield variant.surface.file
        for one in (*variant.models, *variant.observed):
            if origin := origin_of(type(one)):
                yield from (Path(origin.files.folder, name) for name, _ in origin.files.texts)


def _distributions(results: Results) -> list[str]:
    """Return the packages that models from outside come from."""
    modules = {source.partition(".")[0].partition(":")[0] for source in results.outside_kinds}
    known = metadata.packages_distributions() if modules else {}
    return sorted({name for module in modules for name in known.get(module, ())})


def _one(origins_of: Mapping[str, Mapping[str, str]]) -> dict[str, str]:
    """Return what all models have in common of what they were computed with."""
    shared: dict[str, set[str]] = {}
    for origin in origins_of.values():
        for key, value in origin.items():
            shared.setdefault(key, set()).add(value)
    return {
        key: values.pop()
        for key, values in shared.items()
        if len(values) == 1 and not any(" and " in value for value in values)
    }


def _environment(used: Mapping[str, Mapping[str, str]], installed: Mapping[str, str]) -> bytes:
    content = {
        "computed_with": used or None,
        "bundled_with": {
            "python": platform.python_version(),
            "system": platform.platform(),
            **installed,
        },
    }
    return (json.dumps(content, indent=1, ensure_ascii=False) + "\n").encode()


def _readme(
    results: Results, file: str, inputs: Mapping[str, Path], elsewhere: Mapping[str, str]
) -> str:
    lines = [f"{name}: read by the spec" for name in inputs if name not in elsewhere]
    lines += [
        f"{name}: the spec looks for it at {place}; copy it there first"
        for name, place in elsewhere.items()
    ]
    return _README.format(
        name=results.name,
        line="=" * len(results.name),
        file=file,
        inputs="".join(f"{line}\n" for line in lines),
    )


def _sums(content: Mapping[str, bytes | Path]) -> str:
    """Return the checksums of files, as ``sha256sum`` writes them."""
    digests = {
        name: hashlib.sha256(one).hexdigest() if isinstance(one, bytes) else sha256_of(one)
        for name, one in sorted(content.items())
    }
    return "".join(f"{digest}  {name}\n" for name, digest in digests.items())
