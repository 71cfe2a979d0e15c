/*
 * Cuts the windows of a batch into parts, one for each tile. A pass draws many parts at once: it reads and writes the tiles themselves, as
 * layers of arrays (gpu_slots_in_arrays).
 *
 * Invariants: (1) Parts that are gathered do not overlap, and hold all posts of their window. A window that reaches beyond all tiles has a
 * part without a tile, which comes before its others. (2) Parts that are stored hold each written post once for each tile that has it.
 */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "deform/batch.h"

/* Returns a part on a tile, without its posts. */
static struct part part_of(const struct deform *deform, const struct batched *batched, const struct tile_slot *tile)
{
	const struct post_rect read = batched->window.read, own = tile_post_rect(deform->params.extent, tile->tile);
	const struct gpu_slot *slot = gpu_slots_get(deform->params.slots, tile->slot);
	uint32_t base, layer = 0, other;
	struct part part = {.of = batched, .base = gpu_texture_array(slot->base, &base)};
	if (slot->planes[PLANE_OFFSET] != NULL)
		part.offset = gpu_texture_array(slot->planes[PLANE_OFFSET], &layer);
	if (slot->planes[PLANE_DISTURBANCE] != NULL)
		part.disturbance = gpu_texture_array(slot->planes[PLANE_DISTURBANCE], &other);
	assert(part.disturbance == NULL || other == layer);
	part.tile[0] = (int32_t)(read.x0 - own.x0) - (int32_t)batched->posts.x;
	part.tile[1] = (int32_t)(read.y0 - own.y0) - (int32_t)batched->posts.y;
	part.tile[2] = (int32_t)base;
	part.tile[3] = part.offset != NULL ? (int32_t)layer : -1;
	return part;
}

/* The posts of a tile that none of the window's other tiles to its west and south has. */
static struct post_rect only(const struct deform *deform, const struct batched *batched, const struct tile_slot *tile)
{
	struct post_rect own = tile_post_rect(deform->params.extent, tile->tile);
	for (size_t i = 0; i < batched->tile_count; i++) {
		const struct tile other = batched->tiles[i].tile;
		own.x0 += other.x + 1 == tile->tile.x && other.y == tile->tile.y;
		own.y0 += other.y + 1 == tile->tile.y && other.x == tile->tile.x;
	}
	return own;
}

static void cut(const struct deform *deform, const struct batched *batched)
{
	struct batch *batch = deform->batch;
	const struct post_rect read = batched->window.read, write = batched->window.write;
	int64_t held = 0;
	const size_t first = batch->gather_count++; /* for what lies on no tile */
	for (size_t i = 0; i < batched->tile_count; i++) {
		const struct tile_slot *tile = &batched->tiles[i];
		const struct post_rect gathered = post_rect_intersect(only(deform, batched, tile), read);
		const struct post_rect stored = post_rect_intersect(tile_post_rect(deform->params.extent, tile->tile), write);
		struct part part = part_of(deform, batched, tile);
		if (!post_rect_empty(gathered)) {
			part.posts = gathered;
			batch->gathers[batch->gather_count++] = part;
			held += (gathered.x1 - gathered.x0) * (gathered.y1 - gathered.y0);
		}
		part.posts = stored;
		if (!post_rect_empty(stored))
			batch->stores[batch->store_count++] = part;
	}
	if (held < (read.x1 - read.x0) * (read.y1 - read.y0))
		batch->gathers[first] = (struct part){.of = batched, .posts = read, .tile = {0, 0, -1, -1}};
	else
		batch->gathers[first] = batch->gathers[--batch->gather_count];
}

static int by_address(const void *a, const void *b)
{
	const uintptr_t first = (uintptr_t)a, second = (uintptr_t)b;
	return (first > second) - (first < second);
}

static int compare_gathers(const void *a, const void *b)
{
	const struct part *first = a, *second = b;
	const int order = by_address(first->base, second->base);
	return order != 0 ? order : by_address(first->offset, second->offset);
}

static int compare_contacts(const void *a, const void *b)
{
	const int order = compare_gathers(a, b);
	return order != 0 ? order : (int)((const struct part *)a)->of->group - (int)((const struct part *)b)->of->group;
}

static int compare_stores(const void *a, const void *b)
{
	return by_address(((const struct part *)a)->offset, ((const struct part *)b)->offset);
}

enum status deform_batch_cut(struct deform *deform)
{
	struct batch *batch = deform->batch;
	batch->gather_count = batch->store_count = 0;
	for (size_t i = 0; i < batch->count; i++) {
		const struct batched *batched = &batch->windows[i];
		for (size_t k = 0; k < batched->tile_count; k++)
			if (!post_rect_empty(post_rect_intersect(tile_post_rect(deform->params.extent, batched->tiles[k].tile), batched->window.write)))
				TRY(gpu_slots_deform(deform->params.slots, batched->tiles[k].slot));
	}
	for (size_t i = 0; i < batch->count; i++)
		cut(deform, &batch->windows[i]);
	/* Without a tile nothing is stored, but the pass runs: warm.c. */
	if (batch->store_count == 0)
		batch->stores[batch->store_count++] = (struct part){.of = &batch->windows[0], .tile = {0, 0, -1, -1}};
	qsort(batch->gathers, batch->gather_count, sizeof *batch->gathers, compare_contacts);
	qsort(batch->stores, batch->store_count, sizeof *batch->stores, compare_stores);
	return STATUS_OK;
}

