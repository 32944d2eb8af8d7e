#!/usr/bin/env python3
"""Whether what is installed brings the texts of its licence: `plugins/licences.py NAME`, in the environment of a plugin."""

from __future__ import annotations

import sys
from importlib.metadata import distribution
from pathlib import Path


def main() -> None:
    name = sys.argv[1]
    package = "streakcast" if name == "python" else f"streakcast-{name}"
    here = Path(__file__).resolve().parent
    wanted = [here / name / "LICENSE"] if (here / name / "LICENSE").is_file() else [here.parent / f"LICENSE-{one}" for one in ("MIT", "APACHE")]
    found = distribution(package)
    texts = {(found.read_text(f"licenses/{one}") or "") for one in found.metadata.get_all("License-File", [])}
    missing = [path.name for path in wanted if path.read_text() not in texts]
    if missing:
        sys.exit(f"plugins/licences.py: what is installed of {package} has no {', '.join(missing)}")


if __name__ == "__main__":
    main()
