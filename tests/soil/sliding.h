/* Random windows for the tests of sliding, on the CPU and on the GPU. */
#ifndef FURROW_TESTS_SOIL_SLIDING_H
#define FURROW_TESTS_SOIL_SLIDING_H

#include "../deform/ground.h"
#include "soil/soil.h"

#define RIM 2    /* posts around those that a window writes */
#define MOST 100 /* posts along a side of a window, at most */
#define LARGE 252 /* the same of a few windows */

/* A window's planes. Freed by window_finish. */
struct window {
	struct soil_planes planes;
	struct soil_slide_window slides;
	int32_t *deposits;
	size_t count;
};

static inline void window_init(struct window *window, struct post_rect write, bool deposited, bool classes)
{
	memset(window, 0, sizeof *window);
	window->planes.rect = (struct post_rect){write.x0 - RIM, write.y0 - RIM, write.x1 + RIM, write.y1 + RIM};
	window->planes.width = (size_t)(write.x1 - write.x0) + 2 * RIM;
	window->count = window->planes.width * ((size_t)(write.y1 - write.y0) + 2 * RIM);
	const int64_t count = (int64_t)window->count;
	window->planes.base = ground_room(count, 4);
	window->planes.offset = ground_room(count, 4);
	window->planes.deposited = deposited ? ground_room(count, 4) : NULL;
	window->planes.classes = classes ? ground_room(count, 1) : NULL;
	window->planes.contact = ground_room(count, 1);
	window->deposits = ground_room(count, 4);
	window->slides = (struct soil_slide_window){.written = write, .posts = write, .deposits = window->deposits};
}

static inline void window_finish(struct window *window)
{
	mem_free(window->planes.base);
	mem_free(window->planes.offset);
	mem_free(window->planes.deposited);
	mem_free(window->planes.classes);
	mem_free(window->planes.contact);
	mem_free(window->deposits);
}

static inline void *copy_of(const void *from, size_t bytes)
{
	void *to = ground_room((int64_t)bytes, 1);
	memcpy(to, from, bytes);
	return to;
}

/* Returns the rule of a deform's model and soils. */
static inline struct soil_sliding rule_of(const struct ground *ground)
{
	return ground->deform->sliding;
}

/* Slides on the CPU, with scratch memory of its own. */
static inline struct soil_slid slide_on_cpu(const struct soil_sliding *rule, const struct window *window, uint32_t *words)
{
	struct soil_slid slid = {.compacted = 0};
	void *scratch = ground_room((int64_t)soil_sliding_scratch(rule, &window->planes), 1);
	soil_slide_window(rule, &window->planes, &window->slides, scratch, words, &slid);
	mem_free(scratch);
	return slid;
}

#endif
