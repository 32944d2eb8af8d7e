"""Python examples in the READMEs and in docs/: the code runs, and its output is that shown on the page.

Every block ```python of a page runs in the order of the page, with the variables of the blocks before it, in a new
folder with a copy of examples/. A block ```text directly after it is the expected output. HTML comments before the
fence have the meaning defined in tests/docs.py: `<!-- data -->` requires the real data, in the folder data/, and `<!--
not run: REASON -->` is only compiled.
"""

import contextlib
import io
import re
import shutil

import pytest
from conftest import ROOT

EXAMPLE = re.compile(r"((?:^<!-- [^\n]* -->\n\s*)*)^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```)?", re.DOTALL | re.MULTILINE)
READMES = [ROOT / "README.md", ROOT / "plugins" / "python" / "README.md"]
PAGES = [page for page in sorted((ROOT / "docs").rglob("*.md")) if "```python" in page.read_text()]


@pytest.mark.parametrize("page", READMES + PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_examples_print_what_the_page_shows(page, tmp_path, monkeypatch, request):
    text = page.read_text()
    examples = EXAMPLE.findall(text)
    assert len(examples) == text.count("```python"), "a block is not at the beginning of a line"
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    names = {}
    for comments, code, shown in examples:
        program = compile(code, page.name, "exec")
        if "<!-- not run: " in comments:
            continue
        if "<!-- data -->" in comments and not (tmp_path / "data").exists():
            (tmp_path / "data").symlink_to(request.getfixturevalue("data"))
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(program, names)  # noqa: S102
        assert printed.getvalue() == shown
