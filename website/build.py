"""Build the site: the pages of this repository, with reference pages made from the code.

    python website/build.py              # build/site; any warning is an error
    python website/build.py --linkcheck  # only look whether external links answer

The pages are copied as they lie into build/site-source, so that links between them, and to the
files beside them, lead where they lead in the repository.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

from reference import commands_page, python_page
from results_file import results_file_page

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "build" / "site-source"
SITE = ROOT / "build" / "site"
OWN = Path(__file__).parent

BESIDE = ("CITATION.cff", "LICENSE", "pyproject.toml")
FOLDERS = ("docs", "examples", "configs", "scripts")
UNWANTED = shutil.ignore_patterns("__pycache__", "*.h5", "*.rbrun", ".ipynb_checkpoints")


def stage() -> None:
    """Lay out what Sphinx reads: the repository's pages, and those made from the code."""
    for folder in FOLDERS:
        shutil.rmtree(SOURCE / folder, ignore_errors=True)
        shutil.copytree(ROOT / folder, SOURCE / folder, ignore=UNWANTED)
    for page in [*ROOT.glob("*.md"), *(ROOT / name for name in BESIDE)]:
        shutil.copy2(page, SOURCE / page.name)
    write("index.md", with_all_pages((OWN / "index.md").read_text(encoding="utf-8")))
    write("reference/commands.md", commands_page())
    write("reference/python.md", python_page())
    write("reference/results-file.md", results_file_page())


def write(name: str, text: str) -> None:
    """Write a page, unless it is there as it should be: Sphinx reads again what is newer."""
    path = SOURCE / name
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def with_all_pages(index: str) -> str:
    """Add the pages that the index does not name as a part of their own."""
    pages = [*SOURCE.glob("*.md")]
    for folder in ("docs", "examples"):
        pages += (SOURCE / folder).rglob("*.md")
        pages += (SOURCE / folder).rglob("*.ipynb")
    found = sorted({page.relative_to(SOURCE).with_suffix("").as_posix() for page in pages})
    named = set(re.findall(r"^(?:.*<)?([\w/-]+)>?$", index, re.MULTILINE))
    others = [page for page in found if page not in named | {"index"}]
    if not others:
        return index
    return index + "\n".join(
        ["\n```{toctree}", ":caption: More", ":hidden:", ":maxdepth: 1", "", *others, "```", ""]
    )


def main() -> int:
    """Build; returns Sphinx's exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--linkcheck", action="store_true", help="only check external links")
    options = parser.parse_args()
    stage()
    builder, target = ("linkcheck", "site-links") if options.linkcheck else ("html", "site")
    strict = [] if options.linkcheck else ["--fail-on-warning", "--nitpicky", "--keep-going"]
    words = ["-b", builder, "-c", str(OWN), *strict, "--quiet", "--write-all", "--jobs", "auto"]
    folders = [str(SOURCE), str(SITE.with_name(target))]
    done = subprocess.run([sys.executable, "-m", "sphinx", *words, *folders], check=False)
    if not done.returncode and not options.linkcheck:
        print(SITE / "index.html")
    return done.returncode


if __name__ == "__main__":
    raise SystemExit(main())
