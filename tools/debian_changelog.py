"""Writes debian/changelog into the folder that `meson dist` packs, or prints it.

    debian_changelog.py VERSION DATE

Meson's version and date are the only ones: a package of another version needs no other change. CHANGELOG.md has what changed.
"""
import datetime
import os
import pathlib
import re
import sys

ENTRY = """furrow ({version}) unstable; urgency=medium

  * Version {version}. CHANGELOG.md has what changed.

 -- {maintainer}  {date:%a, %d %b %Y} 12:00:00 +0000
"""


def main():
    version, date = sys.argv[1:]
    root = os.environ.get("MESON_DIST_ROOT")
    control = pathlib.Path(__file__).resolve().parents[1] / "debian" / "control"
    maintainer = re.search(r"^Maintainer: (.*)$", control.read_text(encoding="utf-8"), re.M).group(1)
    text = ENTRY.format(version=version, maintainer=maintainer, date=datetime.datetime.strptime(date, "%B %d, %Y"))
    if root is None:
        print(text, end="")
    else:
        (pathlib.Path(root) / "debian" / "changelog").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
