"""doc/interfaces.md as data: the names in its tables. A name may end in `*`, for all names that begin like it."""

import fnmatch
import pathlib
import re

PAGE = pathlib.Path(__file__).resolve().parents[2] / "doc/interfaces.md"


def section(title):
    """Text below the heading `title`, to the next one."""
    text = PAGE.read_text(encoding="utf-8")
    begin = text.index(f"\n## {title}\n")
    end = text.find("\n## ", begin + 1)
    return text[begin:end if end > 0 else len(text)]


def names(title, column=0):
    """Code spans in a column of a section's table."""
    rows = [line.split("|")[1:-1] for line in section(title).split("\n") if line.startswith("|")]
    return {name for row in rows for name in re.findall(r"`([^`]+)`", row[column])}


def rows(title):
    """A section's table: a list of rows, each a list of cells, without the head and the line below it."""
    lines = [line for line in section(title).split("\n") if line.startswith("|")]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines[2:]]


def has(known, name):
    """Whether one of the names is, or stands for, `name`."""
    return any(fnmatch.fnmatchcase(name.lstrip("/"), each.lstrip("/")) for each in known)


def unknown(known, found):
    return sorted(name for name in found if not has(known, name))


def gone(known, found):
    """Names on the page that match none of the found names."""
    return sorted(each for each in known if not any(has({each}, name) for name in found))
