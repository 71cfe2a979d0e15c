/*
 * Sources of an import that this project parses itself: PNG and raw heightmaps, tiles packed with xz, lists, and a store's lines about
 * insets. Anything ends in a status and one line, and what opens can be read, or its reading fails in the same way.
 *
 * An input: its kind, then the file's bytes.
 */
#include "fuzz.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dem/dem.h"
#include "store/store.h"

#if FURROW_XZ
#include <lzma.h>
#endif

#define POSTS_MOST (1 << 22) /* of a source that is read */

const size_t fuzz_size_max = 64 << 10;
const char *const fuzz_words[] = {"IHDR", "IDAT", "IEND", "PLTE", "tRNS", "\x89PNG\r\n\x1a\n", "\xfd" "7zXZ", "YZ", "#", "@", "..", "source.png", NULL};

enum kind { PNG, RAW, HGT, XZ, LIST, INSETS, KINDS };
static const char *const names[] = {"source.png", "source.r16", "N46E015.hgt", "N46E015.hgt.xz", "source.txt"};

static void check_line(const char *text)
{
	fuzz_check(text[0] != '\0' && strchr(text, '\n') == NULL);
}

static bool done(enum status status)
{
	if (status == STATUS_OK)
		return true;
	fuzz_check(status == STATUS_INPUT || status == STATUS_FAILED);
	check_line(failure_message());
	return false;
}

static void drop(const char *text)
{
	check_line(text);
}

static void read_all(struct dem *dem)
{
	const struct dem_info *info = dem_info(dem);
	fuzz_check(info->width >= 2 && info->height >= 2 && info->spacing > 0);
	if (info->width > POSTS_MOST / info->height)
		return;
	double *heights = malloc((size_t)(info->width * info->height) * sizeof *heights);
	fuzz_check(heights != NULL);
	if (done(dem_read(dem, (struct post_rect){0, 0, info->width, info->height}, heights)))
		for (int64_t i = 0; i < info->width * info->height; i++)
			fuzz_check(isnan(heights[i]) || fabs(heights[i]) <= HEIGHT_MAX);
	free(heights);
}

static void open_source(enum kind kind, const uint8_t *data, size_t size)
{
	const char *path = fuzz_path(names[kind]);
	char list[512];
	fuzz_write(path, data, size);
	snprintf(list, sizeof list, "%s%s", kind == LIST ? "@" : "", path);
	const char *source = list;
	struct dem_params params = {.sources = &source, .source_count = 1, .fill = size % 3 == 0};
	struct dem *dem = NULL;
	if (done(dem_open(&params, &dem)))
		read_all(dem);
	dem_close(dem);
}

/* What is read can be written and read again. */
static void read_insets(const uint8_t *data, size_t size)
{
	static const struct extent extent = {1000, 800, 30, 64};
	char *text = malloc(size + 1), line[1024];
	fuzz_check(text != NULL);
	memcpy(text, data, size);
	text[size] = '\0';
	struct store_inset inset, again;
	for (const char *at = text; store_inset_next(&at, &extent, &inset);) {
		fuzz_check(at > text && at <= text + size && inset.level < 0 && inset.width > 0 && inset.height > 0);
		if (store_inset_line(&inset, line, sizeof line) >= (int)sizeof line)
			continue;
		const char *back = line;
		fuzz_check(store_inset_next(&back, &extent, &again) && again.x == inset.x && again.height == inset.height &&
			   again.source_length == inset.source_length);
	}
	free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	if (size < 1)
		return 0;
	note_to(drop);
	dem_quiet_process();
	if (data[0] % KINDS == INSETS)
		read_insets(data + 1, size - 1);
	else
		open_source((enum kind)(data[0] % KINDS), data + 1, size - 1);
	return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed)
{
	uint64_t state = seed;
	if (size < 2 || fuzz_below(&state, 16) == 0)
		return LLVMFuzzerMutate(data, size, room);
	return 1 + LLVMFuzzerMutate(data + 1, size - 1, room - 1); /* mostly its kind stays */
}

/* --- seeds --- */

static double height_of(int64_t x, int64_t y)
{
	return (double)((x * 7 + y * 31) % 500);
}

/* A heightmap, written by this project. */
static size_t heightmap(const char *name, enum dem_raster_type type, uint8_t *data, size_t room)
{
	const char *path = fuzz_path(name);
	const struct dem_raster raster = {.path = path, .width = 24, .height = 24, .type = type, .srs = "", .spacing = 1};
	struct dem_writer *writer;
	double row[24];
	if (dem_writer_create(&raster, &writer) != STATUS_OK)
		return 0;
	enum status status = STATUS_OK;
	for (int64_t y = 0; y < 24 && status == STATUS_OK; y++) {
		for (int64_t x = 0; x < 24; x++)
			row[x] = type == DEM_UINT8 ? fmod(height_of(x, y), 256) : height_of(x, y);
		status = dem_writer_rows(writer, 1, row);
	}
	if (status == STATUS_OK)
		status = dem_writer_publish(writer);
	dem_writer_destroy(writer);
	return status == STATUS_OK ? fuzz_read(path, data, room) : 0;
}

static size_t packed(uint8_t *data, size_t room)
{
#if FURROW_XZ
	const size_t side = 1201, bytes = side * side * 2;
	uint8_t *tile = calloc(bytes, 1);
	size_t size = 0;
	for (size_t i = 0; tile != NULL && i < 1000; i++)
		tile[i * 997] = (uint8_t)i;
	if (tile != NULL && lzma_easy_buffer_encode(1, LZMA_CHECK_CRC32, NULL, tile, bytes, data, &size, room) != LZMA_OK)
		size = 0;
	free(tile);
	return size;
#else
	return 0;
#endif
}

static size_t text(const char *words, uint8_t *data, size_t room)
{
	const size_t size = strlen(words);
	if (size > room)
		return 0;
	memcpy(data, words, size);
	return size;
}

size_t fuzz_seed(size_t index, uint8_t *data, size_t room)
{
	static const enum kind kinds[] = {PNG, PNG, RAW, XZ, LIST, INSETS};
	size_t size = 0;
	if (index >= sizeof kinds / sizeof *kinds || room < 1)
		return 0;
	data[0] = (uint8_t)kinds[index];
	switch (index) {
	case 0:
	case 1:
		size = heightmap("seed.png", index == 0 ? DEM_UINT16 : DEM_UINT8, data + 1, room - 1);
		break;
	case 2:
		size = heightmap("seed.r16", DEM_UINT16, data + 1, room - 1);
		break;
	case 3:
		size = packed(data + 1, room - 1);
		break;
	case 4:
		size = text("# two\n\xef\xbb\xbfseed.png\n  seed.r16  \n", data + 1, room - 1);
		break;
	default:
		size = text("-1 0 0 3 3 a.tif\n-5 31968 12 1 25557 a folder/b c.tif\n", data + 1, room - 1);
	}
	return 1 + size;
}
