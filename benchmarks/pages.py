"""Makes all pages of evidence anew, one after the other; those on time have programs of their own."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

import evidence
import features
import quality
import volume


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Make all pages of evidence anew.")
    parser.add_argument("--data", default=os.environ.get("VTKSMOOTH_DATA"), help="folder of meshes")
    parser.add_argument("--output", type=Path, default=Path("docs"), help="folder to write to")
    options = parser.parse_args(arguments)
    data = ["--data", options.data] if options.data else []
    for page in (evidence, features, volume):
        page.main([*data, "--output", str(options.output)])
    quality.main([*data, "--output", str(options.output / "quality.md")])


if __name__ == "__main__":
    main()
