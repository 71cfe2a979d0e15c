"""Writes the tables of src/scene/SCENE.md, which come from the table of a scene's keys (src/scene/scene_schema*.c).

    python3 docs/scene_tables.py build/tools/furrow            # after a change of a row

`furrow scene --tables` prints the tables, each below the heading of its section; the first table of keys of that section becomes it.
"""
import pathlib
import subprocess
import sys

PAGE = pathlib.Path(__file__).parents[1] / "src" / "scene" / "SCENE.md"
HEAD = "| key | type | unit | range | default | what it does | effect |"


def tables_of(text):
    """Heading: lines of the table of keys below it."""
    tables, heading, table = {}, None, None
    for line in text.splitlines():
        if line.startswith("## "):
            heading = line
        if line == HEAD:
            table = tables[heading] = []
        elif not line.startswith("|"):
            table = None
        if table is not None:
            table.append(line)
    return tables


def written(page, tables):
    """The page with these tables in place of its own."""
    lines, heading, inside = [], None, False
    for line in page.splitlines():
        if line.startswith("## "):
            heading = line
        if line == HEAD:
            inside = True
            lines += tables[heading]
        elif not line.startswith("|"):
            inside = False
        if not inside:
            lines.append(line)
    return "\n".join(lines) + "\n"


def main():
    told = subprocess.run([sys.argv[1], "scene", "--tables"], capture_output=True, text=True, check=True).stdout
    PAGE.write_text(written(PAGE.read_text(), tables_of(told)))


if __name__ == "__main__":
    main()
