"""Make every number and figure of docs/study.md from the results of the study's runs.

python scripts/study_figures.py                 from the kept results, docs/study/*.h5.xz
python scripts/study_figures.py --keep results  keep those of results/study-*.h5 first

Prints a line per number: its name, value, standard error (nan: none) and the number of surfaces
behind it. The same lines are kept in docs/study/numbers.txt, the table of claims in claims.txt
beside it. docs/study.md is docs/study/page.txt with names in braces replaced: {name} by value ±
error, {name:v} by the value, {name:n} by the number of surfaces, {name:p} by its deviation from
one in percent, and {claims} by the table.
"""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Sequence
from pathlib import Path

import _kept
from _study_claims import claims
from _study_curves import Number
from _study_drawing import FIGURES
from _study_numbers import RUNS, Numbers, everything

from roughbench.figures.files import save
from roughbench.figures.style import publication_style
from roughbench.numbers import number, with_error
from roughbench.results import Results

DOCS = Path(__file__).parents[1] / "docs"
KEPT = DOCS / "study"
DIGITS = 7


def keep(folder: Path, kept: Path) -> None:
    """Compress study-NAME.h5 of a folder into NAME.h5.xz."""
    kept.mkdir(exist_ok=True)
    for name in RUNS:
        path = folder / f"study-{name}.h5"
        if path.is_file():
            _kept.keep(path, kept / f"{name}.h5.xz")


def load(kept: Path, names: Sequence[str] = RUNS) -> dict[str, Results]:
    """Return the kept results, by name, as far as they are there."""
    paths = {name: kept / f"{name}.h5.xz" for name in names}
    return {name: _kept.load(path) for name, path in paths.items() if path.is_file()}


def lines_of(numbers: Numbers) -> str:
    """Return a line per number: name, value, error, surfaces."""
    rows = (
        f"{name} {one.value:.{DIGITS}g} {one.error:.3g} {one.count}"
        for name, one in sorted(numbers.items())
    )
    return "".join(f"{row}\n" for row in rows)


def numbers_of(lines: str) -> Numbers:
    """Return the numbers of such lines."""
    found = {}
    for line in lines.splitlines():
        name, value, error, count = line.split()
        found[name] = Number(float(value), float(error), int(count))
    return found


_PLACE = re.compile(r"\{([a-z][^{}:]*)(?::([vnp]))?\}")


def page_of(template: str, numbers: Numbers, table: str) -> str:
    """Return the page: the template with numbers in place of their names.

    Raises
    ------
    KeyError, ValueError
        If the template names a number that there is not, or that has no value.
    """

    def text(found: re.Match[str]) -> str:
        if found[1] == "claims":
            return table
        one, form = numbers[found[1]], found[2]
        if not math.isfinite(one.value):
            raise ValueError(f"{found[1]} has no value")
        if form == "n":
            return str(one.count)
        if form == "v":
            return _value(one)
        if form == "p":
            return f"{abs(one.value - 1.0) * 100.0:.0f} %"
        return with_error(one.value, one.error, of_error=1)

    return _PLACE.sub(text, template)


def _value(one: Number) -> str:
    """Return a value to the digits that its error leaves, at most three; without one four."""
    if not (math.isfinite(one.error) and one.error > 0.0) or one.value == 0.0:
        return number(one.value, 4)
    digits = math.floor(math.log10(abs(one.value))) - math.floor(math.log10(one.error)) + 1
    return number(one.value, min(max(digits, 1), 3))


def main() -> None:
    """Compute, draw, print, and write the page."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--keep", type=Path, metavar="FOLDER", help="compress its results first"
    )
    parser.add_argument("--docs", type=Path, default=DOCS, help="folder of study.md")
    parser.add_argument("--numbers-only", action="store_true", help="no figures")
    given = parser.parse_args()
    kept = given.docs / "study"
    if given.keep is not None:
        keep(given.keep, kept)
    runs = load(kept)
    numbers = everything(runs)
    lines = lines_of(numbers)
    print(lines, end="")
    (kept / "numbers.txt").write_text(lines, encoding="utf-8")
    table = claims(runs)
    (kept / "claims.txt").write_text(f"{table}\n", encoding="utf-8")
    if not given.numbers_only:
        with publication_style():
            for name, (needs, draw) in FIGURES.items():
                if set(needs) <= set(runs):
                    figure = draw(runs, numbers)
                    save(figure, f"study-{name}", given.docs / "figures", formats=["png"])
    template = (kept / "page.txt").read_text(encoding="utf-8")
    page = page_of(template, numbers_of(lines), table)
    (given.docs / "study.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
