#!/usr/bin/env python3
"""Checks the pages of documentation: their links, their length, and the length of their lines.

    check_pages.py SOURCE

Every link to a file or heading of this repository must lead somewhere. A page has at most 300 lines. A line has at most 120 characters, but for
rows of tables with measured figures and for code. Pages that studies/ writes are exempt from both.
"""

import pathlib
import re
import sys

MOST_LINES, MOST_CHARACTERS = 300, 120
def without_code(text):
    return re.sub(r"^(```|~~~).*?^\1", "", text, flags=re.M | re.S)


def anchors_of(page):
    """The anchors that GitHub gives the headings of a page."""
    anchors = set()
    for title in re.findall(r"^#+ (.*)$", without_code(page.read_text()), flags=re.M):
        anchor = re.sub(r"[^\w\- ]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title).strip().lower()).replace(" ", "-")
        number = 0
        while (unique := anchor if number == 0 else f"{anchor}-{number}") in anchors:
            number += 1
        anchors.add(unique)
    return anchors


def problems_of(page, source):
    name = str(page.relative_to(source))
    text = page.read_text()
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`\n]*`", "", without_code(text))):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        if not file.exists():
            yield f"{name}: there is no {target}"
        elif anchor and file.suffix == ".md" and anchor not in anchors_of(file):
            yield f"{name}: {target}: the page has no such heading"
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        yield f"{name}: has {len(lines)} lines; expected at most {MOST_LINES}"
    is_code = False
    for number, line in enumerate(lines, 1):
        is_code ^= line.lstrip().startswith("```")
        if len(line) > MOST_CHARACTERS and not is_code and not line.startswith("|"):
            yield f"{name}:{number}: has {len(line)} characters; expected at most {MOST_CHARACTERS}"


def main():
    source = pathlib.Path(sys.argv[1]).resolve()
    pages = [source / "README.md", source / "CONTRIBUTING.md", *sorted((source / "docs").rglob("*.md"))]
    problems = [problem for page in pages for problem in problems_of(page, source)]
    print("\n".join(problems) or f"{len(pages)} pages")
    return 1 if problems or len(pages) < 3 else 0


sys.exit(main())
