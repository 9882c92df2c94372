"""Executes notebooks and stores their outputs, without details of the machine.

    python -m tests.notebooks            # executes all notebooks of examples/ and stores their outputs

Read next: `test_notebooks`.
"""

import os
import re
import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

EXAMPLES = Path(__file__).parent.parent / "examples"
SECONDS = 600  # wall-clock limit of one cell; the machine may be busy
ADDRESS = re.compile(r" at 0x[0-9a-f]+")


def executed(path: Path, folder: Path) -> nbformat.NotebookNode:
    """Return a notebook with its outputs, executed in a folder."""
    notebook = nbformat.read(path, 4)
    environment = {"OMP_NUM_THREADS": "1", "NO_COLOR": "1", "PYTHONPATH": str(EXAMPLES.parent)}
    client = NotebookClient(
        notebook, timeout=SECONDS, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    client.execute(env=os.environ | environment)
    for cell in notebook.cells:
        cell.metadata = {}
    notebook.metadata["language_info"] = {"name": "python"}
    return notebook


def kinds(cell: nbformat.NotebookNode) -> list[str]:
    """Return the kinds of a cell's outputs except stderr: "text/plain", "image/png", "stdout" ..."""
    shown = [output for output in cell.get("outputs", ()) if output.get("name") != "stderr"]
    return [output.get("name") or max(output["data"], key=lambda kind: kind != "text/plain") for output in shown]


def store(path: Path) -> None:
    """Execute a notebook in a temporary folder and store its outputs, without stderr and memory addresses."""
    with tempfile.TemporaryDirectory() as folder:
        notebook = executed(path, Path(folder))
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]
    text = ADDRESS.sub("", nbformat.writes(notebook))
    path.write_text(text + "\n")


if __name__ == "__main__":
    for name in sys.argv[1:] or sorted(EXAMPLES.glob("*.ipynb")):
        store(Path(name))
