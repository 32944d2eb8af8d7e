"""Examples of the READMEs and the documentation: the Python code runs and prints what the page shows."""

import contextlib
import io
import re

import pytest
from conftest import ROOT

#: An example with the comment before it and the output shown after it.
EXAMPLE = re.compile(r"(<!-- not run: .+ -->\n)?```python\n(.*?)```\n(?:\n```text\n(.*?)```)?", re.DOTALL)
READMES = [ROOT / "README.md", ROOT / "plugins" / "python" / "README.md"]
PAGES = [page for page in (*READMES, *sorted((ROOT / "docs").rglob("*.md"))) if "```python" in page.read_text()]


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(ROOT)) for page in PAGES])
def test_examples_print_what_the_page_shows(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    examples = EXAMPLE.findall(page.read_text())
    assert examples
    names = {}
    for not_run, code, shown in examples:
        if not_run:
            continue
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(code, names)  # noqa: S102
        assert printed.getvalue() == shown
