"""Build the site: the pages of this repository, with reference pages made from the code.

    python website/build.py              # build/site; a warning or a dead link is an error
    python website/build.py --linkcheck  # whether the links that lead out of it answer

The pages are copied as they lie into build/site-source, so that links between them, and to the
files beside them, lead where they lead in the repository. Notebooks are shown as `make
notebooks` has run them.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

from links import faults_of, outside_of, pages_of
from reference import commands_page, modules_page, python_page
from results_file import results_file_page

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "build" / "site-source"
SITE = ROOT / "build" / "site"
DOCTREES = ROOT / "build" / "site-doctrees"
NOTEBOOKS = ROOT / "build" / "notebooks"
OWN = Path(__file__).parent
PROBE = "https://doi.org"
STRICT = ("--fail-on-warning", "--nitpicky", "--keep-going", "--write-all")

BESIDE = ("CITATION.cff", "LICENSE", "pyproject.toml")
FOLDERS = ("docs", "examples", "configs", "scripts")
UNWANTED = shutil.ignore_patterns("__pycache__", "*.h5", "*.rbrun", ".ipynb_checkpoints")


def stage() -> None:
    """Lay out what Sphinx reads: the repository's pages, and those made from the code."""
    for folder in FOLDERS:
        shutil.rmtree(SOURCE / folder, ignore_errors=True)
        shutil.copytree(ROOT / folder, SOURCE / folder, ignore=UNWANTED)
    for notebook in (ROOT / "examples").glob("*.ipynb"):
        if not (NOTEBOOKS / notebook.name).exists():
            raise SystemExit(f"error: {notebook.name} has not been run: make notebooks")
        shutil.copy2(NOTEBOOKS / notebook.name, SOURCE / "examples")
    for page in [*ROOT.glob("*.md"), *(ROOT / name for name in BESIDE)]:
        shutil.copy2(page, SOURCE / page.name)
    write("index.md", with_all_pages((OWN / "index.md").read_text(encoding="utf-8")))
    write("reference/commands.md", commands_page())
    write("reference/python.md", python_page())
    write("reference/modules.md", modules_page())
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


def build(builder: str, target: str, *options: str) -> int:
    """Run Sphinx; returns its exit code."""
    folder = SITE.with_name(target)
    shutil.rmtree(folder, ignore_errors=True)  # pages that are no more
    words = ["-b", builder, "-c", str(OWN), "-d", str(DOCTREES), "--quiet", "--jobs", "auto"]
    command = [sys.executable, "-m", "sphinx", *words, *options, str(SOURCE), str(folder)]
    return subprocess.run(command, check=False).returncode


def unreachable() -> str:
    """Return why the network cannot be reached; nothing where it can."""
    try:
        urllib.request.urlopen(PROBE, timeout=20).close()
    except urllib.error.HTTPError:
        return ""  # it answers
    except OSError as error:
        return str(getattr(error, "reason", error))
    return ""


def check_outside() -> int:
    """Ask every link out of the built site whether it answers; returns an exit code."""
    outside = outside_of(pages_of(SITE))
    if not outside:
        raise SystemExit(f"error: there is no site in {SITE}: make site")
    for link, pages in outside.items():
        print(f"{link}  ({len(pages)} page{'s' * (len(pages) != 1)})")
    if reason := unreachable():
        print(
            f"error: whether these {len(outside)} links answer cannot be asked here: {PROBE} "
            f"is out of reach ({reason}). Run it where there is a network; that all of them "
            "are well-formed, `make site` has seen",
            file=sys.stderr,
        )
        return 1
    return build("linkcheck", "site-links")


def main() -> int:
    """Build, or ask the links out of the site; returns an exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--linkcheck", action="store_true", help="only check external links")
    if parser.parse_args().linkcheck:
        return check_outside()
    stage()
    if failed := build("html", "site", *STRICT):
        return failed
    pages = pages_of(SITE)
    faults = list(faults_of(pages))
    for fault in faults:
        print(f"error: {fault}", file=sys.stderr)
    count = sum(len(page.links) for page in pages.values())
    print(f"{len(pages)} pages, {count} links, {len(faults)} of them dead or malformed")
    print(SITE / "index.html")
    return int(bool(faults))


if __name__ == "__main__":
    raise SystemExit(main())
