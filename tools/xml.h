/* Text in XML. */
#ifndef FURROW_TOOLS_XML_H
#define FURROW_TOOLS_XML_H

#include <stdio.h>

/* Writes text as XML and HTML have it, also between quotes. Control characters become question marks, bytes that are no UTF-8 too. */
void xml_text(const char *text, FILE *file);

#endif
