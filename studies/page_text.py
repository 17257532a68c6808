"""How pages are written that a script makes: no line of prose is longer than 120 characters."""

import re
import textwrap

MOST_CHARACTERS = 120


def wrapped(text):
    """The text with its paragraphs and items of lists in short lines. Tables, headings, pictures, comments and code stay as they are."""
    lines, paragraph, is_code = [], [], False

    def end_paragraph():
        if not paragraph:
            return
        item = re.match(r"(\s*(?:[-*]|\d+\.) )?", paragraph[0]).group(0)
        words = " ".join(line.strip() for line in paragraph)[len(item.strip()):].strip()
        lines.extend(textwrap.wrap(words, MOST_CHARACTERS, initial_indent=item, subsequent_indent=" " * len(item),
                                   break_long_words=False, break_on_hyphens=False))
        paragraph.clear()

    for line in text.split("\n"):
        is_fence = line.lstrip().startswith("```")
        is_code ^= is_fence
        if is_code or is_fence or not line.strip() or line.startswith(("|", "#", "![", "<!--", "    ")):
            end_paragraph()
            lines.append(line)
            continue
        if re.match(r"\s*(?:[-*]|\d+\.) ", line):
            end_paragraph()
        paragraph.append(line)
    end_paragraph()
    return "\n".join(lines)
