"""A picture in a notebook, executed by a separate kernel."""

# Tests: results/result.py

import nbformat
import pytest
from nbconvert.preprocessors import ExecutePreprocessor

FIRST = 'from chain_impact import simulate\nresult = simulate("rod_drop", 0.1)\nresult.plot()'
SENSITIVE = 'simulate("rod_drop", 0.1, sensitivities="gravity.y").plot_sensitivities()'
FITTED = """from chain_impact import fit
data = {"time": result.time, "point[0].y": result["point[0].y"]}
fit("rod_drop", data, ["gravity.y"], sigma={"point[0].y": 1e-3}, stop_time=0.1).plot()"""


@pytest.mark.full("more cases", but="nothing imported")
@pytest.mark.parametrize(
    "cells",
    [(FIRST, SENSITIVE, FITTED), ("import matplotlib.pyplot", FIRST), ("%matplotlib inline", FIRST)],
    ids=["nothing imported", "pyplot", "inline"],
)
def test_a_picture_shows_itself_once(cells, tmp_path):
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    ExecutePreprocessor(timeout=300).preprocess(notebook, {"metadata": {"path": str(tmp_path)}})
    for cell in notebook.cells:
        pictures = [output for output in cell.outputs if "image/png" in output.get("data", {})]
        assert len(pictures) == len(cell.outputs) == int(cell.source.endswith(")"))
