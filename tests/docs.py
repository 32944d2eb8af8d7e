#!/usr/bin/env python3
"""Runs the commands in the README and the documentation, and compares their output with that shown on the pages.

    tests/docs.py [--update] [PAGE ...]       default: README.md and all pages of docs/
    tests/docs.py --pictures FOLDER           writes the pictures that pages show, with the commands of these pages

STREAKCAST_BIN is the command line program (default: target/debug/streakcast), STREAKCAST_DATA the folder of real data
(default: ../shared/data).

Each page runs in a new temporary folder with a copy of examples/. In a fenced block ```console, a line that begins with
"$ " is a command, including continuation lines after a backslash and lines of a here-document. The lines up to the next
command are the expected output (standard output and error as on a terminal, without colours). A line "..." matches any
number of lines. If there is no expected output, only the exit status is checked. HTML comments in the lines before the
fence change this:

    <!-- exit 1 -->             the last command of the block ends with this status, not with 0
    <!-- data -->               requires the real data, in the folder data/; skipped with a message if they are missing
    <!-- background -->         the command (a server) runs until the end of the page; its expected output must appear
    <!-- not run: REASON -->    shown only

Python blocks are run by plugins/python/tests/test_readme.py. For numbers in the text that occur in a test, a table or a
source file, comments of the following form are checked, also in CHANGELOG.md and the READMEs of the plugins:

    <!-- figure: TEXT in FILE -->   the text must occur in this file of the repository

A page may show a picture NAME that its own commands write to ../pictures/PAGE/NAME, where PAGE is the name of the page
without `.md`.
`--update` writes the actual output into the pages.
"""

import argparse
import difflib
import os
import pty
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import termios
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: Longest line of a command, columns. Longer lines would be clipped on the page.
LONGEST_COMMAND = 100
TIMEOUT_S = 600
#: Longest time until a command in the background prints the expected output, seconds.
START_S = 60
#: Largest number of lines of output and differences that are shown for a failure.
LONGEST_REPORT = 40
WILDCARD = "..."
FENCE = re.compile(r"^(?P<indent> *)(?P<ticks>`{3,})(?P<language>[^`]*)$")
MARK = re.compile(r"^\s*<!-- (exit (?P<exit>\d+)|(?P<data>data)|(?P<background>background)|not run: (?P<reason>.+)) -->\s*$")
PICTURE = re.compile(r"\]\((?:\.\./)*pictures/(?P<page>[\w-]+)/(?P<name>[\w./-]+)\)")
FIGURE = re.compile(r"<!-- figure: (?P<text>.+?) in (?P<file>\S+) -->")
HERE_DOCUMENT = re.compile(r"<<-?\s*(['\"]?)(\w+)\1")


@dataclass
class Command:
    """One command with its expected output; `first` and `last` are the indices of the output's lines in the page."""

    line: int
    text: str
    first: int
    last: int
    expected: list[str]


@dataclass
class Block:
    line: int
    indent: int
    exit: int = 0
    data: bool = False
    background: bool = False
    reason: str | None = None
    commands: list[Command] = field(default_factory=list)


class PageError(Exception):
    pass


def marks_above(lines, fence):
    """Returns the HTML comments directly above a fence."""
    found, at = {}, fence - 1
    while at >= 0 and (not lines[at].strip() or MARK.match(lines[at])):
        mark = MARK.match(lines[at])
        if mark:
            found |= {key: value for key, value in mark.groupdict().items() if value is not None}
        at -= 1
    return found


def commands_of(lines, first, last, indent):
    """Returns the commands in the lines first to last of a console block."""
    found, at = [], first
    while at < last:
        line = lines[at][indent:]
        if not line.startswith("$ "):
            raise PageError(f"{at + 1}: the block must begin with a command ('$ ')")
        begin, text = at, [line[2:]]
        while at + 1 < last and text[-1].endswith("\\"):
            at += 1
            text.append(lines[at][indent:])
        here = HERE_DOCUMENT.search("\n".join(text))
        if here:
            while at + 1 < last and text[-1] != here[2]:
                at += 1
                text.append(lines[at][indent:])
        for offset, part in enumerate(text):
            if len(part) > LONGEST_COMMAND and not here:
                raise PageError(f"{begin + offset + 1}: a command of {len(part)} columns; break it below {LONGEST_COMMAND} with a backslash")
        output = at + 1
        at = output
        while at < last and not lines[at][indent:].startswith("$ "):
            at += 1
        expected = [part[indent:].rstrip() for part in lines[output:at]]
        found.append(Command(begin + 1, "\n".join(text), output, at, expected))
    return found


