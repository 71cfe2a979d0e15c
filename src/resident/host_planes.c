/* Memory of tiles: planes that tiles share, bases, classes and levels. */
#include <string.h>

#include "resident/host_slots.h"

/* --- planes --- */

/* zeros: new memory is zeros already where nothing was written to it, and takes no time there. */
static struct host_plane *make_plane(size_t bytes, bool zeros)
{
	struct host_plane *plane = zeros ? mem_calloc(1, sizeof *plane + bytes) : mem_alloc(1, sizeof *plane + bytes);
	if (plane != NULL) {
		atomic_init(&plane->refs, 1);
		plane->next = NULL;
	}
	return plane;
}

/* Takes a free plane, or makes one. zeros: all its posts are 0; else its content is undefined. NULL: out of memory. */
static struct host_plane *take(struct host_slots *slots, int plane, bool zeros)
{
	const size_t bytes = slots->posts * plane_bytes((enum plane)plane);
	mutex_lock(&slots->mutex);
	struct host_plane *held = slots->free[plane];
	if (held != NULL)
		slots->free[plane] = held->next;
	mutex_unlock(&slots->mutex);
	if (held != NULL) {
		held->next = NULL;
		atomic_store_explicit(&held->refs, 1, memory_order_relaxed);
		if (zeros)
			memset(held->posts, 0, bytes);
		return held;
	}
	held = make_plane(bytes, zeros);
	if (held == NULL)
		return NULL;
	mutex_lock(&slots->mutex);
	slots->figures.planes[plane]++;
	mutex_unlock(&slots->mutex);
	return held;
}

/* The last one to let a plane go sees all reads of the others as done. So who finds it alone may write it. */
static void let_go(struct host_slots *slots, int plane, struct host_plane *held)
{
	if (atomic_fetch_sub_explicit(&held->refs, 1, memory_order_acq_rel) > 1)
		return;
	assert(held != slots->zeros); /* 3 */
	mutex_lock(&slots->mutex);
	held->next = slots->free[plane];
	slots->free[plane] = held;
	mutex_unlock(&slots->mutex);
}

static struct host_plane *share(struct host_plane *held)
{
	if (held != NULL)
		atomic_fetch_add_explicit(&held->refs, 1, memory_order_relaxed);
	return held;
}

static bool is_alone(const struct host_plane *held)
{
	return atomic_load_explicit(&held->refs, memory_order_acquire) == 1;
}

static enum status write_plane(struct host_slots *slots, struct host_tile *tile, int plane)
{
	struct host_plane *had = tile->planes[plane];
	const bool copies = had != NULL && had != slots->zeros;
	if (had != NULL && is_alone(had))
		return STATUS_OK;
	struct host_plane *made = take(slots, plane, !copies);
	TRY_MEM(made, "a plane of a tile");
	if (copies)
		memcpy(made->posts, had->posts, slots->posts * plane_bytes((enum plane)plane));
	tile->planes[plane] = made;
	if (had != NULL)
		let_go(slots, plane, had);
	return STATUS_OK;
}

enum status resident_host_tile_write(struct host_slots *slots, struct host_tile *tile, unsigned planes)
{
	for (int plane = 0; plane < PLANES; plane++)
		if (planes & slots->planes & PLANE_BIT(plane))
			TRY(write_plane(slots, tile, plane));
	return STATUS_OK;
}

void resident_host_tile_drop(struct host_slots *slots, struct host_tile *tile, unsigned planes)
{
	for (int plane = 0; plane < PLANES; plane++) {
		struct host_plane *held = tile->planes[plane];
		if (!(planes & PLANE_BIT(plane)) || held == NULL)
			continue;
		tile->planes[plane] = NULL;
		let_go(slots, plane, held);
	}
}

void resident_host_tile_share(struct host_slots *slots, const struct host_tile *from, struct host_tile *to, unsigned zeros)
{
	for (int plane = 0; plane < PLANES; plane++) {
		struct host_plane *had = to->planes[plane], *held = from->planes[plane];
		if (held == NULL || held == slots->zeros)
			held = zeros & PLANE_BIT(plane) ? slots->zeros : NULL;
		to->planes[plane] = share(held);
		if (had != NULL)
			let_go(slots, plane, had);
	}
}

/* --- what a tile has alone --- */

static enum status need(struct host_slots *slots, void **memory, size_t bytes, uint64_t *count)
{
	if (*memory != NULL)
		return STATUS_OK;
	*memory = mem_alloc(slots->posts, bytes);
	if (*memory == NULL)
		return fail_memory("a tile in memory");
	mutex_lock(&slots->mutex);
	++*count;
	mutex_unlock(&slots->mutex);
	return STATUS_OK;
}

enum status resident_host_tile_base(struct host_slots *slots, struct host_tile *tile, int32_t **base)
{
	void *memory = tile->base;
	enum status status = need(slots, &memory, sizeof *tile->base, &slots->figures.bases);
	*base = tile->base = memory;
	return status;
}

enum status resident_host_tile_classes(struct host_slots *slots, struct host_tile *tile, uint8_t **classes)
{
	void *memory = tile->classes;
	enum status status = need(slots, &memory, 1, &slots->figures.classes);
	*classes = tile->classes = memory;
	return status;
}

enum status resident_host_tile_levels(struct host_slots *slots, struct host_tile *tile, uint8_t **levels)
{
	void *memory = tile->levels;
	enum status status = need(slots, &memory, PAGES_NUMBER_BYTES, &slots->figures.levels);
	*levels = tile->levels = memory;
	return status;
}

void resident_host_tile_finish(struct host_slots *slots, struct host_tile *tile)
{
	resident_host_tile_drop(slots, tile, ~0u);
	mem_free_all(tile->base, tile->classes, tile->levels);
	*tile = (struct host_tile){.base = NULL};
}

void resident_host_planes_finish(struct host_slots *slots)
{
	for (int plane = 0; plane < PLANES; plane++) {
		uint64_t freed = 0;
		while (slots->free[plane] != NULL) {
			struct host_plane *held = slots->free[plane];
			slots->free[plane] = held->next;
			mem_free(held);
			freed++;
		}
		assert(freed == slots->figures.planes[plane]); /* 3 */
		(void)freed;
	}
	mem_free(slots->zeros);
}
