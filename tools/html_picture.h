/* Small copies of pictures, for a page. */
#ifndef FURROW_TOOLS_HTML_PICTURE_H
#define FURROW_TOOLS_HTML_PICTURE_H

#include <stdint.h>

#include "base/base.h"

struct html_picture {
	unsigned char *png;
	size_t length;
	uint32_t width, height;
};

/* Reads a PNG, which is not trusted, and makes a copy of it, at most `most` pixels wide and high. STATUS_INPUT: it is not there, is none, or is
 * too large. */
enum status html_picture_read(const char *path, uint32_t most, struct html_picture *out) FURROW_CHECKED;
void html_picture_finish(struct html_picture *picture);

#endif
