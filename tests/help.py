"""Help texts of all verbs and their subcommands: `help.py BINARY`. The diff of two outputs shows changes of flags."""

import re
import subprocess
import sys


def show(binary, words):
    text = subprocess.run([binary, *words, "--help"], check=True, capture_output=True, text=True).stdout
    print(f"===== streakcast {' '.join(words)}\n{text}")
    listed = text.partition("Commands:\n")[2].split("\n\n")[0]
    for name in re.findall(r"^  ([a-z][a-z0-9-]*)(?: |$)", listed, re.MULTILINE):
        if name != "help":
            show(binary, [*words, name])


show(sys.argv[1], [])
