"""Executes a notebook, and checks that it ends and shows a picture: `notebook.py FILE`."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

# The packages have no types, or not all of them.
import nbclient
import nbformat


def main(path: Path) -> None:
    """Executes the notebook in a copy; the file stays as it is."""
    notebook: Any = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        client = nbclient.NotebookClient(notebook, timeout=300, kernel_name="longstep", resources={"metadata": {"path": path.parent}})
        client.km = kernel(Path(folder))
        client.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    pictures = [output for output in outputs if "image/svg+xml" in output.get("data", {})]
    assert pictures, "the notebook shows no picture"
    print(f"{path.name}: {len(notebook.cells)} cells, {len(pictures)} pictures")


def kernel(folder: Path) -> Any:
    """Returns a kernel of this interpreter, whatever kernels are installed."""
    from jupyter_client.kernelspec import KernelSpec
    from jupyter_client.manager import AsyncKernelManager

    manager = AsyncKernelManager(connection_file=str(folder / "kernel.json"))
    arguments = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    manager._kernel_spec = KernelSpec(argv=arguments, display_name="longstep", language="python")
    return manager


if __name__ == "__main__":
    main(Path(sys.argv[1]))
