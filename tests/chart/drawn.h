/* Shared by the tests of maps: draws a map, and finds its words and the pixels of its places. */
#ifndef FURROW_TESTS_CHART_DRAWN_H
#define FURROW_TESTS_CHART_DRAWN_H

#include "dug.h"

#include <png.h>

#include "chart/page.h"

/* --- what is drawn --- */

struct drawn {
	struct chart_raster raster;
	struct chart_page page;
	struct chart_frame frame;
	struct chart_written written;
};

static inline struct drawn draw_map(struct chart_map map, const struct chart_raster_params *params, const char *path)
{
	struct drawn drawn;
	must(chart_raster_create(params, &drawn.raster));
	map.raster = &drawn.raster;
	map.meta = map.meta != NULL ? map.meta : params->meta;
	must(chart_map_page(&map, path, &drawn.page, &drawn.frame, &drawn.written));
	return drawn;
}

static inline void drawn_finish(struct drawn *drawn)
{
	chart_page_finish(&drawn->page);
	chart_raster_finish(&drawn->raster);
}

static inline struct chart_map plain(uint32_t pixels)
{
	return (struct chart_map){
		.title = "a title", .subtitle = "a subtitle", .layer = "Offset", .ramp = CHART_RAMP_SIGNED, .pixels = pixels};
}

static inline const struct chart_said *said(const struct drawn *drawn, const char *text)
{
	for (size_t i = 0; i < drawn->page.said_count; i++)
		if (strcmp(drawn->page.said[i].text, text) == 0)
			return &drawn->page.said[i];
	return NULL;
}

/* Every word is on the page, and no two of them meet. Names are within the frame, all else is outside it. */
static inline void assert_in_order(const struct drawn *drawn)
{
	const struct chart_page *page = &drawn->page;
	const struct chart_rect paper = {2, 2, page->width - 2, page->height - 2};
	for (size_t i = 0; i < page->said_count; i++) {
		const struct chart_said *one = &page->said[i];
		if (!chart_rect_within(&one->rect, &paper))
			fail_msg("\"%s\" is not on the page", one->text);
		if (one->kind == CHART_NAME)
			assert_true(chart_rect_within(&one->rect, &drawn->frame.rect));
		else if (chart_rect_meets(&one->rect, &drawn->frame.rect))
			fail_msg("\"%s\" is on the map", one->text);
		for (size_t k = 0; k < i; k++)
			if (chart_rect_meets(&one->rect, &page->said[k].rect))
				fail_msg("\"%s\" is on \"%s\"", one->text, page->said[k].text);
	}
}

/* --- the picture's pixels --- */

struct picture {
	uint8_t *pixels; /* RGB, the top row first */
	int width, height;
};

static inline struct picture write_and_read(struct drawn *drawn)
{
	must(chart_page_write(&drawn->page, support_path("map.png")));
	png_image image = {.version = PNG_IMAGE_VERSION};
	assert_true(png_image_begin_read_from_file(&image, support_path("map.png")));
	image.format = PNG_FORMAT_RGB;
	struct picture picture = {malloc(PNG_IMAGE_SIZE(image)), (int)image.width, (int)image.height};
	assert_true(png_image_finish_read(&image, NULL, picture.pixels, 0, NULL));
	assert_int_equal(picture.width, drawn->written.width);
	assert_int_equal(picture.height, drawn->written.height);
	return picture;
}

/* The pixel at a place, metres. */
static inline const uint8_t *at_place(const struct drawn *drawn, const struct picture *picture, double x, double y)
{
	const struct chart_frame *frame = &drawn->frame;
	const int column = (int)floor((frame->x + x * frame->scale) * drawn->page.dots);
	const int row = (int)floor((frame->y - y * frame->scale) * drawn->page.dots);
	return picture->pixels + 3 * ((size_t)row * (size_t)picture->width + (size_t)column);
}

static inline void assert_colour(const uint8_t *pixel, struct chart_colour colour)
{
	const uint8_t wanted[3] = {colour.r, colour.g, colour.b};
	assert_memory_equal(pixel, wanted, 3);
}

#endif