def blocks_of(lines):
    """Returns the console blocks of a page. A command of streakcast outside of them is an error."""
    blocks, at = [], 0
    while at < len(lines):
        fence = FENCE.match(lines[at])
        if not fence:
            if re.match(r"^ {4,}(\$ )?streakcast [a-z-]", lines[at]):
                raise PageError(f"{at + 1}: a command outside of a ```console block")
            at += 1
            continue
        begin, indent = at, len(fence["indent"])
        end = begin + 1
        while end < len(lines) and lines[end].strip() != fence["ticks"]:
            end += 1
        marks = marks_above(lines, begin)
        if fence["language"].strip() == "console":
            block = Block(begin + 1, indent, int(marks.get("exit", 0)), "data" in marks, "background" in marks, marks.get("reason"))
            block.commands = commands_of(lines, begin + 1, end, indent)
            blocks.append(block)
        elif "reason" not in marks:
            for inside in range(begin + 1, end):
                if re.match(r"^\s*(\$ )?streakcast [a-z-]", lines[inside]):
                    raise PageError(f"{inside + 1}: a command outside of a ```console block")
        at = end + 1
    return blocks


def matches(expected, actual):
    pattern = "".join(r"(?:.*\n)*?" if line == WILDCARD else re.escape(line) + r"\n" for line in expected)
    return re.fullmatch(pattern, "".join(line + "\n" for line in actual)) is not None


def updated(expected, actual):
    """Returns the actual output with the wildcard of the expected output.

    It has as many lines before and after the wildcard as the expected output.
    """
    if WILDCARD not in expected:
        return actual
    before = expected.index(WILDCARD)
    after = len(expected) - before - 1
    if expected.count(WILDCARD) > 1 or len(actual) <= before + after:
        return None
    return [*actual[:before], WILDCARD, *actual[len(actual) - after :]]


def plain(data):
    """Returns terminal output without control sequences and overwritten progress bars."""
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", data.decode(errors="replace").replace("\r\n", "\n"))
    lines = [line.rpartition("\r")[2].rstrip() for line in text.split("\n")]
    while lines and not lines[-1]:
        lines.pop()
    return lines


class Terminal:
    """A command on a pseudo-terminal, where streakcast prints tables as it does for a user."""

    def __init__(self, text, folder, environment):
        self.reader, writer = pty.openpty()
        modes = termios.tcgetattr(writer)
        modes[1] &= ~termios.OPOST
        termios.tcsetattr(writer, termios.TCSANOW, modes)
        termios.tcsetwinsize(writer, (50, 400))
        self.process = subprocess.Popen(
            ["bash", "-o", "pipefail", "-c", text],
            cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=writer, stderr=writer, start_new_session=True,
        )  # fmt: skip
        os.close(writer)
        self.data = b""

    def read(self, seconds, until=lambda: False):
        """Reads until the command ends or `until` returns true. Returns False after `seconds`."""
        end = time.monotonic() + seconds
        while time.monotonic() < end and not until():
            if not select.select([self.reader], [], [], 0.1)[0]:
                continue
            try:
                data = os.read(self.reader, 65536)
            except OSError:
                data = b""
            if not data:
                return True
            self.data += data
        return until()

    def stop(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGTERM)
            self.process.wait(timeout=30)
        os.close(self.reader)


