/*
 * Slots in host memory by themselves: memory on demand, planes that are shared and then written, windows over many tiles, coarser posts, and
 * every allocation that fails.
 */
#include "../support.h"
#include "../support/program.h"

#include "resident/host_slots.h"

enum { CELLS = 16, POSTS = (CELLS + 1) * (CELLS + 1), ACROSS = 8, SLOTS = ACROSS * ACROSS, SIDE = ACROSS * CELLS + 1 };
#define ALL ((1u << PLANES) - 1)
#define DRAWN (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE))

static uint32_t random_word(void)
{
	static uint64_t luck = 88172645463325252;
	luck = luck * 6364136223846793005 + 1442695040888963407;
	return (uint32_t)(luck >> 33);
}

static struct host_slots *make(uint32_t count, unsigned planes)
{
	struct host_slots *slots;
	must(resident_host_create(CELLS, count, planes, &slots));
	return slots;
}

/* --- memory --- */

static void a_slot_has_no_memory_until_it_is_needed(void **state)
{
	struct host_slots *slots = make(3, PLANE_BIT(PLANE_DISTURBANCE) | PLANE_BIT(PLANE_SHEAR));
	struct resident_host_figures figures;
	struct host_slot held;
	resident_host_figures(slots, &figures);
	assert_int_equal(figures.bytes, 0);
	resident_host_get(slots, 2, &held);
	assert_null(held.base);
	for (int plane = 0; plane < PLANES; plane++)
		assert_null(held.planes[plane]);
	must(resident_host_write(slots, 1, PLANE_BIT(PLANE_SHEAR) | PLANE_BIT(PLANE_DUG))); /* the slots have no dug */
	resident_host_get(slots, 1, &held);
	for (int plane = 0; plane < PLANES; plane++)
		assert_true((held.planes[plane] != NULL) == (plane == PLANE_SHEAR));
	for (int i = 0; i < POSTS; i++)
		assert_int_equal(((const int32_t *)held.planes[PLANE_SHEAR])[i], 0);
	assert_ptr_equal(held.planes[PLANE_SHEAR], resident_host_plane(slots, 1, PLANE_SHEAR));
	resident_host_figures(slots, &figures);
	assert_int_equal(figures.planes[PLANE_SHEAR], 1);
	assert_int_equal(figures.bytes, POSTS * sizeof(int32_t));
	resident_host_destroy(slots);
	resident_host_destroy(NULL);
}

static void a_shared_plane_is_copied_before_it_is_written(void **state)
{
	struct host_slots *slots = make(1, ALL);
	struct host_tile image = {.base = NULL}, *tile = &slots->entries[0].tile;
	struct resident_host_figures figures;
	must(resident_host_write(slots, 0, PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE)));
	int32_t *offset = resident_host_plane(slots, 0, PLANE_OFFSET);
	for (int i = 0; i < POSTS; i++)
		offset[i] = 7 * i;
	resident_host_tile_share(slots, tile, &image, PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DUG));
	assert_ptr_equal(image.planes[PLANE_OFFSET], tile->planes[PLANE_OFFSET]);
	assert_ptr_equal(image.planes[PLANE_DUG], slots->zeros);
	assert_null(image.planes[PLANE_SHEAR]);
	must(resident_host_write(slots, 0, PLANE_BIT(PLANE_OFFSET)));
	int32_t *mine = resident_host_plane(slots, 0, PLANE_OFFSET);
	assert_true(mine != offset && mine[5] == 35);
	mine[5] = -1;
	assert_int_equal(((const int32_t *)host_tile_plane(slots, &image, PLANE_OFFSET))[5], 35);
	/* Another page takes over what waits: zeros are no planes there. */
	struct host_tile loaded = {.base = NULL};
	must(resident_host_tile_write(slots, &loaded, PLANE_BIT(PLANE_DUG)));
	resident_host_tile_share(slots, &image, &loaded, 0);
	assert_true(loaded.planes[PLANE_DUG] == NULL && loaded.planes[PLANE_OFFSET] == image.planes[PLANE_OFFSET]);
	resident_host_tile_finish(slots, &loaded);
	/* Once nobody else has it, it is written where it is; what was let go is taken again. */
	resident_host_tile_drop(slots, &image, ALL);
	must(resident_host_write(slots, 0, ALL));
	assert_ptr_equal(resident_host_plane(slots, 0, PLANE_OFFSET), mine);
	must(resident_host_tile_write(slots, &image, PLANE_BIT(PLANE_OFFSET)));
	assert_ptr_equal(image.planes[PLANE_OFFSET]->posts, offset);
	assert_int_equal(offset[5], 0);
	resident_host_figures(slots, &figures);
	assert_int_equal(figures.planes[PLANE_OFFSET], 2);
	assert_int_equal(figures.planes[PLANE_DUG], 1);
	resident_host_tile_finish(slots, &image);
	resident_host_destroy(slots);
}

