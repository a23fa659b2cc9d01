#!/usr/bin/env python3
"""Prints the licences of the packages that are linked into a package of this workspace: the notices that its binary has to carry.

    scripts/release/third_party.py longstep-cli x86_64-unknown-linux-gnu > THIRD-PARTY

Packages with the same text share it. A package without a file of its licence is listed with its identifier (SPDX).
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]

# The names of files with a licence or a notice.
NOTICE = re.compile(r"(?i)(un)?licen[cs]e|copying|copyright|notice")
# Other files with such names are sources.
TEXT = ("", ".md", ".txt")

# Libraries inside a package that name their licence in their sources alone.
BUNDLED = {"llama-cpp-sys-2": ["JSON for Modern C++ 3.12.0 (MIT), Niels Lohmann, in llama.cpp"]}


def linked(metadata: dict[str, Any], root: str) -> set[str]:
    """The ids of the packages that `root` is linked with: normal dependencies, and theirs."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    found: set[str] = set()
    waiting = [root]
    while waiting:
        current = waiting.pop()
        if current not in found:
            found.add(current)
            waiting += [dependency["pkg"] for dependency in nodes[current]["deps"]
                        if any(kind["kind"] is None for kind in dependency["dep_kinds"])]
    return found


def notices(package: dict[str, Any]) -> Iterator[str]:
    """The texts of a package's licences, and of those of the code that it bundles."""
    for file in sorted(Path(package["manifest_path"]).parent.rglob("*")):
        if NOTICE.match(file.name) and (file.suffix in TEXT or file.name.startswith("LICENSE-")) and file.is_file():
            yield file.read_text(encoding="utf-8", errors="replace").strip()


def main() -> int:
    """Reads the graph of dependencies, and prints each text once with the packages that it is for."""
    name, target = sys.argv[1:]
    printed = subprocess.run(["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", target],
                             cwd=ROOT, capture_output=True, check=True).stdout
    metadata = json.loads(printed)
    packages = {package["id"]: package for package in metadata["packages"]}
    root = next(package["id"] for package in metadata["packages"] if package["name"] == name)
    foreign = [packages[found] for found in linked(metadata, root) if packages[found]["source"]]
    by_text: dict[str, list[str]] = defaultdict(list)
    bare = []
    for package in sorted(foreign, key=lambda package: (package["name"], package["version"])):
        label = f"{package['name']} {package['version']} ({package['license'] or 'see the text'})"
        texts = list(dict.fromkeys(notices(package)))
        for text in texts:
            by_text[text].append(label)
        if not texts:
            bare.append(f"{label}, {package['repository'] or 'no repository'}")
        bare += BUNDLED.get(package["name"], [])
    print(f"{name} for {target} is linked with the {len(foreign)} packages below.\n")
    if bare:
        print("Packages that name their licence and come without its text:\n")
        print("\n".join(f"  {line}" for line in bare))
    for text, labels in sorted(by_text.items(), key=lambda item: item[1]):
        print("\n" + "-" * 80 + "\n" + "\n".join(labels) + "\n\n" + text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
