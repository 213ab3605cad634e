"""The set-up of `.venv` where Python comes without pip; the rest of it runs in every CI run."""

from __future__ import annotations

import hashlib
import importlib.util
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "scripts" / "bootstrap.py"
DATA = b"a wheel"
SHA256 = hashlib.sha256(DATA).hexdigest()


@pytest.fixture
def bootstrap() -> ModuleType:
    spec = importlib.util.spec_from_file_location("bootstrap", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def link(file: str, *, checksum: str = "", more: str = "") -> str:
    fragment = f"#sha256={checksum}" if checksum else ""
    return f'<a href="../../files/{file}{fragment}" {more}>{file}</a>\n'


def test_the_newest_release_for_this_python_is_taken(bootstrap: ModuleType) -> None:
    page = (
        link("pip-9.0.3-py2.py3-none-any.whl")
        + link("pip-23.0-py3-none-any.whl")
        + link(
            "pip-23.10.1-py3-none-any.whl",
            checksum="abc",
            more='data-requires-python="&gt;=3.7"',
        )
        + link("pip-24.0b1-py3-none-any.whl")
        + link("pip-25.0.tar.gz")
        + link("pip-26.0-py3-none-any.whl", more='data-yanked="broken"')
        + link("pip-99.0-py3-none-any.whl", more='data-requires-python="&gt;=3.99"')
    )
    name = "pip-23.10.1-py3-none-any.whl"
    assert bootstrap.newest_wheel(page) == (name, f"../../files/{name}", "abc")
    with pytest.raises(ValueError, match="no wheel of pip"):
        bootstrap.newest_wheel(link("pip-25.0.tar.gz"))


@pytest.mark.parametrize("checksum", [SHA256, "", "0" * 64])
def test_a_wheel_from_an_index_is_checked(
    bootstrap: ModuleType,
    checksum: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    replies = {
        "https://index.example/simple/pip/": link(
            "pip-26.0-py3-none-any.whl", checksum=checksum
        ).encode(),
        "https://index.example/files/pip-26.0-py3-none-any.whl": DATA,
    }

    class Reply:
        def __init__(self, address: str) -> None:
            self.address = address

        def __enter__(self) -> Reply:
            return self

        def __exit__(self, *_: object) -> None: ...

        def read(self) -> bytes:
            return replies[self.address]

        def geturl(self) -> str:
            return self.address

    monkeypatch.setattr(bootstrap.urllib.request, "urlopen", Reply)
    monkeypatch.setenv("PIP_INDEX_URL", "https://index.example/simple/")
    wheel = bootstrap.index_wheel(tmp_path)
    if checksum.startswith("00"):
        assert wheel is None
        assert "does not have the checksum" in capsys.readouterr().err
    else:
        assert wheel.read_bytes() == DATA


def test_without_an_index_none_is_asked(
    bootstrap: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PIP_INDEX_URL", raising=False)
    monkeypatch.setattr(bootstrap.urllib.request, "urlopen", None)
    assert bootstrap.index_wheel(tmp_path) is None


def test_debians_newest_wheel_is_found(bootstrap: ModuleType, tmp_path: Path) -> None:
    assert bootstrap.debian_wheel(tmp_path, tmp_path) is None
    for version in ("9.0", "23.0.1", "23.0"):
        (tmp_path / f"pip-{version}-py3-none-any.whl").touch()
    (tmp_path / "setuptools-66.1.1-py3-none-any.whl").touch()
    assert bootstrap.debian_wheel(tmp_path, tmp_path).name == "pip-23.0.1-py3-none-any.whl"


def test_a_python_too_old_is_named_with_the_remedy(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bootstrap, "OLDEST", (3, 99))
    message = bootstrap.main([])
    assert "needs Python 3.99 or newer" in message
    assert "make PYTHON=" in message


def test_no_python_at_all_is_said() -> None:
    command = ["make", "-C", str(ROOT), "setup", "PYTHON="]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "no Python 3.11 or newer found" in done.stderr


def test_an_unknown_set_of_tools_is_refused() -> None:
    command = [sys.executable, str(SCRIPT), "everything"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert done.stderr.startswith("usage:")