static void every_allocation_that_fails_is_told(void **state)
{
	bool whole = false;
	uint64_t nth = 1;
	for (; !whole; nth++) {
		struct host_slots *slots = NULL;
		struct host_tile tile = {.base = NULL};
		int32_t *base;
		uint8_t *classes, *levels;
		mem_fail_nth(nth, 0);
		enum status status = resident_host_create(CELLS, 2, ALL, &slots);
		if (status == STATUS_OK)
			status = resident_host_tile_base(slots, &tile, &base);
		if (status == STATUS_OK)
			status = resident_host_tile_classes(slots, &tile, &classes);
		if (status == STATUS_OK)
			status = resident_host_tile_levels(slots, &tile, &levels);
		if (status == STATUS_OK)
			status = resident_host_write(slots, 0, ALL);
		if (status == STATUS_OK)
			resident_host_tile_share(slots, &slots->entries[0].tile, &tile, ALL);
		if (status == STATUS_OK)
			status = resident_host_write(slots, 0, ALL); /* copies */
		if (status == STATUS_OK)
			status = resident_host_decimate(slots, 0, (struct gpu_rect){0, 0, CELLS + 1, CELLS + 1}, 1, 1, 0, 0);
		mem_fail_nth(0, 0);
		whole = status == STATUS_OK;
		assert_true(whole || (status == STATUS_FAILED && strstr(failure_message(), "memory") != NULL));
		if (slots != NULL)
			resident_host_tile_finish(slots, &tile);
		resident_host_destroy(slots);
	}
	assert_int_equal(nth - 1, 3 + 3 + PLANES + PLANES + 5 + 1);
}

/* --- windows --- */

/* A world of tiles, all of them in slots, in a mixed order; and the same posts as one plane each. */
struct land {
	struct host_slots *slots;
	struct tile_slot held[SLOTS];
	int32_t planes[PLANES][SIDE * SIDE], base[SIDE * SIDE];
	uint8_t classes[SIDE * SIDE], levels[SIDE * SIDE][PAGES_NUMBER_BYTES];
};

/* Makes each post random. A plane of every third tile is missing, and its posts are zeros in all tiles. */
static void lay(struct land *land)
{
	land->slots = make(SLOTS, ALL);
	for (int i = 0; i < SIDE * SIDE; i++) {
		land->base[i] = (int32_t)random_word();
		land->classes[i] = (uint8_t)random_word();
		for (int k = 0; k < PAGES_NUMBER_BYTES; k++)
			land->levels[i][k] = (uint8_t)random_word();
		for (int plane = 0; plane < PLANES; plane++)
			land->planes[plane][i] = (int32_t)(plane_bytes((enum plane)plane) == 1 ? random_word() & 255 : random_word());
	}
	for (uint32_t t = 0; t < SLOTS; t++)
		for (int plane = 0; plane < PLANES; plane++)
			for (int i = 0; i < POSTS && (t + (uint32_t)plane) % 3 == 0; i++)
				land->planes[plane][(t / ACROSS * CELLS + (uint32_t)i / (CELLS + 1)) * SIDE + t % ACROSS * CELLS + (uint32_t)i % (CELLS + 1)] = 0;
	for (uint32_t t = 0; t < SLOTS; t++) {
		const uint32_t slot = t * 37 % SLOTS;
		struct host_tile *tile = &land->slots->entries[slot].tile;
		int32_t *base;
		uint8_t *classes, *levels;
		land->held[t] = (struct tile_slot){{-3, t % ACROSS, t / ACROSS}, slot};
		must(resident_host_tile_base(land->slots, tile, &base));
		must(resident_host_tile_classes(land->slots, tile, &classes));
		must(resident_host_tile_levels(land->slots, tile, &levels));
		for (int plane = 0; plane < PLANES; plane++)
			if ((t + (uint32_t)plane) % 3 != 0)
				must(resident_host_write(land->slots, slot, PLANE_BIT(plane)));
		for (uint32_t i = 0; i < POSTS; i++) {
			const size_t at = (t / ACROSS * CELLS + i / (CELLS + 1)) * SIDE + t % ACROSS * CELLS + i % (CELLS + 1);
			base[i] = land->base[at];
			classes[i] = land->classes[at];
			memcpy(levels + PAGES_NUMBER_BYTES * i, land->levels[at], PAGES_NUMBER_BYTES);
			for (int plane = 0; plane < PLANES; plane++) {
				if ((t + (uint32_t)plane) % 3 == 0)
					continue;
				void *posts = resident_host_plane(land->slots, slot, (enum plane)plane);
				if (plane_bytes((enum plane)plane) == 1)
					((uint8_t *)posts)[i] = (uint8_t)land->planes[plane][at];
				else
					((int32_t *)posts)[i] = land->planes[plane][at];
			}
		}
	}
}

