"""``python -m roughbench``: the same as the command ``roughbench``."""

from __future__ import annotations

from roughbench.cli import main

if __name__ == "__main__":  # worker processes import this file too
    main()
