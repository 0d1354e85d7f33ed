"""Table of coverage by module from the report of `cargo llvm-cov --json`: `python3 results/coverage/table.py REPORT`. Standard library only."""

import collections
import json
import pathlib
import sys


def module(path):
    """The folder under `src` that a file lies in, or the file's own name."""
    parts = pathlib.PurePath(path).parts
    inside = parts[len(parts) - parts[::-1].index("src") :]
    return inside[0]


def main(report):
    files = json.loads(pathlib.Path(report).read_text())["data"][0]["files"]
    counts = collections.defaultdict(lambda: {"lines": [0, 0], "functions": [0, 0]})
    for file in files:
        if "src" not in pathlib.PurePath(file["filename"]).parts:
            continue
        for name in (module(file["filename"]), "all"):
            for what, total in counts[name].items():
                total[0] += file["summary"][what]["covered"]
                total[1] += file["summary"][what]["count"]
    print("| module | lines | run by tests | functions | run by tests |")
    print("|---|---|---|---|---|")
    for name in sorted(counts, key=lambda name: (name == "all", name)):
        cells = []
        for covered, count in counts[name].values():
            cells += [str(count), f"{100 * covered / count:.1f} %" if count else ""]
        print(f"| {name} | " + " | ".join(cells) + " |")


main(*sys.argv[1:])
