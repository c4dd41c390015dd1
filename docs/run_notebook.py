"""Run the code cells of notebooks and store their outputs in them: python docs/run_notebook.py NOTEBOOK.ipynb."""

from __future__ import annotations

import ast
import base64
import io
import json
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from stagecad.parameters.atomic import atomic_write_text


def run(document: dict[str, Any]) -> dict[str, Any]:
    """Run the code cells of a notebook in order, in one namespace; store what each prints, the value of its last
    expression and its open figures as outputs. Returns the namespace."""
    names: dict[str, Any] = {}
    cells = [cell for cell in document["cells"] if cell["cell_type"] == "code"]
    for count, cell in enumerate(cells, 1):
        source = "".join(cell["source"])
        tree = ast.parse(source)
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        outputs = []
        with redirect_stdout(io.StringIO()) as printed:
            exec(compile(tree, f"cell {count}", "exec"), names)
        if isinstance(last, ast.Expr):
            with redirect_stdout(printed):
                value = eval(compile(ast.Expression(last.value), f"cell {count}", "eval"), names)
            # A semicolon at the end suppresses the output.
            if value is not None and not source.endswith(";"):
                result = {"execution_count": count, "metadata": {}, "data": shown(value)}
                outputs.append({"output_type": "execute_result", **result})
        if printed.getvalue():
            text = printed.getvalue().splitlines(keepends=True)
            outputs.insert(0, {"output_type": "stream", "name": "stdout", "text": text})
        for number in plt.get_fignums():
            picture = io.BytesIO()
            plt.figure(number).savefig(picture, format="png", dpi=60, metadata={"Software": None})
            data = {"image/png": base64.b64encode(picture.getvalue()).decode("ascii")}
            outputs.append({"output_type": "display_data", "metadata": {}, "data": data})
        plt.close("all")
        cell.update(execution_count=count, outputs=outputs)
    return names


def shown(value: Any) -> dict[str, Any]:
    """A value as a notebook shows it: as text, and as a page or a picture where it has one."""
    data: dict[str, Any] = {"text/plain": [repr(value)]}
    if hasattr(value, "_repr_html_") and (page := value._repr_html_()):
        data["text/html"] = page.splitlines(keepends=True)
    if hasattr(value, "savefig"):
        data = {"text/plain": ["<Figure>"], "image/png": picture(value)}
    return data


def picture(figure: Any) -> str:
    """A figure as PNG in base 64."""
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=90, metadata={"Software": None})
    return base64.b64encode(out.getvalue()).decode("ascii")


if __name__ == "__main__":
    for name in sys.argv[1:]:
        notebook = json.loads(Path(name).read_text(encoding="utf-8"))
        run(notebook)
        atomic_write_text(Path(name), json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")