enum { WIDE = SIDE + 24 };
struct window {
	int32_t base[WIDE * WIDE], planes[PLANES][WIDE * WIDE]; /* of posts of any size */
	uint8_t classes[WIDE * WIDE], levels[WIDE * WIDE * PAGES_NUMBER_BYTES];
};

static struct soil_planes planes_of(struct window *window, struct post_rect rect, size_t width, unsigned asked)
{
	int32_t *wide[PLANES];
	for (int plane = 0; plane < PLANES; plane++)
		wide[plane] = asked & PLANE_BIT(plane) ? window->planes[plane] : NULL;
	return (struct soil_planes){
		.rect = rect, .width = width, .base = window->base, .offset = wide[PLANE_OFFSET], .deposited = wide[PLANE_DEPOSITED],
		.sinkage = wide[PLANE_PLASTIC_SINKAGE], .shear = wide[PLANE_SHEAR], .dug = wide[PLANE_DUG],
		.settled = wide[PLANE_SETTLED], .loose = wide[PLANE_LOOSE], .floor = wide[PLANE_FLOOR], .density = wide[PLANE_DENSITY], .slope = wide[PLANE_SLOPE],
		.disturbance = (uint8_t *)wide[PLANE_DISTURBANCE], .classes = window->classes, .levels = window->levels,
	};
}

/* The tiles that have posts of the rectangle, from the last to the first. */
static size_t find(const struct land *land, struct post_rect rect, struct tile_slot held[SLOTS])
{
	size_t count = 0;
	for (size_t t = SLOTS; t-- > 0;) {
		const int64_t x = land->held[t].tile.x * CELLS, y = land->held[t].tile.y * CELLS;
		if (!post_rect_empty(post_rect_intersect(rect, (struct post_rect){x, y, x + CELLS + 1, y + CELLS + 1})))
			held[count++] = land->held[t];
	}
	return count;
}

static int32_t post_of(const struct window *window, int plane, size_t at)
{
	return plane_bytes((enum plane)plane) == 1 ? ((const uint8_t *)window->planes[plane])[at] : window->planes[plane][at];
}

/* Each post of the window is that of the land; beyond it are holes, and beside the rectangle what was there before. */
static void check_window(const struct land *land, const struct window *window, const struct soil_planes *planes, unsigned asked)
{
	const struct post_rect *rect = &planes->rect;
	for (int64_t y = rect->y0; y < rect->y1; y++)
		for (int64_t x = rect->x0; x < rect->x1; x++) {
			const size_t at = (size_t)(y - rect->y0) * planes->width + (size_t)(x - rect->x0), i = (size_t)(y * SIDE + x);
			const bool in = x >= 0 && y >= 0 && x < SIDE && y < SIDE;
			assert_int_equal(window->base[at], in ? land->base[i] : BASE_NODATA);
			assert_int_equal(window->classes[at], in ? land->classes[i] : 0);
			for (int k = 0; k < PAGES_NUMBER_BYTES; k++)
				assert_int_equal(window->levels[PAGES_NUMBER_BYTES * at + (size_t)k], in ? land->levels[i][k] : 0);
			for (int plane = 0; plane < PLANES; plane++)
				if (asked & PLANE_BIT(plane))
					assert_int_equal(post_of(window, plane, at), in ? land->planes[plane][i] : 0);
		}
	if (planes->width > (size_t)(rect->x1 - rect->x0))
		assert_int_equal(window->base[rect->x1 - rect->x0], 77);
}

