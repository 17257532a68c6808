#!/usr/bin/env python3
"""Checks that files and functions are short.

    check_sizes.py SOURCE

No file of C++ or JavaScript in lib/ and apps/ has more than 450 lines. No function of C++ there has more than 60, from its signature to its last
brace, unless its body begins with a comment that says why.
"""

import pathlib
import re
import sys

MOST_LINES_OF_FILE, MOST_LINES_OF_FUNCTION = 450, 60
TYPE = re.compile(r"(template <.*> )?(class|struct|union|enum)\b")


def without_raw_strings(text):
    """Without the contents of raw strings, whose lines are not indented as code."""
    return re.sub(r'R"(\w*)\(.*?\)\1"', lambda raw: '""' + "\n" * raw[0].count("\n"), text, flags=re.S)


def functions_of(lines, begin, end, indentation):
    """The first and the last index of each function in lines[begin:end]. clang-format has indented them: only the first line of a definition and its
    closing brace have the indentation of their scope. What namespaces hold is not indented."""
    first = None
    for i in range(begin, end):
        line = lines[i]
        if line.startswith("#") or not line.strip() or len(line) - len(line.lstrip()) != indentation:
            continue
        code = line.strip()
        if not code.startswith("}"):
            first = None if code.startswith(("namespace", "extern", "//")) else i
        elif first is not None:
            if TYPE.match(lines[first].strip()):
                yield from functions_of(lines, first + 1, i, indentation + 2)
            elif code in ("}", "};") and "(" in lines[first]:
                yield first, i
            first = None


def begins_with_comment(lines, first, last):
    """Whether the first line of the body is a comment."""
    for i in range(first, last):
        if lines[i].endswith("{"):
            return lines[i + 1].strip().startswith("//")
    return False


def problems_of(name, text):
    lines = text.splitlines()
    if len(lines) > MOST_LINES_OF_FILE:
        yield f"{name}: {len(lines)} lines; expected at most {MOST_LINES_OF_FILE}"
    if not name.endswith(("pp", ".h")):
        return
    lines = without_raw_strings(text).splitlines()
    for first, last in functions_of(lines, 0, len(lines), 0):
        length = last - first + 1
        if length > MOST_LINES_OF_FUNCTION and not begins_with_comment(lines, first, last):
            yield (f"{name}:{first + 1}: a function of {length} lines; expected at most {MOST_LINES_OF_FUNCTION}, or a comment as its first line "
                   f"that says why: {lines[first].strip()}")


def main():
    source = pathlib.Path(sys.argv[1])
    files = [file for folder in ("lib", "apps") for file in sorted((source / folder).rglob("*"))
             if file.suffix in (".cpp", ".hpp", ".h", ".js", ".mjs")]
    if not files:
        print(f"no file found in lib/ and apps/ of {source}")
        return 1
    problems = [problem for file in files for problem in problems_of(str(file.relative_to(source)), file.read_text(encoding="utf-8"))]
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
