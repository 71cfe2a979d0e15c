/* Writes arrays of numbers in NumPy's format, version 1.0 (numpy.lib.format): as PATH.part, renamed when complete. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "base/aside.h"
#include "render/internal.h"

#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define ORDER '<'
#else
#define ORDER '>'
#endif

/* Makes the header: a magic, its length, and a Python dictionary that is padded so that the numbers begin at a multiple of 64. */
static size_t make_header(const struct render_array *array, char header[128])
{
	char depth[16] = "";
	if (array->channels > 1)
		snprintf(depth, sizeof depth, ", %u", array->channels);
	memset(header, ' ', 128);
	const int length = snprintf(header + 10, 118, "{'descr': '%c%c%u', 'fortran_order': False, 'shape': (%u, %u%s), }", ORDER, array->kind,
				    array->bytes, array->height, array->width, depth);
	header[10 + length] = ' ';
	header[127] = '\n';
	memcpy(header, "\x93NUMPY\x01\x00\x76\x00", 10); /* 118 bytes follow */
	return 128;
}

static enum status write_array(const char *path, const struct render_array *array, FILE *file)
{
	char header[128];
	const size_t row = (size_t)array->width * array->channels * array->bytes, head = make_header(array, header);
	errno = 0;
	bool whole = fwrite(header, 1, head, file) == head;
	/* the rows come from the lowest up, and go from the highest down */
	for (uint32_t y = array->height; whole && y-- > 0;)
		whole = fwrite((const char *)array->values + y * row, 1, row, file) == row;
	if (!whole)
		return fail_with(STATUS_FAILED, "%s: cannot write the numbers: %s; check space and permissions of its folder", path, strerror(errno));
	return STATUS_OK;
}

enum status render_npy_write(const char *path, const struct render_array *array)
{
	struct aside aside;
	enum status status;
	TRY_OR(done, aside_begin(&aside, path));
	TRY_OR(done, write_array(path, array, aside.file));
done:
	return aside_end(&aside, false, status);
}
