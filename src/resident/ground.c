/*
 * Keeps the stored posts of recently used tiles in memory. The owner's thread uses them; a second thread, the warming thread, may read
 * tiles ahead. Each place holds the posts of one tile.
 *
 * Invariants of the data that the mutex guards:
 * - The posts of a place without a tile have no meaning. The posts of every other place are complete.
 * - `latest` is the place that the owner used last, or RECENT_NONE at the start. Only a read by the owner may replace its tile.
 * - Posts are read and changed only while the mutex is held.
 *
 * Reading a tile takes long. So the warming thread reads into a spare buffer without the mutex. Then it exchanges this buffer with
 * the buffer of a place. Only the owner keeps the mutex while it reads, since no other thread is more urgent.
 */
#include "resident/ground_internal.h"

#include <assert.h>
#include <math.h>

#define RANGES 16384 /* number of tiles whose height range stays in memory: about as many as a few pictures need */

int32_t resident_ground_reference(const struct store *store)
{
	const struct store_meta *meta = store_meta(store);
	return isnan(meta->low) ? 0 : lattice_reference(meta->low, meta->high);
}

enum status resident_ground_create(struct store *store, uint32_t tiles, struct ground **out)
{
	struct ground *ground = mem_calloc(1, sizeof *ground);
	TRY_MEM(ground, "the ground");
	assert(tiles >= 1);
	mutex_init(&ground->mutex);
	ground->bases.most = ground->errors.most = ground->stored.most = ground->bends.most = RANGES;
	ground->finest = store_finest_base(store);
	ground->offsets.most = SIZE_MAX;
	ground->meta = store_meta(store);
	ground->reference = resident_ground_reference(store);
	ground->relief = store_relief(store);
	ground->rocks = store_rocks(store);
	ground->latest = RECENT_NONE;
	ground->posts = mem_calloc(tiles, sizeof *ground->posts);
	enum status status = ground->posts != NULL ? recent_create(&ground->recent, tiles) : fail_memory("the ground");
	if (status == STATUS_OK)
		status = store_reader_create(store, &ground->reader);
	if (status != STATUS_OK) {
		resident_ground_destroy(ground);
		return status;
	}
	*out = ground;
	return STATUS_OK;
}

void resident_ground_destroy(struct ground *ground)
{
	if (ground == NULL)
		return;
	mem_free_list(ground->posts, ground->recent.count);
	recent_finish(&ground->recent);
	mem_free(ground->spare);
	key_cache_finish(&ground->bases);
	key_cache_finish(&ground->errors);
	key_cache_finish(&ground->bends);
	key_cache_finish(&ground->offsets);
	key_cache_finish(&ground->stored);
	mutex_finish(&ground->mutex);
	store_reader_destroy(ground->reader);
	mem_free(ground);
}

enum status resident_ground_grow(struct ground *ground, uint32_t tiles)
{
	enum status status = STATUS_OK;
	mutex_lock(&ground->mutex);
	const uint32_t count = ground->recent.count;
	if (tiles > count) {
		status = mem_resize(&ground->posts, tiles, sizeof *ground->posts, "the ground");
		for (uint32_t i = count; status == STATUS_OK && i < tiles; i++)
			ground->posts[i] = NULL;
		status = status == STATUS_OK ? recent_grow(&ground->recent, tiles) : status;
	}
	mutex_unlock(&ground->mutex);
	return status;
}

struct store_reader *resident_ground_reader(struct ground *ground)
{
	return ground->reader;
}

static int32_t *alloc_posts(const struct ground *ground)
{
	size_t side = tile_posts(&ground->meta->extent);
	return mem_alloc(side * side, sizeof(int32_t));
}

static enum status read_posts(const struct ground *ground, struct store_reader *reader, struct tile tile, int32_t *posts)
{
	size_t side = tile_posts(&ground->meta->extent), count = side * side;
	bool found;
	enum status status = store_find_base(reader, tile, posts, NULL, &found);
	assert(status != STATUS_OK || found);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		posts[i] = lattice_base_relative(height_code_metres(posts[i], ground->meta->step), ground->reference);
	return status;
}

/* Only the owner calls it, with the mutex held. The posts stay in memory while the mutex is held. */
enum status resident_ground_posts_locked(struct ground *ground, struct tile tile, const int32_t **posts)
{
	uint64_t key = tile_key(tile);
	uint32_t place = recent_find(&ground->recent, key);
	if (place == RECENT_NONE) {
		double began = clock_seconds();
		place = recent_oldest(&ground->recent, RECENT_NONE);
		if (ground->posts[place] == NULL && (ground->posts[place] = alloc_posts(ground)) == NULL)
			return fail_memory("a base tile");
		recent_empty(&ground->recent, place); /* has no tile until the read is complete */
		TRY(read_posts(ground, ground->reader, tile, ground->posts[place]));
		ground->figures.reads++;
		ground->figures.waits++;
		ground->figures.wait_ms += (clock_seconds() - began) * 1e3;
	}
	recent_use(&ground->recent, place, key);
	ground->latest = place;
	*posts = ground->posts[place];
	return STATUS_OK;
}

void resident_ground_figures(struct ground *ground, struct resident_ground_figures *figures)
{
	mutex_lock(&ground->mutex);
	*figures = ground->figures;
	mutex_unlock(&ground->mutex);
}

bool resident_ground_touch(struct ground *ground, struct tile tile)
{
	mutex_lock(&ground->mutex);
	uint32_t place = recent_find(&ground->recent, tile_key(tile));
	if (place != RECENT_NONE)
		recent_use(&ground->recent, place, tile_key(tile));
	mutex_unlock(&ground->mutex);
	return place != RECENT_NONE;
}

enum status resident_ground_warm(struct ground *ground, struct store_reader *reader, struct tile tile)
{
	if (resident_ground_touch(ground, tile))
		return STATUS_OK;
	mutex_lock(&ground->mutex);
	int32_t *posts = ground->spare;
	ground->spare = NULL;
	mutex_unlock(&ground->mutex);
	if (posts == NULL && (posts = alloc_posts(ground)) == NULL)
		return fail_memory("a base tile");
	enum status status = read_posts(ground, reader, tile, posts);
	mutex_lock(&ground->mutex);
	ground->figures.reads += status == STATUS_OK;
	/* If the owner has read the same tile meanwhile, its copy stays. */
	uint32_t place = recent_find(&ground->recent, tile_key(tile));
	if (status == STATUS_OK && place == RECENT_NONE && (place = recent_oldest(&ground->recent, ground->latest)) != RECENT_NONE) {
		int32_t *old = ground->posts[place];
		recent_use(&ground->recent, place, tile_key(tile));
		ground->posts[place] = posts;
		posts = old;
	}
	if (ground->spare == NULL) {
		ground->spare = posts;
		posts = NULL;
	}
	mutex_unlock(&ground->mutex);
	mem_free(posts);
	return status;
}
