#!/usr/bin/env python3
"""Draws the picture of the README: a session of `longstep chat` in a terminal, as the program prints it.

    cargo build --release -p longstep-cli
    scripts/picture.py --program target/release/longstep

Needs a downloaded model and the Python package `rich` (`pip install rich==15.0.0`), which renders the text as SVG.
"""

import argparse
import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sys
import tempfile
import termios
import time
from pathlib import Path

from rich.console import Console
from rich.text import Text

COLUMNS = 88
ENVIRONMENT = "examples/environments/pantry.json"
SESSION = [
    "Put the juice on top of the shelf",
    "you can omit step 4",
    "",
    "Wipe the counter with the cloth",
    "",
]
ESCAPE = re.compile(r"\x1b\[[0-9;?]*([A-Za-z])|\x1b\][^\x07]*\x07|\x1b[=>]")
# The cursor goes back to the end of the prompt that was just drawn.
AT_END = re.compile(r"\r\x1b\[\d+C")
# Switches bracketed paste on, which the program does whenever it reads a line.
READS = b"\x1b[?2004h"
# The template of rich without its web font: the picture loads nothing.
TEMPLATE = """<svg class="rich-terminal" viewBox="0 0 {width} {height}" xmlns="http://www.w3.org/2000/svg">
<title>A session of longstep chat</title>
<style>
.{unique_id}-matrix {{ font-family: ui-monospace, Menlo, Consolas, "DejaVu Sans Mono", monospace; font-size: {char_height}px;
  line-height: {line_height}px; font-variant-east-asian: full-width; }}
.{unique_id}-title {{ font-size: 18px; font-weight: bold; font-family: arial, sans-serif; }}
{styles}
</style>
<defs>
<clipPath id="{unique_id}-clip-terminal"><rect x="0" y="0" width="{terminal_width}" height="{terminal_height}" /></clipPath>
{lines}
</defs>
{chrome}
<g transform="translate({terminal_x}, {terminal_y})" clip-path="url(#{unique_id}-clip-terminal)">
{backgrounds}
<g class="{unique_id}-matrix">
{matrix}
</g>
</g>
</svg>
"""


def shown(raw: str) -> str:
    """Returns what stands on the screen: redrawn lines once, colours kept, other escapes removed."""
    raw = AT_END.sub("", raw)
    text = ESCAPE.sub(lambda match: match.group(0) if match.group(1) == "m" else "", raw)
    drawn = ([part for part in line.split("\r") if part] for line in text.split("\n"))
    return "\n".join(parts[-1] if parts else "" for parts in drawn)


class Terminal:
    """A program in a terminal of its own."""

    def __init__(self, command: list[str], environment: dict[str, str]):
        self.master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 200, COLUMNS, 0, 0))
        self.child = subprocess.Popen(
            command, stdin=slave, stdout=slave, stderr=slave, env=environment, start_new_session=True
        )
        os.close(slave)
        self.raw = b""

    def read_prompt(self, number: int, patience: float) -> None:
        """Reads until the program waits for its line of this number, from 1."""
        end = time.monotonic() + patience
        while self.raw.count(READS) < number:
            if time.monotonic() > end:
                sys.exit(f"no answer in time, after:\n{shown(self.raw.decode(errors='replace'))}")
            if select.select([self.master], [], [], 0.5)[0]:
                self.raw += os.read(self.master, 4096)

    def type(self, line: str) -> None:
        os.write(self.master, line.encode() + b"\r")


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--program", default="target/release/longstep")
    arguments.add_argument("--model", default="qwen2.5-coder-1.5b")
    arguments.add_argument("--out", type=Path, default=Path("docs/session.svg"))
    arguments.add_argument("--patience", type=float, default=600, help="seconds for one reply")
    options = arguments.parse_args()

    with tempfile.TemporaryDirectory() as sessions:
        environment = {**os.environ, "TERM": "xterm-256color", "LONGSTEP_SESSIONS": sessions}
        environment.pop("NO_COLOR", None)
        command = [options.program, "chat", "--env", ENVIRONMENT, "--model", options.model]
        terminal = Terminal(command, environment)
        for number, line in enumerate(SESSION, start=1):
            terminal.read_prompt(number, options.patience)
            terminal.type(line)
        terminal.read_prompt(len(SESSION) + 1, options.patience)
        terminal.child.terminate()

    text = shown(terminal.raw.decode(errors="replace").rpartition(READS.decode())[0])
    # The first line names a temporary folder.
    conversation = text.rstrip().split("\n")[1:]
    console = Console(record=True, width=COLUMNS, file=open(os.devnull, "w"), force_terminal=True, color_system="truecolor")
    console.print(Text(f"$ longstep chat --env {ENVIRONMENT}"))
    for line in conversation:
        console.print(Text.from_ansi(line), soft_wrap=False)
    svg = console.export_svg(title="longstep chat", code_format=TEMPLATE, unique_id="session")
    options.out.write_text(svg)


if __name__ == "__main__":
    main()
