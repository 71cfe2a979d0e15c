"""Writes every GLSL file below a folder into a C table of {path, text}: embed.py FOLDER OUT.c [TABLE]"""
import pathlib
import sys

folder, out = pathlib.Path(sys.argv[1]), sys.argv[2]
table = sys.argv[3] if len(sys.argv) > 3 else "gpu_shader_table"
with open(out, "w", encoding="ascii") as c:
    c.write('#include "gpu/shader_table.h"\n\n')
    c.write('#pragma GCC diagnostic ignored "-Woverlength-strings"\n\n')
    c.write("extern const struct shader_text %s[];\n" % table)
    c.write("const struct shader_text %s[] = {\n" % table)
    for path in sorted(p for p in folder.rglob("*") if p.suffix in (".glsl", ".vert", ".frag", ".comp")):
        c.write('\t{"%s",\n' % path.relative_to(folder).as_posix())
        for line in path.read_text(encoding="ascii").splitlines():
            c.write('\t "%s\\n"\n' % line.replace("\\", "\\\\").replace('"', '\\"'))
        c.write("\t},\n")
    c.write("\t{0, 0},\n};\n")
