/*
 * The codec of imagery: a tile is one WebP picture, lossy or lossless, with an alpha plane only where it is not wholly opaque.
 *
 * Invariants:
 *   1. A pixel with opacity 0 has no colour, before packing and after unpacking. So lossless tiles that share an edge agree there.
 *   2. A blob is untrusted: its size in pixels is checked before anything is decoded.
 */
#include "store/internal.h"

#include <string.h>

#if defined FURROW_WEBP && FURROW_WEBP
#include <webp/decode.h>
#include <webp/encode.h>

/* Of libwebp, 0 to 6. Most with loss, since a tile is a little wider than whole blocks of WebP, and 4, the default, takes 6 % more bytes. */
#define EFFORT_LOSSY 6
#define EFFORT_LOSSLESS 4

bool store_imagery_possible(void)
{
	return true;
}

static void clear_colours(uint8_t *pixels, size_t count)
{
	for (size_t i = 0; i < count; i++)
		if (pixels[4 * i + 3] == 0)
			memset(pixels + 4 * i, 0, 3);
}

static bool is_opaque(const uint8_t *pixels, size_t count)
{
	bool opaque = true;
	for (size_t i = 0; i < count && opaque; i++)
		opaque = pixels[4 * i + 3] == 255;
	return opaque;
}

static bool configure(WebPConfig *config, int quality)
{
	if (!WebPConfigInit(config))
		return false;
	config->method = quality == 0 ? EFFORT_LOSSLESS : EFFORT_LOSSY;
	config->lossless = quality == 0;
	config->quality = quality == 0 ? 75 : (float)quality; /* lossless: effort */
	config->alpha_quality = 100;
	return WebPValidateConfig(config) != 0;
}

enum status store_imagery_pack(const uint8_t *pixels, uint32_t side, int quality, void **packed, size_t *size)
{
	WebPConfig config;
	WebPPicture picture;
	WebPMemoryWriter writer;
	const bool opaque = is_opaque(pixels, (size_t)side * side);
	*packed = NULL;
	if (!configure(&config, quality) || !WebPPictureInit(&picture))
		return fail_with(STATUS_FAILED, "imagery: libwebp does not take quality %d; give 1 to 100", quality);
	WebPMemoryWriterInit(&writer);
	picture.use_argb = quality == 0;
	picture.width = picture.height = (int)side;
	picture.writer = WebPMemoryWrite;
	picture.custom_ptr = &writer;
	const int stride = (int)side * 4;
	bool done = (opaque ? WebPPictureImportRGBX(&picture, pixels, stride) : WebPPictureImportRGBA(&picture, pixels, stride)) != 0;
	done = done && WebPEncode(&config, &picture) != 0;
	WebPPictureFree(&picture);
	if (done)
		*packed = mem_alloc(writer.size, 1);
	if (*packed != NULL) {
		memcpy(*packed, writer.mem, writer.size);
		*size = writer.size;
	}
	WebPMemoryWriterClear(&writer);
	return *packed != NULL ? STATUS_OK : fail_memory("a tile of imagery");
}

bool store_imagery_unpack(const void *bytes, size_t size, uint32_t side, uint8_t *pixels)
{
	int width = 0, height = 0;
	const size_t count = (size_t)side * side;
	if (!WebPGetInfo(bytes, size, &width, &height) || width != (int)side || height != (int)side ||
	    WebPDecodeRGBAInto(bytes, size, pixels, count * 4, (int)side * 4) == NULL)
		return false;
	clear_colours(pixels, count);
	return true;
}

#else

bool store_imagery_possible(void)
{
	return false;
}

enum status store_imagery_pack(const uint8_t *pixels, uint32_t side, int quality, void **packed, size_t *size)
{
	*packed = NULL;
	return store_imagery_check("imagery");
}

bool store_imagery_unpack(const void *bytes, size_t size, uint32_t side, uint8_t *pixels)
{
	return false;
}

#endif

enum status store_imagery_check(const char *where)
{
	return store_imagery_possible() ? STATUS_OK : fail_with(STATUS_FAILED, "%s: this furrow was built without libwebp, and has no imagery; build it with -Dimagery=enabled", where);
}