/* New posts within `part`, for the window and the land. */
static void change(struct land *land, struct window *window, const struct soil_planes *planes, struct post_rect part, unsigned asked)
{
	for (int64_t y = part.y0; y < part.y1; y++)
		for (int64_t x = part.x0; x < part.x1; x++)
			for (int plane = 0; plane < PLANES; plane++) {
				const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(x - planes->rect.x0);
				const uint32_t value = random_word();
				if (!(asked & PLANE_BIT(plane)))
					continue;
				if (plane_bytes((enum plane)plane) == 1)
					((uint8_t *)window->planes[plane])[at] = (uint8_t)value;
				else
					window->planes[plane][at] = (int32_t)value;
				land->planes[plane][y * SIDE + x] = (int32_t)(plane_bytes((enum plane)plane) == 1 ? value & 255 : value);
			}
}

static struct post_rect any_rect(void)
{
	const int64_t x = (int64_t)(random_word() % (SIDE + 8)) - 8, y = (int64_t)(random_word() % (SIDE + 8)) - 8, most = random_word() % 4 == 0 ? SIDE + 8 : 20;
	return (struct post_rect){x, y, x + 1 + random_word() % most, y + 1 + random_word() % most};
}

/* Marks that fade are no planes of the soil. */
static void gather(struct land *land, struct window *window, const struct tile_slot *held, size_t count, const struct soil_planes *planes, unsigned asked)
{
	resident_host_gather(land->slots, held, count, planes);
	for (int plane = PLANE_HEALED; plane <= PLANE_GROWN; plane++)
		if (asked & PLANE_BIT(plane))
			resident_host_gather_mark(land->slots, held, count, planes, (enum plane)plane, window->planes[plane]);
}

static void scatter(struct land *land, struct window *window, const struct tile_slot *held, size_t count, const struct soil_planes *planes, struct post_rect part,
		    unsigned asked)
{
	resident_host_scatter(land->slots, held, count, planes, part, asked);
	for (int plane = PLANE_HEALED; plane <= PLANE_GROWN; plane++)
		if (asked & PLANE_BIT(plane))
			resident_host_scatter_mark(land->slots, held, count, planes, (enum plane)plane, window->planes[plane], part);
}

