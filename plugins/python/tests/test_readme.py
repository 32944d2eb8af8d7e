"""Examples of the READMEs: the Python code runs and prints what the page shows."""

import contextlib
import io
import re

import pytest
from conftest import ROOT

PAGES = [ROOT / "README.md", ROOT / "plugins" / "python" / "README.md"]


@pytest.mark.parametrize("page", PAGES, ids=["project", "wheel"])
def test_examples_print_what_the_page_shows(page):
    examples = re.findall(r"```python\n(.*?)```\n(?:\n```text\n(.*?)```)?", page.read_text(), re.DOTALL)
    assert examples
    names = {}
    for code, shown in examples:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(code, names)  # noqa: S102
        assert printed.getvalue() == shown
