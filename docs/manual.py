"""Writes a manual page in mdoc(7) from a page of Markdown, or from furrow.h.

    manual.py page NAME(SECTION) SUMMARY DATE VERSION PAGE.md          > NAME.SECTION
    manual.py header DATE VERSION furrow.h furrow.3.in                 > furrow.3

Of Markdown it knows what our pages use: headings, paragraphs, lists, tables, code, emphasis and links. A table becomes a list, a tag for each
row, so that it reads well in 80 columns. Of the header it takes every comment and declaration; furrow.3.in has what is not in the header.
"""
import re
import sys
import textwrap

SOURCE_WIDTH = 76
ITEM = re.compile(r"^(- |\d+\. )")


# --- text ---

def escape(text, typed=False):
    """Letters as mdoc takes them. `typed`: dashes and quotes are to be those of the keyboard."""
    text = text.replace("\\", "\\e").replace("`", "\\(ga").replace("^", "\\(ha").replace("~", "\\(ti").replace('"', "\\(dq")
    if typed:
        return text.replace("-", "\\-").replace("'", "\\(aq")
    text = re.sub(r"(?<!\S)[^\s\\]*\w[_./]\w\S*", lambda name: "\\%" + name.group(), text)  # names are not hyphenated
    return re.sub(r"(?<![\w)])--?(?=\w)", lambda dashes: "\\-" * len(dashes.group()), text)


def inline(text, headings):
    """Markdown within a line: code and strong text are bold, a link is its text and where it leads."""
    kept = []

    def keep(mdoc):
        kept.append(mdoc)
        return f"\0{len(kept) - 1}\0"

    def link(found):
        label, target = found.groups()
        page, _, anchor = target.partition("#")
        page = page.split("/")[-1]
        place = "" if label.strip("`").split("/")[-1] == page else page or f'section "{headings.get(anchor, anchor)}"'
        return label + (f" [{place}]" if place else "")

    text = re.sub(r"\[([^\]]+)\]\(([^)]+)\)", link, text)
    text = re.sub(r"`([^`]+)`", lambda code: keep("\\fB\\%" + escape(code.group(1), True) + "\\fP"), text)
    text = re.sub(r"\b(furrow_\w+)\(\)", lambda name: keep(f"\\fB{name.group(1)}\\fP()"), text)
    text = re.sub(r"\*\*([^*]+)\*\*", lambda strong: keep("\\fB" + escape(strong.group(1)) + "\\fP"), text)
    text = re.sub(r"(?<![\w*])\*([A-Za-z][^*]*)\*(?!\w)", lambda weak: keep("\\fI" + escape(weak.group(1)) + "\\fP"), text)
    text = escape(text)
    while "\0" in text:
        text = re.sub("\0(\\d+)\0", lambda mark: kept[int(mark.group(1))], text)
    return text


def lines_of(text):
    """Running text as short lines of source; each sentence begins one."""
    out = []
    for sentence in re.split(r"(?<=[^.\s][.?!])\s+(?=[A-Z\\])", " ".join(text.split())):
        line = ""
        for word in sentence.split():
            if line and len(line) + 1 + len(word) > SOURCE_WIDTH:
                out.append(line)
                line = ""
            line = f"{line} {word}" if line else word
        out.append(line)
    return ["\\&" + line if line.startswith((".", "'")) else line for line in out if line]


def literal(lines):
    # A line that is too long for a terminal goes on below, further to the right.
    rows = []
    for line in lines:
        while len(line) > 74:
            cut = line.rfind(" ", 30, 74)
            if cut < 0:
                break
            rows.append(line[:cut])
            line = " " * (len(line) - len(line.lstrip()) + 4) + line[cut + 1:]
        rows.append(line)
    return [".Bd -literal", *("\\&" * row.startswith((".", "'")) + escape(row, True).replace("\t", "    ") for row in rows), ".Ed"]


def head(name, section, summary, date, version):
    return [".\\\" Made by docs/manual.py.", f".Dd {date}", f".Dt {name.upper()} {section}", f".Os Furrow {version}", ".Sh NAME", f".Nm {name}",
            f".Nd {summary}"]


# --- Markdown ---