class Run:
    def __init__(self, binary, data, update, pictures):
        self.binary, self.data, self.update, self.pictures = binary, data, update, pictures
        self.ran, self.shown, self.skipped, self.figures, self.failures = 0, 0, 0, 0, []

    def page(self, path):
        name = path.relative_to(ROOT) if path.is_relative_to(ROOT) else path
        lines = path.read_text().splitlines()
        try:
            blocks = blocks_of(lines)
        except PageError as error:
            self.failures.append(f"{name}:{error}")
            return
        self.check_figures(name, lines)
        shown = [(number, found) for number, line in enumerate(lines, 1) for found in PICTURE.finditer(line)]
        if not (shown if self.pictures else blocks):
            return
        replacements = []
        servers = []
        with tempfile.TemporaryDirectory(prefix="streakcast-docs-") as folder:
            folder = Path(folder).resolve()
            work, home, bin_folder = folder / "work", folder / "home", folder / "bin"
            home.mkdir()
            bin_folder.mkdir()
            shutil.copytree(ROOT / "examples", work / "examples")
            (bin_folder / "streakcast").symlink_to(self.binary)
            if self.data:
                (work / "data").symlink_to(self.data)
            environment = {key: value for key, value in os.environ.items() if not key.startswith(("STREAKCAST_", "XDG_"))}
            environment |= {"PATH": f"{bin_folder}:{environment['PATH']}", "HOME": str(home), "NO_COLOR": "1", "LC_ALL": "C.UTF-8", "COLUMNS": "100"}
            try:
                for block in blocks:
                    self.block(name, block, work, environment, replacements, servers)
            finally:
                for server in servers:
                    server.stop()
            for number, picture in shown:
                if picture["page"] != path.stem or not (work / picture["name"]).is_file():
                    self.failures.append(f"{name}:{number}: the commands of the page do not write {picture['name']}")
                elif self.pictures:
                    target = self.pictures / path.stem / picture["name"]
                    target.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy(work / picture["name"], target)
        if self.update and replacements:
            for command, indent, actual in reversed(replacements):
                lines[command.first : command.last] = [(" " * indent + line).rstrip() for line in actual]
            path.write_text("\n".join(lines) + "\n")
            print(f"{name}: {len(replacements)} outputs updated")

    def check_figures(self, name, lines):
        """Checks the comments that tie numbers of a text to a file."""
        for number, line in enumerate(lines, 1):
            if "<!-- figure" not in line:
                continue
            figure = FIGURE.search(line)
            self.figures += 1
            if not figure:
                self.failures.append(f"{name}:{number}: not of the form <!-- figure: TEXT in FILE --> in one line")
            elif not (ROOT / figure["file"]).is_file():
                self.failures.append(f"{name}:{number}: there is no {figure['file']}")
            elif figure["text"] not in (ROOT / figure["file"]).read_text():
                self.failures.append(f"{name}:{number}: {figure['file']} does not contain '{figure['text']}'")

    def block(self, name, block, work, environment, replacements, servers):
        if block.reason:
            self.shown += 1
            return
        if block.data and not self.data:
            self.skipped += 1
            print(f"*** SKIPPED the commands of {name}:{block.line}: no folder of real data (STREAKCAST_DATA) ***")
            return
        for number, command in enumerate(block.commands):
            self.ran += 1
            where = f"{name}:{command.line}: $ {command.text}"
            terminal = Terminal(command.text, work, environment)
            if block.background:
                servers.append(terminal)
                if not terminal.read(START_S, lambda: matches(command.expected, plain(terminal.data)) and bool(terminal.data)):
                    if self.update and updated(command.expected, plain(terminal.data)):
                        replacements.append((command, block.indent, updated(command.expected, plain(terminal.data))))
                        continue
                    self.failures.append(f"{where}\nthe expected output did not appear; the command printed:\n" + "\n".join(plain(terminal.data)))
                continue
            ended = terminal.read(TIMEOUT_S)
            status = terminal.process.wait(timeout=30) if ended else None
            terminal.stop()
            actual = plain(terminal.data)
            expected_status = block.exit if number == len(block.commands) - 1 else 0
            if status != expected_status:
                how = f"no end after {TIMEOUT_S} s" if status is None else f"exit status {status}, not {expected_status}"
                self.failures.append(f"{where}\n{how}; it printed:\n" + "\n".join(actual[:LONGEST_REPORT]))
            elif command.expected and not matches(command.expected, actual):
                new = updated(command.expected, actual) if self.update else None
                if new is None:
                    shortened = updated(command.expected, actual) or actual
                    difference = difflib.unified_diff(command.expected, shortened, "page", "output", lineterm="", n=1)
                    self.failures.append(f"{where}\n" + "\n".join([*difference][:LONGEST_REPORT]))
                else:
                    replacements.append((command, block.indent, new))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pages", nargs="*", type=Path, metavar="PAGE", help="default: README.md and all pages of docs/")
    parser.add_argument("--update", action="store_true", help="write the actual output into the pages")
    parser.add_argument("--pictures", type=Path, metavar="FOLDER", help="run the pages with pictures and copy these into the folder")
    options = parser.parse_args()
    binary = Path(os.environ.get("STREAKCAST_BIN", ROOT / "target/debug/streakcast")).resolve()
    if not binary.is_file():
        parser.error(f"no command line {binary}: build it with cargo build, or set STREAKCAST_BIN")
    data = Path(os.environ.get("STREAKCAST_DATA", ROOT.parent / "shared/data")).resolve()
    run = Run(binary, data if (data / "INDEX.md").is_file() else None, options.update, options.pictures)
    for page in options.pages or [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        run.page(page.resolve())
    if not options.pages:
        for path in [ROOT / "CHANGELOG.md", *sorted((ROOT / "plugins").glob("*/README.md"))]:
            run.check_figures(path.relative_to(ROOT), path.read_text().splitlines())
    for failure in run.failures:
        print(f"FAILED {failure}\n")
    print(f"{run.ran} commands run, {run.shown} blocks shown only, {run.skipped} skipped, {run.figures} figures compared, {len(run.failures)} failed")
    return 1 if run.failures else 0


if __name__ == "__main__":
    sys.exit(main())
