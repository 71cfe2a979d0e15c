/* Bytes as gzip has them (RFC 1952), without a name or a time: the same bytes make the same file. */
#include "exchange/internal.h"

#include <zlib.h>

#define LEVEL 6
#define GZIP_WINDOW (15 + 16) /* zlib's number for a gzip header */

enum status exchange_gzip(const struct exchange_bytes *in, struct exchange_bytes *out)
{
	z_stream stream = {.next_in = in->data, .avail_in = (uInt)in->size};
	out->size = 0;
	if (deflateInit2(&stream, LEVEL, Z_DEFLATED, GZIP_WINDOW, 8, Z_DEFAULT_STRATEGY) != Z_OK)
		return fail_memory("a tile");
	const size_t most = deflateBound(&stream, (uLong)in->size);
	enum status status;
	TRY_OR(done, mem_grow(&out->data, &out->room, most, 1, "a tile"));
	stream.next_out = out->data;
	stream.avail_out = (uInt)most;
	const int ended = deflate(&stream, Z_FINISH);
	assert(ended == Z_STREAM_END); /* there is room for all of it */
	(void)ended;
	out->size = most - stream.avail_out;
done:
	(void)deflateEnd(&stream);
	return status;
}