def blocks_of(text):
    """(kind, lines) of each block."""
    rows, at = text.split("\n"), 0
    while at < len(rows):
        row, begin = rows[at], at
        at += 1
        if not row.strip():
            continue
        if row.startswith("```"):
            while not rows[at].startswith("```"):
                at += 1
            at += 1
            yield "code", rows[begin + 1:at - 1]
        elif row.startswith("    "):
            while at < len(rows) and (rows[at].startswith("    ") or (not rows[at].strip() and at + 1 < len(rows) and rows[at + 1].startswith("    "))):
                at += 1
            yield "code", [line[4:] for line in rows[begin:at]]
        elif row.startswith("#"):
            yield "heading", [row]
        elif row.startswith("|"):
            while at < len(rows) and rows[at].startswith("|"):
                at += 1
            yield "table", rows[begin:at]
        elif ITEM.match(row):
            while at < len(rows) and (ITEM.match(rows[at]) or rows[at].startswith("  ")):
                at += 1
            yield "list", rows[begin:at]
        else:
            while at < len(rows) and rows[at].strip() and not rows[at].startswith(("```", "#", "|")) and not ITEM.match(rows[at]):
                at += 1
            yield "text", rows[begin:at]


def cells(row):
    return [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", row.strip())[1:-1]]


def put_table(rows, headings):
    names = cells(rows[0])
    out = [".Bl -tag -width indent"]
    for row in rows[2:]:
        first, *rest = cells(row)
        facts, notes, words = [], [], []
        for name, cell in zip(names[1:], rest):
            if not cell:
                continue
            if name in ("type", "unit", "range", "posts"):
                facts.append(cell)
            elif name in ("default", "effect"):
                notes.append(cell if cell.startswith("needed") else f"{name}: {cell}")
            elif name in ("", "what it does", "what it is"):
                words.append(cell)
            else:
                words.append(f"{name}: {cell}")
        if not first:  # a table of two columns, of which this row has the second
            first, words = words[0], words[1:]
        out.append(f".It {inline(first, headings)}")
        out += lines_of(inline("; ".join(words), headings))
        if facts or notes:
            out += ([".br"] if words else []) + lines_of("(" + inline("; ".join([", ".join(facts)] * bool(facts) + notes), headings) + ")")
    return out + [".El"]


def put_list(rows, headings):
    """A list whose items may end in a list of their own, which is set in by two or three spaces."""
    out = [".Bl -bullet" if rows[0].startswith("-") else ".Bl -enum"]
    marks = [i for i, row in enumerate(rows) if ITEM.match(row)] + [len(rows)]
    for begin, end in zip(marks, marks[1:]):
        item = [ITEM.sub("", rows[begin]), *(re.sub("^ {2,3}", "", row) for row in rows[begin + 1:end])]
        inner = next((i for i, row in enumerate(item) if i > 0 and ITEM.match(row)), len(item))
        out += [".It", *lines_of(inline(" ".join(row.strip() for row in item[:inner]), headings))]
        if inner < len(item):
            out += put_list(item[inner:], headings)
    return out + [".El"]


def anchor_of(heading):
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def page(name, summary, date, version, path):
    name, section = re.fullmatch(r"(\w+)\((\d)\)", name).groups()
    with open(path, encoding="utf-8") as file:
        text = re.sub(r"^<!--.*?-->\n|<!--.*?-->", "", file.read(), flags=re.MULTILINE)  # marks of figures
    headings = {anchor_of(title): title for title in re.findall(r"^#+ (.*)$", text, re.M)}
    out, begins = head(name, section, summary, date, version) + [".Sh DESCRIPTION"], True
    for kind, rows in blocks_of(text):
        if kind == "heading":
            level, title = re.match(r"(#+) (.*)", rows[0]).groups()
            if len(level) > 1:
                out.append((".Sh " if len(level) == 2 else ".Ss ") + escape(title.upper() if len(level) == 2 else title))
                begins = True
            continue
        if not begins and kind == "text":
            out.append(".Pp")
        if kind == "code":
            out += literal(rows)
        elif kind == "table":
            out += put_table(rows, headings)
        elif kind == "list":
            out += put_list(rows, headings)
        else:
            out += lines_of(inline(" ".join(rows), headings))
        begins = False
    return out + [".Sh SEE ALSO", ".Xr furrow 1 ,", *([".Xr store 5"] if name == "scene" else [".Xr scene 5"])]


# --- the header ---

def comment_text(comment):
    rows = [re.sub(r"^\s*\*? ?", "", row) for row in comment.removeprefix("/*").removesuffix("*/").split("\n")]
    return "\n".join(rows).strip("\n")


def put_comment(comment, headings=False):
    """Paragraphs; `headings`: one that begins as "Threads. " gets that heading."""
    out = []
    for block in re.split(r"\n\s*\n", comment):
        if block.startswith("    "):
            out += literal([line[4:] for line in block.split("\n")])
            continue
        found = re.match(r"([A-Z][a-z]+(?: [a-z]+)*)\. ", block) if headings else None
        if found:
            out.append(f".Ss {found.group(1)}")
            block = block[found.end():]
        elif out:
            out.append(".Pp")
        # What is said of an argument, or of an error, begins a line.
        for part in re.split(r"(?<=[.:])\n(?=`|FURROW_)", block):
            out += [".br"] * (part != block and not block.startswith(part)) + lines_of(inline(part, {}))
    return out


def c_lines(declaration):
    """A declaration in lines of 74: a comment goes on below itself, parameters further to the right."""
    if "{" not in declaration:
        code, _, comment = declaration.partition(" /*")
        return textwrap.wrap(" ".join(code.split()) + (" /*" + comment if comment else ""), 74, subsequent_indent=" " * 8)
    out = []
    declaration = re.sub(r"/\*.*?\*/", lambda comment: " ".join(comment.group().split()), declaration, flags=re.S)
    for line in declaration.split("\n"):
        line = line.replace("\t", "    ")
        at = line.find("/*")
        if len(line) <= 74 or at < 0:
            out.append(line)
            continue
        rows = textwrap.wrap(line[at:], max(74 - at, 30), subsequent_indent="   ")
        out += [line[:at] + rows[0]] + [" " * at + row for row in rows[1:]]
    return out


def declarations(text):
    """(section, comment, declaration) of each, in their order; the comment may be empty."""
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*$", "", text[text.index("#ifdef __cplusplus"):], flags=re.M)
    text = text.replace('extern "C" {', "")
    section, comment = "", ""
    while (text := text.lstrip()) and not text.startswith("}"):
        if text.startswith("/*"):
            end = text.index("*/") + 2
            comment = comment_text(text[:end])
            if found := re.fullmatch(r"--- (.*) ---", comment.strip()):
                section, comment = found.group(1), ""
            text = text[end:]
            continue
        end, depth = 0, 0
        while depth > 0 or text[end] != ";":
            if text.startswith("/*", end):
                end = text.index("*/", end) + 2
                continue
            depth += (text[end] == "{") - (text[end] == "}")
            end += 1
        end += 1
        behind = re.match(r"[ \t]*(/\*.*?\*/)", text[end:])
        declaration = text[:end] + (" " + behind.group(1) if behind else "")
        yield section, comment.strip(), re.sub(r"^FURROW_API ", "", declaration)
        comment = ""
        text = text[end + (behind.end() if behind else 0):]


def header(date, version, path, frame):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    with open(frame, encoding="utf-8") as file:
        around = file.read()
    about = comment_text(re.match(r"/\*.*?\*/", text, re.S).group())
    summary, _, about = about.partition("\n")
    out, last = [], ""
    for section, comment, declaration in declarations(text):
        if section != last:
            title = section.split(":")[0].split(",")[0]
            out.append(f".Ss {title[0].upper()}{title[1:]}")
            last = section
        out += literal(c_lines(declaration))
        out += [".Bd -ragged -offset indent -compact", *put_comment(comment), ".Ed"] if comment else []
    about = put_comment(about.strip("\n"), headings=True)
    name = ["\n".join(head("furrow", 3, summary.split(": ", 1)[1].rstrip("."), date, version))]
    for mark, lines in (("HEAD", name), ("ABOUT", about), ("REFERENCE", out)):
        if around.count(f".\\\" {mark}\n") != 1:
            raise SystemExit(f"{frame}: has no line .\\\" {mark}")
        around = around.replace(f".\\\" {mark}\n", "\n".join(lines) + "\n")
    return [around.rstrip("\n")]


def main():
    kind, *arguments = sys.argv[1:]
    print("\n".join(page(*arguments) if kind == "page" else header(*arguments)))


if __name__ == "__main__":
    main()
