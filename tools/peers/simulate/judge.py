"""Client of the batch program: requests go in as lines of JSON, and as many answers come out."""

import json
import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
# Seconds for one answer and for every batch; they only end what hangs.
PATIENCE = 20


def build() -> Path:
    """Builds the batch program and returns its path."""
    command = ["cargo", "build", "--quiet", "--locked", "-p", "longstep-peers", "--bin", "judge"]
    subprocess.run(command, cwd=ROOT, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target") / "debug/judge"


class Judge:
    """Runs the batch program; a request that ends it is answered with what happened, and the rest goes to a new one."""

    def __init__(self, program: Path, patience: float = PATIENCE):
        self.program = program
        self.patience = patience

    def ask(self, requests: list[dict]) -> list[dict]:
        """The answers to requests, in their order."""
        answers: list[dict] = []
        while len(answers) < len(requests):
            rest = requests[len(answers) :]
            got, why = self.run(rest)
            answers += got[: len(rest)]
            if len(answers) < len(requests):
                answers.append({"crash": why})
        return answers

    def run(self, requests: list[dict]) -> tuple[list[dict], str]:
        """The answers of one process, and why there are not more."""
        lines = "".join(json.dumps(request) + "\n" for request in requests)
        try:
            done = subprocess.run(
                [self.program], input=lines, capture_output=True, text=True, timeout=self.patience + 0.2 * len(requests)
            )
            output, why = done.stdout, f"the program ended with {done.returncode}: {done.stderr[:500]}"
        except subprocess.TimeoutExpired as expired:
            output, why = (expired.stdout or b"").decode(), "no answer in time"
        whole = output[: output.rfind("\n") + 1]
        return [json.loads(line) for line in whole.splitlines()], why
