/* GDAL on the same posts: blocks of a raster read and updated one at a time, past its block cache. */
#include "store_bench.h"

#include <stdio.h>

#include "bench.h"

#if FURROW_GDAL
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fcntl.h>
#include <gdal.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

#define BLOCK_POSTS (BENCH_BLOCK * BENCH_BLOCK)

struct bench_gdal {
	GDALDatasetH dataset;
	GDALRasterBandH band;
	GDALDataType type;
	int blocks_x, blocks_y;
	char path[512]; /* what was opened */
	bool in_memory;
	GDALDatasetH twin; /* where encoded blocks go */
	void **blocks;     /* what is encoded, by row and column; NULL until asked for */
	double block[BLOCK_POSTS]; /* room for any type */
	float heights[BLOCK_POSTS];
};

static void must(bool good, const char *path)
{
	if (!good)
		bench_must(fail_with(STATUS_FAILED, "%s: %s; see GDAL", path, CPLGetLastErrorMsg()));
}

/* A file's bytes in memory under a name of /vsimem. */
static void load(struct bench_gdal *gdal, const char *path)
{
	vsi_l_offset size = 0;
	GByte *bytes = NULL;
	must(VSIIngestFile(NULL, path, &bytes, &size, -1), path);
	snprintf(gdal->path, sizeof gdal->path, "/vsimem/%p.tif", (void *)gdal);
	VSILFILE *file = VSIFileFromMemBuffer(gdal->path, bytes, size, TRUE);
	must(file != NULL, path);
	VSIFCloseL(file);
}

static struct bench_gdal *make(void)
{
	GDALAllRegister();
	struct bench_gdal *gdal = mem_calloc(1, sizeof *gdal);
	if (gdal == NULL)
		bench_must(fail_memory("GDAL"));
	return gdal;
}

static void take_band(struct bench_gdal *gdal, const char *path)
{
	int wide, high;
	must(gdal->dataset != NULL, path);
	gdal->band = GDALGetRasterBand(gdal->dataset, 1);
	gdal->type = GDALGetRasterDataType(gdal->band);
	GDALGetBlockSize(gdal->band, &wide, &high);
	if (wide != BENCH_BLOCK || high != BENCH_BLOCK)
		bench_must(fail_with(STATUS_INPUT, "%s: blocks of %d x %d; make it with BLOCKSIZE=%d", path, wide,
				     high, BENCH_BLOCK));
	gdal->blocks_x = (GDALGetRasterBandXSize(gdal->band) + wide - 1) / wide;
	gdal->blocks_y = (GDALGetRasterBandYSize(gdal->band) + high - 1) / high;
}

bool bench_gdal_open(const char *path, bool in_memory, struct bench_gdal **out)
{
	struct bench_gdal *gdal = make();
	gdal->in_memory = in_memory;
	if (in_memory)
		load(gdal, path);
	else
		snprintf(gdal->path, sizeof gdal->path, "%s", path);
	gdal->dataset = GDALOpen(gdal->path, GA_ReadOnly);
	take_band(gdal, path);
	*out = gdal;
	return true;
}

static void twin_path(const struct bench_gdal *gdal, char *path, size_t room)
{
	snprintf(path, room, "/vsimem/%p-twin.tif", (const void *)gdal);
}

void bench_gdal_close(struct bench_gdal *gdal)
{
	char path[64];
	GDALClose(gdal->dataset);
	if (gdal->in_memory)
		VSIUnlink(gdal->path);
	if (gdal->twin != NULL) {
		GDALClose(gdal->twin);
		twin_path(gdal, path, sizeof path);
		VSIUnlink(path);
		for (int i = 0; i < gdal->blocks_x * gdal->blocks_y; i++)
			mem_free(gdal->blocks[i]);
		mem_free(gdal->blocks);
	}
	mem_free(gdal);
}

/* GDAL's rows go south. */
static int row_of(const struct bench_gdal *gdal, struct tile tile)
{
	return gdal->blocks_y - 1 - (int)tile.y;
}

static void read_block(struct bench_gdal *gdal, struct tile tile, void *block)
{
	if ((int)tile.x >= gdal->blocks_x || (int)tile.y >= gdal->blocks_y)
		bench_must(fail_with(STATUS_INPUT, "%s: fewer blocks than the store has tiles; cut it from the same "
				     "posts", gdal->path));
	must(GDALReadBlock(gdal->band, (int)tile.x, row_of(gdal, tile), block) == CE_None, gdal->path);
}

void bench_gdal_read_native(struct bench_gdal *gdal, struct tile tile)
{
	read_block(gdal, tile, gdal->block);
}