static void a_window_is_what_its_tiles_have_and_goes_back_into_all_of_them(void **state)
{
	static struct land land;
	static struct window window;
	struct tile_slot held[SLOTS];
	size_t many = 0, beyond = 0;
	lay(&land);
	for (int trial = 0; trial < 400; trial++) {
		const struct post_rect world = {0, 0, SIDE, SIDE};
		struct post_rect rect = trial == 0 ? world : any_rect();
		rect.x1 = rect.x1 < WIDE - 16 ? rect.x1 : WIDE - 16;
		rect.y1 = rect.y1 < WIDE - 16 ? rect.y1 : WIDE - 16;
		const unsigned asked = trial % 4 == 0 ? ALL : random_word() & ALL;
		const size_t width = (size_t)(rect.x1 - rect.x0) + trial % 3;
		const size_t count = find(&land, rect, held);
		const struct soil_planes planes = planes_of(&window, rect, width, asked);
		if (width > (size_t)(rect.x1 - rect.x0))
			for (size_t i = 0; i < WIDE * WIDE; i++)
				window.base[i] = 77;
		gather(&land, &window, held, count, &planes, asked);
		check_window(&land, &window, &planes, asked);
		const struct post_rect part = post_rect_intersect(post_rect_intersect(any_rect(), rect), world);
		many += count >= 16;
		beyond += rect.x0 < 0 || rect.x1 > SIDE;
		if (post_rect_empty(part))
			continue;
		for (size_t i = 0; i < count; i++)
			must(resident_host_write(land.slots, held[i].slot, asked));
		change(&land, &window, &planes, part, asked);
		scatter(&land, &window, held, count, &planes, part, asked);
		const struct soil_planes again = planes_of(&window, rect, width, asked);
		gather(&land, &window, held, count, &again, asked);
		check_window(&land, &window, &again, asked);
	}
	assert_true(many > 10 && beyond > 20);
	/* Every tile has the posts on its edges. */
	for (uint32_t t = 0; t < SLOTS; t++) {
		const struct tile_slot one = land.held[t];
		const int64_t x = one.tile.x * CELLS, y = one.tile.y * CELLS;
		const struct soil_planes planes = planes_of(&window, (struct post_rect){x, y, x + CELLS + 1, y + CELLS + 1}, CELLS + 1, ALL);
		gather(&land, &window, &one, 1, &planes, ALL);
		check_window(&land, &window, &planes, ALL);
	}
	const struct soil_planes none = planes_of(&window, (struct post_rect){3, 3, 3, 9}, 4, ALL);
	window.base[0] = 77;
	gather(&land, &window, NULL, 0, &none, ALL);
	assert_int_equal(window.base[0], 77);
	resident_host_destroy(land.slots);
}

/* --- coarser posts --- */

static void coarser_posts_are_every_nth(void **state)
{
	for (int steps = 1; steps <= 20; steps++) {
		struct host_slots *slots = make(3, ALL);
		must(resident_host_write(slots, 0, DRAWN));
		int32_t *offset = resident_host_plane(slots, 0, PLANE_OFFSET);
		uint8_t *disturbance = resident_host_plane(slots, 0, PLANE_DISTURBANCE);
		for (int i = 0; i < POSTS; i++) {
			offset[i] = (int32_t)random_word();
			disturbance[i] = (uint8_t)random_word();
		}
		const uint32_t shift = (uint32_t)(steps < 5 ? steps : 5), step = 1u << shift;
		const uint32_t x = step < CELLS ? step : 0, side = (CELLS - x) / step + 1;
		const struct gpu_rect rect = {x, 0, CELLS + 1 - x, CELLS + 1};
		struct host_slot held;
		must(resident_host_decimate(slots, 0, rect, steps, 1, 2, 3));
		resident_host_get(slots, 1, &held);
		for (uint32_t k = 0; k < POSTS; k++) {
			const uint32_t row = k / (CELLS + 1) - 3, column = k % (CELLS + 1) - 2;
			const bool in = row <= CELLS / step && column < side;
			const uint32_t from = in ? row * step * (CELLS + 1) + x + column * step : 0;
			assert_int_equal(((const int32_t *)held.planes[PLANE_OFFSET])[k], in ? offset[from] : 0);
			assert_int_equal(((const uint8_t *)held.planes[PLANE_DISTURBANCE])[k], in ? disturbance[from] : 0);
		}
		/* From a tile that nothing touched come zeros, and no planes if there were none. */
		must(resident_host_decimate(slots, 2, rect, steps, 1, 2, 3));
		for (uint32_t k = 0; k < POSTS; k++)
			assert_int_equal(((const int32_t *)held.planes[PLANE_OFFSET])[k], 0);
		resident_host_destroy(slots);
		slots = make(2, ALL);
		must(resident_host_decimate(slots, 0, rect, steps, 1, 2, 3));
		resident_host_get(slots, 1, &held);
		assert_null(held.planes[PLANE_OFFSET]);
		resident_host_destroy(slots);
	}
}

TEST_PROGRAM(host_slots)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_slot_has_no_memory_until_it_is_needed),
		cmocka_unit_test(a_shared_plane_is_copied_before_it_is_written),
		cmocka_unit_test(every_allocation_that_fails_is_told),
		cmocka_unit_test(a_window_is_what_its_tiles_have_and_goes_back_into_all_of_them),
		cmocka_unit_test(coarser_posts_are_every_nth),
	};
	return cmocka_run_group_tests_name("host_slots", tests, support_enter, support_leave);
}
