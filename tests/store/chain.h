/* Random drives in a chain of overlays, and the same drives in one plain store. */
#ifndef FURROW_TEST_STORE_CHAIN_H
#define FURROW_TEST_STORE_CHAIN_H

#include "overlay.h"

enum { DEPTH = 5 };

struct chain {
	char paths[DEPTH + 1][256]; /* 0: the plain store */
	char copy[256];             /* the store with the same drives in one file */
	struct field field;
	uint32_t seed;
	int64_t step;
};

static UNUSED uint32_t chain_draw(struct chain *chain, uint32_t below)
{
	return mix(chain->seed++, 3, 33) % below;
}

static UNUSED struct chain chain_make(const char *name, uint32_t seed)
{
	struct chain chain = {.field = field_make(-1), .seed = seed};
	for (int i = 0; i <= DEPTH; i++) {
		snprintf(chain.paths[i], sizeof chain.paths[i], "%s/%s%d.furrow", folder, name, i);
		unlink(chain.paths[i]);
	}
	snprintf(chain.copy, sizeof chain.copy, "%s/%s-copy.furrow", folder, name);
	make_store(chain.paths[0]);
	make_store(chain.copy);
	return chain;
}

static UNUSED void chain_free(struct chain *chain)
{
	field_free(&chain->field);
}

/* One commit into both: a rut is dug, or a rectangle is filled again until it is as it was imported; a model may keep fewer planes. */
static UNUSED void chain_drive(struct chain *chain, struct store *over, struct store *copy)
{
	struct field *field = &chain->field;
	struct store_commit_result results[2];
	int64_t cx = chain_draw(chain, 150), cy = chain_draw(chain, 100), radius = 1 + chain_draw(chain, 24);
	struct post_rect rect = around(cx, cy, radius);
	uint32_t what = chain_draw(chain, 5);
	if (what == 0) {
		rect = chain_draw(chain, 3) == 0 ? field_all(field) : rect;
		for (int64_t y = 0; y < field->height; y++)
			for (int64_t x = 0; x < field->width; x++)
				for (int plane = 0; plane < PLANES; plane++)
					if (x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1)
						memset((char *)field->planes[plane] + (size_t)(y * field->width + x) * plane_bytes((enum plane)plane),
						       0, plane_bytes((enum plane)plane));
	} else {
		field_dig(field, cx, cy, radius, chain_draw(chain, 1000));
	}
	rect.x0 = rect.x0 < 0 ? 0 : rect.x0;
	rect.y0 = rect.y0 < 0 ? 0 : rect.y0;
	/* A model without state drops the soil's state of whole tiles: the field does not follow that, so it is dug anew. */
	field->carried = what == 1 ? PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE) : (1u << PLANES) - 1;
	chain->step++;
	assert_ok(field_commit(field, rect, over, chain->step, &results[0]));
	assert_ok(field_commit(field, rect, copy, chain->step, &results[1]));
	assert_int_equal(results[0].commit, results[1].commit);
	assert_int_equal(results[0].below, results[1].below);
	assert_int_equal(results[0].above, results[1].above);
	if (what != 1)
		return;
	field->carried = (1u << PLANES) - 1;
	assert_ok(field_commit(field, field_all(field), over, ++chain->step, &results[0]));
	assert_ok(field_commit(field, field_all(field), copy, chain->step, &results[1]));
}

/* Drives into the plain store, then into an overlay of it, and so on to the given depth. Each time the chain is the copy. */
static UNUSED void chain_grow(struct chain *chain, int depth, int commits)
{
	for (int i = 0; i <= depth; i++) {
		if (i > 0)
			assert_ok(store_create_overlay(chain->paths[i], chain->paths[i - 1]));
		struct store *over = open_store(chain->paths[i], STORE_WRITE), *copy = open_store(chain->copy, STORE_WRITE);
		assert_int_equal(store_depth(over), i);
		assert_ok(store_set_working_level(over, -1));
		assert_ok(store_set_working_level(copy, -1));
		for (int commit = 0; commit < commits; commit++)
			chain_drive(chain, over, copy);
		store_close(over);
		store_close(copy);
	}
}

#endif