void bench_gdal_read(struct bench_gdal *gdal, struct tile tile)
{
	if (gdal->type == GDT_Float32) {
		read_block(gdal, tile, gdal->heights);
		return;
	}
	read_block(gdal, tile, gdal->block);
	GDALCopyWords(gdal->block, gdal->type, GDALGetDataTypeSizeBytes(gdal->type), gdal->heights, GDT_Float32,
		      sizeof *gdal->heights, BLOCK_POSTS);
}

const float *bench_gdal_heights(const struct bench_gdal *gdal)
{
	return gdal->heights;
}

/* --- encoding --- */

static char **tiled(const char *compression, GDALDataType type)
{
	char **options = CSLSetNameValue(NULL, "TILED", "YES");
	options = CSLSetNameValue(options, "COMPRESS", compression);
	if (strcmp(compression, "ZSTD") == 0)
		options = CSLSetNameValue(options, "PREDICTOR", type == GDT_Float32 ? "3" : "2");
	return options;
}

static void make_twin(struct bench_gdal *gdal)
{
	char path[64];
	const char *compression = GDALGetMetadataItem(gdal->dataset, "COMPRESSION", "IMAGE_STRUCTURE");
	const char *error = GDALGetMetadataItem(gdal->dataset, "MAX_Z_ERROR", "IMAGE_STRUCTURE");
	must(compression != NULL, gdal->path);
	char **options = tiled(compression, gdal->type);
	if (error != NULL)
		options = CSLSetNameValue(options, "MAX_Z_ERROR", error);
	twin_path(gdal, path, sizeof path);
	gdal->twin = GDALCreate(GDALGetDriverByName("GTiff"), path, gdal->blocks_x * BENCH_BLOCK,
				gdal->blocks_y * BENCH_BLOCK, 1, gdal->type, options);
	CSLDestroy(options);
	must(gdal->twin != NULL, path);
	gdal->blocks = mem_calloc((size_t)gdal->blocks_x * (size_t)gdal->blocks_y, sizeof *gdal->blocks);
	if (gdal->blocks == NULL)
		bench_must(fail_memory("blocks"));
}

void bench_gdal_encode(struct bench_gdal *gdal, struct tile tile)
{
	if (gdal->twin == NULL)
		make_twin(gdal);
	int row = row_of(gdal, tile);
	void **block = &gdal->blocks[row * gdal->blocks_x + (int)tile.x];
	if (*block == NULL) {
		*block = mem_alloc(BLOCK_POSTS, (size_t)GDALGetDataTypeSizeBytes(gdal->type));
		if (*block == NULL)
			bench_must(fail_memory("blocks"));
		read_block(gdal, tile, *block);
	}
	must(GDALWriteBlock(GDALGetRasterBand(gdal->twin, 1), (int)tile.x, row, *block) == CE_None, gdal->path);
}

/* --- updates --- */

bool bench_gdal_create(const char *path, uint32_t blocks, const char *compression, struct bench_gdal **out)
{
	struct bench_gdal *gdal = make();
	int side = (int)blocks * BENCH_BLOCK;
	char **options = tiled(compression, GDT_Int32);
	GDALDatasetH made = GDALCreate(GDALGetDriverByName("GTiff"), path, side, side, 1, GDT_Int32, options);
	CSLDestroy(options);
	must(made != NULL, path);
	GDALClose(made);
	snprintf(gdal->path, sizeof gdal->path, "%s", path);
	gdal->dataset = GDALOpen(path, GA_Update);
	take_band(gdal, path);
	*out = gdal;
	return true;
}

/* Without the shared edges, north up. */
static void block_of(const int32_t *posts, int32_t *block)
{
	for (size_t y = 0; y < BENCH_BLOCK; y++)
		memcpy(block + (BENCH_BLOCK - 1 - y) * BENCH_BLOCK, posts + y * (BENCH_BLOCK + 1),
		       BENCH_BLOCK * sizeof *block);
}

void bench_gdal_write(struct bench_gdal *gdal, struct tile tile, const int32_t *posts)
{
	int32_t *block = (int32_t *)(void *)gdal->block;
	block_of(posts, block);
	must(GDALWriteBlock(gdal->band, (int)tile.x, row_of(gdal, tile), block) == CE_None, gdal->path);
}

bool bench_gdal_holds(struct bench_gdal *gdal, struct tile tile, const int32_t *posts)
{
	int32_t *want = (int32_t *)(void *)gdal->heights;
	block_of(posts, want);
	read_block(gdal, tile, gdal->block);
	return memcmp(gdal->block, want, BLOCK_POSTS * sizeof *want) == 0;
}

