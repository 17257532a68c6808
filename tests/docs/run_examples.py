#!/usr/bin/env python3
"""Runs all examples of a Markdown page in their order, in one folder.

    run_examples.py PAGE BINARY TEST_DATA

If the page is a README.md, the examples of the pages that its section "Pages" lists follow.

An example is a line of a ```sh block. It must exit with 0, or with N if the line ends in "# exits with N". `tactile` is on the path, and the
folder has `recordings/` with a few small recordings.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile


def examples(page):
    """(line number, command, expected exit status) of each example."""
    inside = False
    for number, line in enumerate(open(page, encoding="utf-8"), 1):
        line = line.rstrip("\n")
        if line.startswith("```"):
            inside = line == "```sh"
        elif inside and line.strip() and not line.startswith("#"):
            expected = re.search(r"# exits with (\d+)$", line)
            yield number, line, int(expected.group(1)) if expected else 0


def pages_from(page):
    """The page itself, then those of its folder that it lists."""
    yield page
    if os.path.basename(page) != "README.md":
        return
    _, _, listed = open(page, encoding="utf-8").read().partition("\n## Pages\n")
    for name in re.findall(r"^- \[[^\]]*\]\(([\w-]+\.md)\)", listed, flags=re.M):
        yield os.path.join(os.path.dirname(page), name)


def main():
    first, binary, test_data = sys.argv[1:]
    folder = tempfile.mkdtemp(prefix="tactile-docs-")
    try:
        shutil.copytree(os.path.join(test_data, "aedat4"), os.path.join(folder, "recordings"))
        shutil.copy(os.path.join(test_data, "bags", "run.bag"), os.path.join(folder, "recordings"))
        environment = dict(os.environ, PATH=os.path.dirname(binary) + os.pathsep + os.environ["PATH"])
        count = 0
        for page, (number, line, expected) in ((page, example) for page in pages_from(first) for example in examples(page)):
            result = subprocess.run(["bash", "-c", line], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                                    capture_output=True, text=True)
            if result.returncode != expected:
                print(f"{page}:{number}: '{line}' exits with {result.returncode}, expected {expected}\n{result.stdout}{result.stderr}")
                return 1
            print(f"ok  {line}")
            count += 1
        if count == 0:
            print(f"{first}: no example found; expected ```sh blocks")
            return 1
        print(f"{count} examples ran")
        return 0
    finally:
        shutil.rmtree(folder, ignore_errors=True)


sys.exit(main())
