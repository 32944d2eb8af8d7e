"""All cells of the notebooks run, including their assertions."""

import nbformat
import pytest
from nbclient import NotebookClient

from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "plugins" / "python" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert all(not cell.get("outputs") for cell in notebook.cells), "notebooks are kept without outputs"
    NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    for cell in notebook.cells:
        if "plt.subplots" in cell.source:
            assert any("image/png" in output.get("data", {}) for output in cell.outputs), f"no picture is shown:\n{cell.source}"


def test_there_is_a_notebook_for_each_use():
    assert {path.stem for path in NOTEBOOKS} == {"forecast", "identify", "injection", "maps", "measure", "scheduler", "streaks"}