void bench_gdal_flush(struct bench_gdal *gdal, bool sync)
{
	GDALFlushCache(gdal->dataset);
	if (!sync)
		return;
	int file = open(gdal->path, O_RDONLY | O_CLOEXEC);
	must(file >= 0 && fsync(file) == 0, gdal->path);
	close(file);
}

/* --- is it within the bound? --- */

static bool is_hole(GDALRasterBandH band, double value)
{
	int has = 0;
	double nodata = GDALGetRasterNoDataValue(band, &has);
	return isnan(value) || (has && value == nodata);
}

int bench_error(const char *exact, const char *other)
{
	GDALAllRegister();
	GDALDatasetH a = GDALOpen(exact, GA_ReadOnly), b = GDALOpen(other, GA_ReadOnly);
	must(a != NULL && b != NULL, other);
	GDALRasterBandH of = GDALGetRasterBand(a, 1), on = GDALGetRasterBand(b, 1);
	int width = GDALGetRasterXSize(a), height = GDALGetRasterYSize(a);
	double worst = 0, *rows = mem_alloc((size_t)width, 2 * sizeof *rows);
	bool same = GDALGetRasterXSize(b) == width && GDALGetRasterYSize(b) == height;
	int64_t holes = 0; /* in one and not in the other */
	if (rows == NULL)
		bench_must(fail_memory("a row"));
	for (int y = 0; y < height && same; y++) {
		must(GDALRasterIO(of, GF_Read, 0, y, width, 1, rows, width, 1, GDT_Float64, 0, 0) == CE_None, exact);
		must(GDALRasterIO(on, GF_Read, 0, y, width, 1, rows + width, width, 1, GDT_Float64, 0, 0) == CE_None,
		     other);
		for (int x = 0; x < width; x++) {
			bool hole = is_hole(of, rows[x]);
			if (hole != is_hole(on, rows[width + x]))
				holes++;
			else if (!hole)
				worst = fmax(worst, fabs(rows[x] - rows[width + x]));
		}
	}
	printf("{\"same_size\": %s, \"holes_differ\": %lld, \"error\": %.9g}\n", same ? "true" : "false",
	       (long long)holes, worst);
	mem_free(rows);
	GDALClose(a);
	GDALClose(b);
	return 0;
}

int bench_blocks(const char *path)
{
	GDALAllRegister();
	GDALDatasetH dataset = GDALOpen(path, GA_ReadOnly);
	must(dataset != NULL, path);
	GDALRasterBandH band = GDALGetRasterBand(dataset, 1);
	int wide, high;
	long long bytes = 0;
	GDALGetBlockSize(band, &wide, &high);
	for (int y = 0; y * high < GDALGetRasterYSize(dataset); y++)
		for (int x = 0; x * wide < GDALGetRasterXSize(dataset); x++) {
			char name[64];
			snprintf(name, sizeof name, "BLOCK_SIZE_%d_%d", x, y);
			const char *text = GDALGetMetadataItem(band, name, "TIFF");
			bytes += text != NULL ? atoll(text) : 0;
		}
	printf("{\"block_bytes\": %lld}\n", bytes);
	GDALClose(dataset);
	return 0;
}

#else

static int without(void)
{
	fputs("bench_store: built without GDAL\n", stderr);
	return 1;
}

bool bench_gdal_open(const char *path, bool in_memory, struct bench_gdal **out)
{
	return false;
}

void bench_gdal_close(struct bench_gdal *gdal)
{
}

void bench_gdal_read_native(struct bench_gdal *gdal, struct tile tile)
{
}

void bench_gdal_read(struct bench_gdal *gdal, struct tile tile)
{
}

const float *bench_gdal_heights(const struct bench_gdal *gdal)
{
	return NULL;
}

void bench_gdal_encode(struct bench_gdal *gdal, struct tile tile)
{
}

bool bench_gdal_create(const char *path, uint32_t blocks, const char *compression, struct bench_gdal **out)
{
	return false;
}

void bench_gdal_write(struct bench_gdal *gdal, struct tile tile, const int32_t *posts)
{
}

bool bench_gdal_holds(struct bench_gdal *gdal, struct tile tile, const int32_t *posts)
{
	return false;
}

void bench_gdal_flush(struct bench_gdal *gdal, bool sync)
{
}

int bench_error(const char *exact, const char *other)
{
	return without();
}

int bench_blocks(const char *path)
{
	return without();
}

#endif