size_t deform_batch_run(const struct part *parts, size_t first, size_t count, enum part_pass pass)
{
	static int (*const compare[])(const void *, const void *) = {
		[PARTS_GATHER] = compare_gathers, [PARTS_CONTACT] = compare_contacts, [PARTS_STORE] = compare_stores,
	};
	size_t end = first + 1;
	while (end < count && compare[pass](&parts[first], &parts[end]) == 0)
		end++;
	return end - first;
}

/* --- records --- */

static void rectangle(const int32_t posts[4], float hull[4][2])
{
	for (int k = 0; k < 4; k++) {
		hull[k][0] = (float)posts[k % 2 * 2];
		hull[k][1] = (float)posts[k / 2 * 2 + 1];
	}
}

/* Fills the corners of a rectangle in plan, along the object, that holds all posts below it and `reach` posts around. It is a quarter of a
 * post larger, so its rounding does not show. */
static void hull_of(const struct deform *deform, const struct batched *batched, int reach, float hull[4][2])
{
	const struct deform_contact *contact = &batched->contact;
	const struct soil_shape *shape = contact->shape;
	const struct soil_pose *to = &contact->to, *from = deform_is_contact_only(contact) ? to : &contact->from;
	const bool round = batched->group == SPHERES;
	const double c = round ? 1 : cos(to->yaw), s = round ? 0 : sin(to->yaw), spacing = deform->spacing;
	const double dx = lattice_offset_metres(to->x - from->x) / spacing, dy = lattice_offset_metres(to->y - from->y) / spacing;
	/* The middle of the motion. A post lies in the middle of its pixel. */
	const double x = lattice_offset_metres(to->x) / spacing - (double)batched->window.read.x0 + batched->posts.x - dx / 2 + 0.5;
	const double y = lattice_offset_metres(to->y) / spacing - (double)batched->window.read.y0 + batched->posts.y - dy / 2 + 0.5;
	const double more = reach * (fabs(c) + fabs(s)) + 0.25;
	const double along = shape->radius / spacing + fabs(dx * c + dy * s) / 2 + more;
	const double across = (round ? shape->radius : shape->width / 2) / spacing + fabs(dy * c - dx * s) / 2 + more;
	for (int k = 0; k < 4; k++) {
		const double u = k % 2 == 0 ? -along : along, v = k < 2 ? -across : across;
		hull[k][0] = (float)(x + u * c - v * s);
		hull[k][1] = (float)(y + u * s + v * c);
	}
}

/* Area of a quadrilateral whose corners are those of a strip; it may be turned, but is a parallelogram. */
static double area_of(float hull[4][2])
{
	return fabs(((double)hull[1][0] - (double)hull[0][0]) * ((double)hull[2][1] - (double)hull[0][1]) -
		    ((double)hull[1][1] - (double)hull[0][1]) * ((double)hull[2][0] - (double)hull[0][0]));
}

static void record(const struct deform *deform, const struct part *part, int reach, struct record *record)
{
	const struct batched *of = part->of;
	const struct post_rect read = of->window.read, posts = part->posts;
	*record = of->numbers;
	memcpy(record->tile, part->tile, sizeof record->tile);
	if (!post_rect_empty(posts))
		deform_posts_of((struct gpu_rect){of->posts.x + (uint32_t)(posts.x0 - read.x0), of->posts.y + (uint32_t)(posts.y0 - read.y0),
						  (uint32_t)(posts.x1 - posts.x0), (uint32_t)(posts.y1 - posts.y0)},
				record->posts);
	else
		memset(record->posts, 0, sizeof record->posts);
	float around[4][2];
	rectangle(record->posts, record->hull);
	if (of->group == OTHERS)
		return;
	/* On a corner of four tiles the object is larger than its part on one. */
	hull_of(deform, of, reach, around);
	if (post_rect_empty(posts) || area_of(around) < area_of(record->hull)) /* warm.c draws an empty part */
		memcpy(record->hull, around, sizeof around);
}

void deform_batch_record(struct deform *deform)
{
	struct batch *batch = deform->batch;
	const int reach = deform_model_row(deform->params.model)->smooths ? deform->params.box_radius : 0;
	struct record *to = batch->records;
	for (size_t i = 0; i < batch->gather_count; i++)
		record(deform, &batch->gathers[i], 0, to++);
	for (size_t i = 0; i < batch->store_count; i++)
		record(deform, &batch->stores[i], reach, to++);
}
