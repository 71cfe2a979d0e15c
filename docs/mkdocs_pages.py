"""Makes the site of mkdocs.yml from the pages of the whole project, which lie beside the code that they explain.

mkdocs calls the functions named on_*. Pages keep their paths, so links between them hold as they are. A file that a page links is copied into the site.
A folder that a page links gets a page with the list of its files.
"""
import atexit
import os
import pathlib
import re
import shutil
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ("docs", "src", "bench", "examples")
STYLES = ["docs/site.css"]  # extra_css of mkdocs.yml
ITEM = re.compile(r" *([-*]|\d+\.) ")


def pages():
    """Every page of the project, relative to its root."""
    found = sorted(ROOT.glob("*.md"))
    for folder in FOLDERS:
        found += sorted((ROOT / folder).rglob("*.md"))
    return [path.relative_to(ROOT).as_posix() for path in found]


def plain_parts(text):
    """The text as (is code, part): blocks between ``` are code."""
    return [(i % 2 == 1, part) for i, part in enumerate(re.split(r"(^```.*?^```$)", text, flags=re.MULTILINE | re.DOTALL))]


def links(text):
    """The relative links of a page, without what is behind #."""
    prose = "".join(part for code, part in plain_parts(text) if not code)
    found = (link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", prose))
    return {link for link in found if link and not re.match(r"\w+:", link)}


def target(page, link):
    """What a link of a page names, relative to the root."""
    return pathlib.PurePosixPath(os.path.normpath(pathlib.PurePosixPath(page).parent / link)).as_posix()


def linked():
    """What pages link beside pages: (files, folders)."""
    found = {target(page, link) for page in pages() for link in links((ROOT / page).read_text(encoding="utf-8"))}
    found = {name for name in found if not name.endswith(".md")}
    folders = {name for name in found if (ROOT / name).is_dir()}
    within = {path.relative_to(ROOT).as_posix() for name in folders for path in (ROOT / name).iterdir() if shown(path)}
    return sorted(found - folders | within), sorted(folders)


def shown(path):
    """Whether a list of files has it: no hidden file, no page, nothing that a program made."""
    return path.is_file() and not path.name.startswith(".") and path.suffix not in (".md", ".furrow", ".pyc")


def listing(name):
    """The page of a folder."""
    rows = ["- [%s](%s)" % (path.name, path.name) for path in sorted((ROOT / name).iterdir()) if shown(path)]
    return "# %s\n\n" % name + "\n".join(rows) + "\n"


def for_mkdocs(text, page):
    """A page for mkdocs, which needs an empty line before a list, four spaces before a list within a list, and files as targets of links."""
    out = []
    for code, part in plain_parts(text):
        if not code:
            lines = []
            for line in part.split("\n"):
                if ITEM.match(line) and lines and lines[-1].strip() and not lines[-1].startswith(" ") and not ITEM.match(lines[-1]):
                    lines.append("")
                lines.append(re.sub(r"^ {2,3}(?=([-*]|\d+\.) )", "    ", line))
            part = "\n".join(lines)
            for link in links(part):
                if (ROOT / target(page, link)).is_dir():
                    part = part.replace("](%s)" % link, "](%s/index.md)" % link.rstrip("/"))
        out.append(part)
    return "".join(out)


def on_files(files, config, **_):
    from mkdocs.structure.files import File, Files  # only mkdocs has it
    made = pathlib.Path(tempfile.mkdtemp(prefix="furrow-site-"))
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    names, folders = linked()
    for name in folders:
        (made / name).mkdir(parents=True, exist_ok=True)
        (made / name / "index.md").write_text(listing(name), encoding="utf-8")

    def file(name, root):
        return File(name, str(root), config["site_dir"], config["use_directory_urls"])

    theme = [one for one in files if not pathlib.Path(one.abs_src_path).is_relative_to(config["docs_dir"])]
    return Files(theme + [file(name, ROOT) for name in pages() + names + STYLES] + [file(name + "/index.md", made) for name in folders])


def on_page_markdown(markdown, page, **_):
    return for_mkdocs(markdown, page.file.src_path.replace(os.sep, "/"))
