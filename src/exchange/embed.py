"""Writes a text file into C as an array of bytes: embed.py FILE OUT.c NAME"""
import pathlib
import sys

source, out, name = sys.argv[1:]
data = pathlib.Path(source).read_bytes()
with open(out, "w", encoding="ascii") as c:
    c.write('#include "exchange/embedded.h"\n\n')
    c.write("const unsigned long %s_size = %d;\nconst unsigned char %s[] = {\n" % (name, len(data), name))
    for at in range(0, len(data), 16):
        c.write("\t" + ", ".join("%d" % byte for byte in data[at:at + 16]) + ",\n")
    c.write("};\n")
