"""Set up the virtual environment that `make` works in; the standard library is all it needs.

    python3 scripts/bootstrap.py [dev]

Makes `.venv` beside the Makefile and installs roughbench into it, with the tools for
tests and lint if `dev` is given. Where it has been done before, with the same
pyproject.toml, nothing happens. Neither root nor the package python3-venv is needed:
where Python comes without ensurepip, pip is taken from the first of

1. pip of the same Python, which can install into another environment;
2. the wheel of Debian's package python3-pip-whl, if it is installed;
3. the index that PIP_INDEX_URL names;
4. that Debian package, downloaded and unpacked by apt-get and dpkg-deb, without root.
"""

import hashlib
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.parse
import urllib.request
from pathlib import Path

OLDEST = (3, 11)
FOLDER = Path(__file__).resolve().parents[1]
VENV = FOLDER / ".venv"
PYTHON = VENV / "bin" / "python"
STAMP = VENV / "roughbench-setup.json"
DEBIAN_WHEELS = Path("/usr/share/python-wheels")

NO_PIP = """\
error: {python} has neither ensurepip nor pip, and there is no pip to be had elsewhere.
One of these helps:
  - as root: apt-get install python3-venv
  - a Python that has ensurepip: make PYTHON=/path/to/python3 ...
  - the address of a package index: PIP_INDEX_URL=https://.../simple make ..."""


def main(extras):
    """Set up `.venv` unless it is there and complete."""
    if sys.version_info < OLDEST:
        return (
            "error: roughbench needs Python {}.{} or newer, {} is {}; name another one: "
            "make PYTHON=/path/to/python3 ...".format(
                *OLDEST, sys.executable, sys.version.split()[0]
            )
        )
    wanted = extras[0] if extras else ""
    if wanted not in ("", "dev") or len(extras) > 1:
        return "usage: python3 scripts/bootstrap.py [dev]"
    project = hashlib.sha256((FOLDER / "pyproject.toml").read_bytes()).hexdigest()
    done = read_stamp()
    if done.get("folder") != str(FOLDER) or not runs():
        done = {}
        make_environment()
    if done.get("project") == project and done.get("extras") in (wanted, "dev"):
        return None
    # What is there stays: an environment with the tools for tests keeps them.
    extras = "dev" if "dev" in (wanted, done.get("extras")) else ""
    target = f".[{extras}]" if extras else "."
    print(f"installing roughbench and what it needs into {VENV.name} ...", flush=True)
    pip = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    if subprocess.run([*pip, "--editable", target], cwd=FOLDER).returncode:
        return "error: pip could not install roughbench (see above)"
    stamp = {"folder": str(FOLDER), "project": project, "extras": extras}
    STAMP.write_text(json.dumps(stamp))
    return None


def read_stamp():
    """Return what an earlier call noted; empty if there was none."""
    try:
        return json.loads(STAMP.read_text())
    except (OSError, ValueError):
        return {}


def runs():
    """Whether the environment's Python works and has pip."""
    try:
        command = [PYTHON, "-c", "import pip"]
        return not subprocess.run(command, stderr=subprocess.DEVNULL).returncode
    except OSError:
        return False


def make_environment():
    """Make `.venv` anew, with pip."""
    # From within an environment (perhaps this very one) work with the Python behind it.
    python = getattr(sys, "_base_executable", None) or sys.executable
    print(f"making {VENV.name} with {python} ({sys.version.split()[0]})", flush=True)
    if VENV.is_dir():
        if not (VENV / "pyvenv.cfg").exists():
            sys.exit(f"error: {VENV} is no virtual environment; move it away")
        shutil.rmtree(VENV)
    has_ensurepip = succeeds(python, "-c", "import ensurepip")
    arguments = ["-m", "venv", *([] if has_ensurepip else ["--without-pip"]), VENV]
    if not succeeds(python, *arguments, quiet=False):
        sys.exit(
            f"error: {python} cannot make a virtual environment; as root: "
            "apt-get install python3-venv, or name another one: make PYTHON=... "
        )
    if not has_ensurepip and not install_pip(python):
        shutil.rmtree(VENV)
        sys.exit(NO_PIP.format(python=python))


