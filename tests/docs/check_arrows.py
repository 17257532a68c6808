#!/usr/bin/env python3
"""Compares the #include lines of the stages with the arrows of docs/architecture.md.

    check_arrows.py PROJECT

CMake refuses a link without an arrow, but a header may also be reached through another stage. Each include of another stage needs an arrow, and each
arrow an include.
"""

import pathlib
import re
import sys


def listed_arrows(page):
    lines = re.findall(r"^([a-z0-9_]+) -> *(.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {(stage, other) for stage, others in lines for other in others.split()}


def stages_by_folder(library):
    """The stage of each folder, by the sources that CMake's add_stage lists."""
    names = {}
    for file in library.rglob("CMakeLists.txt"):
        for name, files in re.findall(r"add_stage\((\w+)([^()]*)\)", file.read_text(encoding="utf-8")):
            names.update({(file.parent / source).parent: name for source in re.findall(r"\S+\.[ch]pp", files)})
    return names


def included_arrows(library):
    """A file and what it includes, for each pair of stages."""
    names = stages_by_folder(library)
    arrows = {}
    for file in sorted(library.rglob("*.[ch]pp")):
        for header in re.findall(r'^#include "tactile/(.+)"$', file.read_text(encoding="utf-8"), re.MULTILINE):
            pair = names[file.parent], names[(library / header).parent]
            if pair[0] != pair[1]:
                arrows.setdefault(pair, f"{file.relative_to(library.parent)} includes tactile/{header}")
    return arrows


def main():
    project = pathlib.Path(sys.argv[1])
    listed = listed_arrows(project / "docs" / "architecture.md")
    included = included_arrows(project / "lib" / "tactile")
    if not included:
        print("no include found; expected some in lib/tactile")
        return 1
    missing = sorted(included.keys() - listed)
    unused = sorted(listed - included.keys())
    for stage, other in missing:
        print(f"{included[stage, other]}; expected the arrow {stage} -> {other} in docs/architecture.md")
    for stage, other in unused:
        print(f"docs/architecture.md: no file of {stage} includes {other}; expected no arrow {stage} -> {other}")
    return 1 if missing or unused else 0


sys.exit(main())
