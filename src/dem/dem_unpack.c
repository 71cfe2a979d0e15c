/*
 * Unpacks xz into a temporary file without a name. GDAL needs a name, since drivers look at it: where an .hgt tile lies is known
 * from its name alone. So a small file in GDAL's memory refers to the temporary file, and has the name.
 */
#include "dem_unpack.h"

#include "dem_gdal.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>

#if FURROW_XZ
#include <lzma.h>
#endif

#define MEMORY_MOST (256u << 20) /* bytes that the decoder may take: enough for `xz -9` */

bool dem_unpack_is_packed(const char *path)
{
	return strncmp(path, "/vsi", 4) != 0 && dem_path_ends(path, ".xz");
}

#if FURROW_XZ
static const char *problem_of(lzma_ret result)
{
	switch (result) {
	case LZMA_FORMAT_ERROR:
		return "it is not in the xz format";
	case LZMA_DATA_ERROR:
		return "its data is corrupt";
	case LZMA_BUF_ERROR:
		return "it ends early";
	case LZMA_MEMLIMIT_ERROR:
		return "unpacking it takes more than 256 MB of memory";
	default:
		return "it has options that are not known";
	}
}

/* Unpacks all of `file`. `in` and `out`: room of `room` bytes each. */
static enum status unpack(lzma_stream *stream, FILE *file, const char *path, const struct dem_scratch *scratch, uint8_t *in, uint8_t *out,
			  size_t room, int64_t *bytes)
{
	const int64_t most = dem_path_ends(path, ".hgt.xz") ? DEM_UNPACK_MOST_HGT : DEM_UNPACK_MOST;
	lzma_ret result = LZMA_OK;
	*bytes = 0;
	while (result == LZMA_OK) {
		if (stream->avail_in == 0) {
			stream->next_in = in;
			stream->avail_in = fread(in, 1, room, file);
			if (ferror(file))
				return fail_with(STATUS_INPUT, "%s: reading it failed: %s; check the disk", path, strerror(errno));
		}
		stream->next_out = out;
		stream->avail_out = room;
		result = lzma_code(stream, feof(file) ? LZMA_FINISH : LZMA_RUN);
		const size_t made = room - stream->avail_out;
		if (made > 0 && *bytes + (int64_t)made > most)
			return fail_with(STATUS_INPUT, "%s: unpacks to more than %lld MB; unpack it with xz -dk and name what comes out", path,
					 (long long)(most >> 20));
		if (made > 0)
			TRY(dem_scratch_move(scratch, true, out, made, *bytes));
		*bytes += (int64_t)made;
	}
	if (result == LZMA_STREAM_END)
		return STATUS_OK;
	if (result == LZMA_MEM_ERROR)
		return fail_memory(path);
	return fail_with(STATUS_INPUT, "%s: cannot be unpacked: %s; fetch it again", path, problem_of(result));
}

static enum status unpack_file(struct dem_unpacked *unpacked, const char *path, int64_t *bytes)
{
	const size_t room = 1 << 16;
	lzma_stream stream = LZMA_STREAM_INIT;
	uint8_t *in = mem_alloc(room, 1), *out = mem_alloc(room, 1);
	FILE *file = in != NULL && out != NULL ? input_open(path) : NULL;
	enum status status = STATUS_OK;
	if (in == NULL || out == NULL)
		TRY_OR(done, fail_memory(path));
	if (file == NULL)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: cannot be read: %s; check its permissions", path, input_problem()));
	if (lzma_stream_decoder(&stream, MEMORY_MOST, LZMA_CONCATENATED) != LZMA_OK)
		TRY_OR(done, fail_memory(path));
	TRY_OR(done, dem_scratch_open(&unpacked->scratch, path));
	TRY_OR(done, unpack(&stream, file, path, &unpacked->scratch, in, out, room, bytes));
done:
	lzma_end(&stream);
	if (file != NULL)
		fclose(file);
	mem_free_all(in, out);
	return status;
}

/* Makes the file in GDAL's memory which refers to the temporary file. */
static enum status name_it(struct dem_unpacked *unpacked, const char *path, int64_t bytes)
{
	static const char prefix[] = "/vsisparse/";
	static atomic_uint_least64_t made;
	const char *slash = strrchr(path, '/'), *last = slash != NULL ? slash + 1 : path;
	const size_t room = strlen(last) + 80;
	unpacked->name = mem_alloc(room, 1);
	TRY_MEM(unpacked->name, path);
	snprintf(unpacked->name, room, "%s/vsimem/furrow/xz%llu/%.*s", prefix, (unsigned long long)atomic_fetch_add(&made, 1),
		 (int)(strlen(last) - strlen(".xz")), last);
	char xml[400];
	const int length = snprintf(xml, sizeof xml,
				    "<VSISparseFile><Length>%lld</Length><SubfileRegion><Filename>/proc/self/fd/%d</Filename>"
				    "<DestinationOffset>0</DestinationOffset><SourceOffset>0</SourceOffset><RegionLength>%lld</RegionLength>"
				    "</SubfileRegion></VSISparseFile>", (long long)bytes, unpacked->scratch.file, (long long)bytes);
	VSILFILE *file = VSIFOpenL(unpacked->name + sizeof prefix - 1, "wb");
	bool written = file != NULL && VSIFWriteL(xml, 1, (size_t)length, file) == (size_t)length;
	if (file != NULL && VSIFCloseL(file) != 0)
		written = false;
	return written ? STATUS_OK : fail_memory(path);
}

enum status dem_unpack_init(struct dem_unpacked *unpacked, const char *path)
{
	*unpacked = (struct dem_unpacked){.scratch = {.file = -1}};
	int64_t bytes = 0;
	TRY(unpack_file(unpacked, path, &bytes));
	return name_it(unpacked, path, bytes);
}
#else
enum status dem_unpack_init(struct dem_unpacked *unpacked, const char *path)
{
	*unpacked = (struct dem_unpacked){.scratch = {.file = -1}};
	return fail_with(STATUS_INPUT, "%s: is packed with xz, and this furrow was built without liblzma; unpack it with xz -dk, or build with it",
			 path);
}
#endif

void dem_unpack_finish(struct dem_unpacked *unpacked)
{
	if (unpacked->name != NULL)
		(void)VSIUnlink(unpacked->name + strlen("/vsisparse/"));
	mem_free(unpacked->name);
	dem_scratch_close(&unpacked->scratch);
	*unpacked = (struct dem_unpacked){.scratch = {.file = -1}};
}