def install_pip(python):
    """Install pip into an environment made without it; False if there is none to be had."""
    if succeeds(python, "-m", "pip", "--python", PYTHON, "install", "--quiet", "pip"):
        return True
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for source in (debian_wheel, index_wheel, downloaded_debian_wheel):
            wheel = source(folder)
            # A wheel is a zip file, and pip runs from within its own.
            if wheel and succeeds(
                PYTHON, wheel / "pip", "install", "--quiet", "--no-index", wheel, quiet=False
            ):
                print(f"pip: {wheel.name}", flush=True)
                return True
    return False


def succeeds(*command, quiet=True):
    """Run a command; False if it fails or does not exist."""
    output = subprocess.DEVNULL if quiet else None
    try:
        return not subprocess.run(command, stdout=output, stderr=output).returncode
    except OSError:
        return False


def debian_wheel(_folder, wheels=DEBIAN_WHEELS):
    """Return pip's wheel of the installed package python3-pip-whl, or None."""
    return max(wheels.glob("pip-*-py3-none-any.whl"), default=None, key=version_of)


def downloaded_debian_wheel(folder):
    """Return pip's wheel of the package python3-pip-whl, fetched without root, or None."""
    try:
        subprocess.run(["apt-get", "download", "python3-pip-whl"], cwd=folder, check=True)
        for package in folder.glob("*.deb"):
            subprocess.run(["dpkg-deb", "-x", package, folder], check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return debian_wheel(folder, folder / DEBIAN_WHEELS.relative_to("/"))


def index_wheel(folder):
    """Return pip's wheel from the index that PIP_INDEX_URL names, or None."""
    index = os.environ.get("PIP_INDEX_URL", "").rstrip("/")
    if not index:
        return None
    try:
        with urllib.request.urlopen(f"{index}/pip/") as reply:  # noqa: S310 (the user's own)
            page, base = reply.read().decode(), reply.geturl()
        name, address, checksum = newest_wheel(page)
        with urllib.request.urlopen(urllib.parse.urljoin(base, address)) as reply:  # noqa: S310
            data = reply.read()
    except (OSError, ValueError) as error:
        print(f"no pip from the index of PIP_INDEX_URL: {error}", file=sys.stderr)
        return None
    if checksum and hashlib.sha256(data).hexdigest() != checksum:
        print(f"{name} does not have the checksum that its index names", file=sys.stderr)
        return None
    wheel = folder / name
    wheel.write_bytes(data)
    return wheel


def newest_wheel(page):
    """Return name, address and SHA-256 of the newest pip on a page of a simple index."""
    found = []
    for tag in re.findall(r"<a\s[^>]*>", page):
        address, _, fragment = link_of(tag, "href").partition("#")
        name = urllib.parse.unquote(address.rpartition("/")[2])
        floor = re.search(r">=\s*3\.(\d+)", link_of(tag, "data-requires-python"))
        too_new = floor is not None and int(floor[1]) > sys.version_info.minor
        released = re.fullmatch(r"pip-\d+(\.\d+)*-py3-none-any\.whl", name)
        if released and not too_new and "data-yanked" not in tag:
            checksum = fragment.partition("sha256=")[2]
            found.append((version_of(name), name, address, checksum))
    if not found:
        raise ValueError("it lists no wheel of pip for this Python")
    return max(found)[1:]


def link_of(tag, attribute):
    """Return an attribute of an HTML tag, or nothing."""
    value = re.search(rf"\b{attribute}\s*=\s*[\"']([^\"']*)[\"']", tag)
    return html.unescape(value[1]) if value else ""


def version_of(wheel):
    """Return the version in the name of a wheel, for comparing."""
    return [int(part) for part in re.findall(r"\d+", Path(wheel).name.split("-")[1])]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
