"""Reference pages that are generated from the command line itself: `generate.py BINARY FOLDER`; docs/build.sh calls it.

Writes into FOLDER, a copy of docs/: `reference/verbs/VERB.md` (help texts), `generated/columns.md` (column tables of real runs),
`generated/http-api.md` (the server's OpenAPI document) and `generated/types.md` (named types of the Python package).
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BINARY, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
SATELLITES = ["--shells", "starlink-gen1", "--mpc", "X05"]
FIELD = ["--fov", "3.5deg", "--telescope", "rubin"]

#: How-to guide of each verb that has one.
GUIDES = {
    "alarms": "learn", "annotate": "annotate", "doctor": "elements", "ephemeris": "forecast", "fetch": "elements", "fit": "fit", "flag": "policy", "forecast": "forecast", "gate": "gate",
    "identify": "identify", "inject": "inject", "learn": "learn", "map": "maps", "mask": "mask", "measure": "measure", "model": "models", "plot": "plots", "reproduce": "statistics", "serve": "serve",
    "setup": "setup", "statistics": "statistics", "windows": "windows",
}  # fmt: skip

#: Tables of the reference page: heading, command, and the file with the table (standard output if None).
TABLES = [
    ("passes", ["passes", *SATELLITES, *FIELD, "--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7"], None),
    ("flag", ["flag", *SATELLITES, *FIELD, "--schedule", "examples/night.csv"], None),
    ("windows", ["windows", *SATELLITES, *FIELD, "--targets", "targets.csv", "--night", "2026-08-14"], None),
    ("forecast", ["forecast", *SATELLITES, "--night", "2026-08-14", "--max-mag", "5", "--light-curves", "curves.ecsv"], None),
    ("forecast --light-curves", None, "curves.ecsv"),
    ("ephemeris", ["ephemeris", *SATELLITES, "--name", "S1 P24-1", "--times", "2026-08-14T23:29:05Z"], None),
    ("identify", ["identify", *SATELLITES, "--end", "198.655,5.967", "--end", "199.194,9.426", "--start", "2026-08-14T23:29:05Z", "--exposure", "30s"], None),
    ("inject --truth", ["inject", "--synthetic", "examples/synthetic.toml", "-o", "frame.fits", "--random-streaks", "1", "--magnitude", "5", "--exposure",
                        "30s", "--seeing", "1.5arcsec", "--truth", "truth.ecsv"], "truth.ecsv"),
    ("measure --streaks", ["measure", "--streaks", "truth.ecsv"], None),
    ("mask --polygons", ["mask", "frame.fits", *SATELLITES, "--width", "10arcsec", "--polygons", "mask.ecsv"], "mask.ecsv"),
    ("statistics", ["statistics", *SATELLITES, "--night", "2026-08-14", "--exposure", "30s"], None),
    ("map sky", ["map", "sky", "--model", "starlink-v1.5", "--sun-altitude-deg", "-16", "--height-km", "550"], None),
    ("map body", ["map", "body", "--model", "starlink-v1.5", "--sun-latitude-deg", "-14"], None),
    ("model list", ["model", "list"], None),
    ("model check", ["model", "check"], None),
    ("model pressure", ["model", "pressure", "starlink-v1.5", "--mass-kg", "295", "--sun-latitude-deg", "-20"], None),
    ("doctor", ["doctor", *SATELLITES, "--now", "2026-08-14T00:00:00Z"], None),
    ("sites", ["sites"], None),
    ("shells", ["shells"], None),
]  # fmt: skip

COLUMN = re.compile(r'^# - \{name: (?P<name>[^,}]+)(?:, unit: (?P<unit>[^,}]+))?, datatype: (?P<type>[^,}]+)(?:, subtype: [^}]*?)?(?:, description: "(?P<text>.*)")?\}$')


def run(*arguments, **options):
    environment = {**os.environ, "NO_COLOR": "1"}
    return subprocess.run([BINARY, *arguments], check=True, capture_output=True, text=True, env=environment, **options).stdout


def commands_of(text):
    """Names of the verbs that a help text lists."""
    listed = text.partition("Commands:\n")[2].split("\n\n")[0]
    return [name for name in re.findall(r"^  ([a-z][a-z0-9-]*)(?: |$)", listed, re.MULTILINE) if name != "help"]


def help_sections(words, level):
    """Markdown sections with the help of a verb and of its subcommands."""
    text = run(*words, "--help")
    about, _, rest = text.partition("\n\n")
    about = " ".join(about.split())
    yield f"{'#' * level} streakcast {' '.join(words)}\n\n{about}{'' if about.endswith('.') else '.'}\n\n```text\n{rest.rstrip()}\n```\n"
    for verb in commands_of(text):
        yield from help_sections([*words, verb], level + 1)


def verbs():
    folder = FOLDER / "reference/verbs"
    folder.mkdir(parents=True, exist_ok=True)
    for verb in commands_of(run("--help")):
        first, *others = help_sections([verb], 1)
        if verb in GUIDES:
            heading, _, rest = first.partition("\n\n```text")
            first = f"{heading} How-to guide: [](../../how-to/{GUIDES[verb]}.md).\n\n```text{rest}"
        (folder / f"{verb}.md").write_text("\n".join([first, *others]))


def columns():
    parts = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "examples").symlink_to(ROOT / "examples")
        (folder / "targets.csv").write_text("name,ra_deg,dec_deg,exposure_s\nM 104,190.0,-11.6,60\n")
        for name, command, file in TABLES:
            text = run(*command, *([] if command[0] in ("inject", "mask") else ["--format", "ecsv"]), cwd=folder) if command else ""
            lines = (folder / file).read_text().splitlines() if file else text.splitlines()
            rows = [COLUMN.match(line) for line in lines if line.startswith("# - {name")]
            if not rows or None in rows:
                raise SystemExit(f"docs/generate.py: cannot read the columns of {name}")
            parts.append(f"## {name}\n\n| column | unit | type | description |\n|---|---|---|---|\n")
            parts += [f"| `{row['name']}` | {row['unit'] or ''} | {row['type']} | {(row['text'] or '').replace('|', '/')} |\n" for row in rows]
            parts.append("\n")
    (FOLDER / "generated/columns.md").write_text("".join(parts))


def document():
    """OpenAPI document of a running server."""
    command = [BINARY, "serve", *SATELLITES, *FIELD, "--schedule", "examples/night.csv", "--bind", "127.0.0.1:0", "--quiet"]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as server:
        try:
            address = server.stdout.readline().strip()
            with urllib.request.urlopen(f"{address}openapi.json", timeout=60) as answer:
                return json.load(answer)
        finally:
            server.terminate()


def values_of(schema):
    """Type and range of a value in words."""
    if "enum" in schema:
        return ", ".join(f"`{value}`" for value in schema["enum"])
    kind = schema.get("type", "any")
    kind = ", ".join(one for one in kind if one != "null") if isinstance(kind, list) else kind
    if "minimum" in schema and "maximum" in schema:
        return f"{kind}, {schema['minimum']:g} to {schema['maximum']:g}"
    return f"time, as `{schema['example']}`" if "example" in schema else kind


def keys_of(schema, path=""):
    """Keys of a response, with a dot between levels and [] after lists."""
    for one in schema.get("anyOf", []):
        yield from keys_of(one, path)
    if "items" in schema and isinstance(schema["items"], dict):
        yield from keys_of(schema["items"], f"{path}[]")
    for name, value in schema.get("properties", {}).items():
        key = f"{path}.{name}" if path else name
        inner = list(keys_of(value, key))
        if not inner or value.get("description"):
            yield key, values_of(value), value.get("description", "")
        yield from inner


def http_api():
    api = document()
    parts = []
    for path, methods in api["paths"].items():
        method = methods["get"]
        token = "No token is required." if method.get("security") == [] else ""
        parts.append(f"## `{path}`\n\n{method['summary']} {token}\n\n")
        if method.get("parameters"):
            parts.append("| parameter | required | values | meaning |\n|---|---|---|---|\n")
            parts += [f"| `{one['name']}` | {'yes' if one['required'] else ''} | {values_of(one['schema'])} | {one['description']} |\n" for one in method["parameters"]]
            parts.append("\n")
        content = method["responses"]["200"]["content"]["application/json"]["schema"]
        seen = dict.fromkeys(keys_of(content))
        if seen:
            parts.append("| key of the response | type | meaning |\n|---|---|---|\n")
            parts += [f"| `{key}` | {kind} | {text} |\n" for key, kind, text in seen]
            parts.append("\n")
    parts.append("## Errors\n\n| status | condition |\n|---|---|\n")
    parts += [f"| {status} | {answer['description']} |\n" for status, answer in sorted(api["components"]["responses"].items())]
    (FOLDER / "generated/http-api.md").write_text("".join(parts))


def python_types():
    """Table of the named types of the Python package, from the comments and docstrings of its source."""
    source = (ROOT / "plugins/python/python/streakcast/typing.py").read_text()
    named = re.findall(r'((?:^#: .*\n)+)^(\w+) = |^class ([A-Z]\w+)\(.*\n    """(.*)"""$', source, re.MULTILINE)
    rows = sorted((alias or kind, " ".join(re.sub("^#: ", "", comment, flags=re.MULTILINE).split()) or text) for comment, alias, kind, text in named)
    parts = ["| name | meaning |\n|---|---|\n"]
    parts += [f"| `{name}` | {text} |\n" for name, text in rows]
    (FOLDER / "generated/types.md").write_text("".join(parts))


(FOLDER / "generated").mkdir(exist_ok=True)
verbs()
columns()
http_api()
python_types()
