#!/usr/bin/env python3
"""Checks that an installed plugin contains its licence texts: `plugins/licences.py NAME` in its environment."""

from __future__ import annotations

import sys
from importlib.metadata import distribution
from pathlib import Path


def main() -> None:
    name = sys.argv[1]
    package = "streakcast" if name == "python" else f"streakcast-{name}"
    here = Path(__file__).resolve().parent
    expected = [here / name / "LICENSE"] if (here / name / "LICENSE").is_file() else [here.parent / f"LICENSE-{one}" for one in ("MIT", "APACHE")]
    installed = distribution(package)
    texts = {(installed.read_text(f"licenses/{one}") or "") for one in installed.metadata.get_all("License-File", [])}
    missing = [path.name for path in expected if path.read_text() not in texts]
    if missing:
        sys.exit(f"plugins/licences.py: installed package {package} has no {', '.join(missing)}")


if __name__ == "__main__":
    main()
