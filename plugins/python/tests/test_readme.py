"""The README's example prints the output shown there."""

import contextlib
import io
import re

from conftest import ROOT

README = ROOT / "plugins" / "python" / "README.md"


def test_the_readmes_example():
    text = README.read_text()
    code = re.search(r"```python\n(.*?)```", text, re.DOTALL).group(1)
    expected = re.search(r"```text\n(.*?)```", text, re.DOTALL).group(1)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(code, {})  # noqa: S102
    assert printed.getvalue() == expected
