"""Links of the built site: whether those inside it lead somewhere, and those out of it can."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

WELL_FORMED = re.compile(r"https://[\w-]+(\.[\w-]+)+(/[^\s\"<>]*)?(#[^\s\"<>]*)?")
DOI = re.compile(r"https://doi\.org/10\.\d{4,9}/[\w.()/:;-]*\w")
"""As registration agencies recommend to match them: https://doi.org/10.PREFIX/SUFFIX."""


@dataclass
class Page(HTMLParser):
    """What a page of HTML leads to, and where others can lead in it."""

    path: Path
    anchors: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Read it."""
        super().__init__()
        self.feed(self.path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the anchor and the link of an element."""
        for name, value in attrs:
            if name == "id" or (tag, name) == ("a", "name"):
                self.anchors.add(value or "")
            elif name == "href" or (name == "src" and tag != "script"):
                self.links.append(value or "")


def pages_of(site: Path) -> dict[Path, Page]:
    """Return the pages of a site, by resolved path."""
    return {path.resolve(): Page(path) for path in sorted(site.rglob("*.html"))}


def faults_of(pages: dict[Path, Page]) -> Iterator[str]:
    """Yield every link that leads nowhere or cannot be right, with the page it is on."""
    for path, page in pages.items():
        for link in dict.fromkeys(page.links):
            parts = urlsplit(link)
            if parts.scheme == "data":
                continue
            if parts.scheme or parts.netloc:
                fault = _outside(link)
            else:
                fault = _inside(path, unquote(parts.path), unquote(parts.fragment), pages)
            if fault:
                yield f"{page.path}: {link}: {fault}"


def outside_of(pages: dict[Path, Page]) -> dict[str, list[Path]]:
    """Return the links that lead out of a site, each with the pages it is on."""
    found: dict[str, list[Path]] = {}
    for page in pages.values():
        for link in dict.fromkeys(page.links):
            if urlsplit(link).scheme not in ("", "data"):
                found.setdefault(link, []).append(page.path)
    return dict(sorted(found.items()))


def _inside(path: Path, target: str, anchor: str, pages: dict[Path, Page]) -> str:
    """Return what is wrong with a link to another file, or nothing."""
    where = (path.parent / target).resolve() if target else path
    if where.is_dir():
        where /= "index.html"
    if not where.is_file():
        return "there is no such file"
    if anchor and where in pages and anchor not in pages[where].anchors:
        return "there is no such anchor"
    return ""


def _outside(link: str) -> str:
    """Return what is wrong with the form of a link out of the site, or nothing."""
    if not WELL_FORMED.fullmatch(link):
        return "not of the form https://host/path"
    if "doi.org/" in link and not DOI.fullmatch(link):
        return "no DOI: https://doi.org/10.PREFIX/SUFFIX"
    return ""
