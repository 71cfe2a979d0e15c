/*
 * A ring of parcels, each a tile on its way:
 *
 *     cut (intake_conveyor_put) -> [stored ... taken ... put) -> packed by any worker -> stored, first first
 *
 * A worker that finds the first parcel packed, and nobody storing, stores it. Otherwise it packs the next one.
 *
 * Invariants:
 * - One thread at a time uses the store (`storing`, or the mutex held).
 * - Parcels are stored in the order in which they were put in. So the store does not depend on the number of threads.
 * - After a failure parcels are skipped, so that nobody waits for ever.
 */
#include "intake/conveyor.h"

#include <string.h>

#define WORKERS_MOST 64
#define PARCELS_MOST 64
#define PARCEL_BYTES (32 << 20) /* about what all parcels may take */
#define WORKER_BYTES (64 << 20) /* about what all workers may take */
#define WORKER_POST_BYTES 24    /* a packer's scratch for a post */

struct parcel {
	struct tile tile;
	struct store_range range;
	struct misfit resampled, source; /* as in struct store_meta */
	int32_t *codes;
	uint8_t *bytes; /* of what it was packed to */
	struct store_packed packed;
	bool ready;
};

struct worker {
	struct conveyor *conveyor;
	struct store_packer *packer;
	struct thread thread;
};

struct conveyor {
	struct store *store;
	size_t posts;
	int64_t passing; /* number of tiles already in the store */
	struct parcel parcels[PARCELS_MOST];
	int64_t parcel_count;
	int64_t put, taken, stored; /* since the beginning: stored <= taken <= put */
	bool storing, ended;
	bool known_ended; /* a tile was not known, so none after it is */
	struct failure failure;
	struct mutex mutex;
	struct condition changed;
	struct worker workers[WORKERS_MOST];
	int64_t worker_count; /* 0: the cutting thread does everything, with workers[0]'s packer */
};

static struct parcel *parcel_at(struct conveyor *conveyor, int64_t index)
{
	return &conveyor->parcels[index % conveyor->parcel_count];
}

static enum status store_parcel(struct conveyor *conveyor, const struct parcel *parcel)
{
	store_put_misfit(conveyor->store, &parcel->resampled, &parcel->source);
	return store_put_packed(conveyor->store, parcel->tile, &parcel->packed, &parcel->range);
}

/* Call with the mutex held. A worker releases it only for long work. */
static void store_first(struct conveyor *conveyor)
{
	struct parcel *parcel = parcel_at(conveyor, conveyor->stored);
	if (conveyor->stored >= conveyor->passing && conveyor->failure.status == STATUS_OK) {
		conveyor->storing = true;
		mutex_unlock(&conveyor->mutex);
		enum status status = store_parcel(conveyor, parcel);
		mutex_lock(&conveyor->mutex);
		conveyor->storing = false;
		if (status != STATUS_OK)
			failure_capture(&conveyor->failure, status);
	}
	parcel->ready = false;
	conveyor->stored++;
	condition_wake_all(&conveyor->changed);
}

static void pack_next(struct conveyor *conveyor, struct store_packer *packer)
{
	int64_t index = conveyor->taken++;
	struct parcel *parcel = parcel_at(conveyor, index);
	if (index >= conveyor->passing && conveyor->failure.status == STATUS_OK) {
		mutex_unlock(&conveyor->mutex);
		parcel->packed = store_pack(packer, parcel->tile, parcel->codes);
		memcpy(parcel->bytes, parcel->packed.bytes, parcel->packed.size);
		parcel->packed.bytes = parcel->bytes;
		mutex_lock(&conveyor->mutex);
	}
	parcel->ready = true;
	condition_wake_all(&conveyor->changed);
}

static void *work(void *argument)
{
	struct worker *worker = argument;
	struct conveyor *conveyor = worker->conveyor;
	mutex_lock(&conveyor->mutex);
	while (!conveyor->ended || conveyor->stored < conveyor->put) {
		if (!conveyor->storing && conveyor->stored < conveyor->put &&
		    parcel_at(conveyor, conveyor->stored)->ready)
			store_first(conveyor);
		else if (conveyor->taken < conveyor->put)
			pack_next(conveyor, worker->packer);
		else
			condition_wait(&conveyor->changed, &conveyor->mutex);
	}
	mutex_unlock(&conveyor->mutex);
	return NULL;
}

/* --- life --- */

static void conveyor_end(struct conveyor *conveyor)
{
	mutex_lock(&conveyor->mutex);
	conveyor->ended = true;
	condition_wake_all(&conveyor->changed);
	mutex_unlock(&conveyor->mutex);
	for (int64_t i = 0; i < conveyor->worker_count; i++)
		thread_join(&conveyor->workers[i].thread);
}

static void conveyor_free(struct conveyor *conveyor)
{
	for (int64_t i = 0; i < PARCELS_MOST; i++)
		mem_free_all(conveyor->parcels[i].codes, conveyor->parcels[i].bytes);
	for (int64_t i = 0; i < WORKERS_MOST; i++)
		store_packer_destroy(conveyor->workers[i].packer);
	condition_finish(&conveyor->changed);
	mutex_finish(&conveyor->mutex);
	mem_free(conveyor);
}

static int64_t clamp(int64_t value, int64_t least, int64_t most)
{
	return value < least ? least : value > most ? most : value;
}

static enum status make_packers(struct conveyor *conveyor)
{
	int64_t count = conveyor->worker_count > 0 ? conveyor->worker_count : 1;
	for (int64_t i = 0; i < count; i++) {
		conveyor->workers[i].conveyor = conveyor;
		TRY(store_packer_create(store_meta(conveyor->store), &conveyor->workers[i].packer));
	}
	return STATUS_OK;
}

static enum status make_parcels(struct conveyor *conveyor)
{
	size_t most = store_packed_most(conveyor->workers[0].packer);
	int64_t bytes = (int64_t)(conveyor->posts * sizeof(int32_t) + most), workers = conveyor->worker_count;
	conveyor->parcel_count = clamp(PARCEL_BYTES / bytes, 3, PARCELS_MOST);
	conveyor->parcel_count = clamp(4 * workers, 2, conveyor->parcel_count);
	for (int64_t i = 0; i < conveyor->parcel_count; i++) {
		struct parcel *parcel = &conveyor->parcels[i];
		parcel->codes = mem_alloc(conveyor->posts, sizeof *parcel->codes);
		parcel->bytes = mem_alloc(most, 1);
		TRY_MEM(parcel->codes != NULL && parcel->bytes != NULL, "an import");
	}
	return STATUS_OK;
}

enum status intake_conveyor_create(struct store *store, int64_t jobs, int64_t stored, struct conveyor **out)
{
	struct conveyor *conveyor = mem_calloc(1, sizeof *conveyor);
	TRY_MEM(conveyor, "an import");
	size_t side = tile_posts(&store_meta(store)->extent);
	conveyor->store = store;
	conveyor->posts = side * side;
	conveyor->passing = stored;
	conveyor->known_ended = stored == 0;
	if (jobs > 1)
		conveyor->worker_count = clamp(
			jobs, 1, clamp(WORKER_BYTES / (int64_t)(WORKER_POST_BYTES * conveyor->posts), 1, WORKERS_MOST));
	mutex_init(&conveyor->mutex);
	condition_init(&conveyor->changed);
	enum status status;
	TRY_OR(failed, make_packers(conveyor));
	if (conveyor->worker_count > 0)
		TRY_OR(failed, make_parcels(conveyor));
	for (int64_t i = 0; i < conveyor->worker_count; i++)
		TRY_OR(failed, thread_start(&conveyor->workers[i].thread, work, &conveyor->workers[i], "furrow-pack"));
	*out = conveyor;
	return STATUS_OK;
failed:
	conveyor_end(conveyor);
	conveyor_free(conveyor);
	return status;
}

bool intake_conveyor_has(const struct conveyor *conveyor)
{
	return conveyor->put < conveyor->passing; /* only the thread that puts changes `put` */
}

static enum status put_alone(struct conveyor *conveyor, const struct dem_tile *tile)
{
	struct store_range range = {tile->low, tile->high, tile->error};
	if (conveyor->put++ < conveyor->passing)
		return STATUS_OK;
	struct store_packed packed = store_pack(conveyor->workers[0].packer, tile->tile, tile->codes);
	store_put_misfit(conveyor->store, &tile->misfit, &tile->source);
	return store_put_packed(conveyor->store, tile->tile, &packed, &range);
}

enum status intake_conveyor_put(void *user, const struct dem_tile *tile)
{
	struct conveyor *conveyor = user;
	if (conveyor->worker_count == 0)
		return put_alone(conveyor, tile);
	mutex_lock(&conveyor->mutex);
	while (conveyor->put - conveyor->stored == conveyor->parcel_count)
		condition_wait(&conveyor->changed, &conveyor->mutex);
	enum status status = conveyor->failure.status;
	if (status == STATUS_OK) {
		struct parcel *parcel = parcel_at(conveyor, conveyor->put);
		mutex_unlock(&conveyor->mutex); /* nobody else knows of the parcel yet */
		parcel->tile = tile->tile;
		parcel->range = (struct store_range){tile->low, tile->high, tile->error};
		parcel->resampled = tile->misfit;
		parcel->source = tile->source;
		memcpy(parcel->codes, tile->codes, conveyor->posts * sizeof *parcel->codes);
		mutex_lock(&conveyor->mutex);
		conveyor->put++;
		condition_wake_all(&conveyor->changed);
	} else {
		failure_restore(&conveyor->failure);
	}
	mutex_unlock(&conveyor->mutex);
	return status;
}

enum status intake_conveyor_known(void *user, struct tile tile, int32_t *codes, bool *known)
{
	struct conveyor *conveyor = user;
	*known = false;
	if (conveyor->known_ended)
		return STATUS_OK;
	mutex_lock(&conveyor->mutex);
	while (conveyor->storing)
		condition_wait(&conveyor->changed, &conveyor->mutex);
	enum status status = store_get_base(conveyor->store, tile, codes, NULL, known);
	mutex_unlock(&conveyor->mutex);
	conveyor->known_ended = status != STATUS_OK || !*known;
	return status;
}

enum status intake_conveyor_get(struct conveyor *conveyor, struct tile tile, int32_t *codes, struct store_range *range, bool *found)
{
	mutex_lock(&conveyor->mutex);
	while (conveyor->storing)
		condition_wait(&conveyor->changed, &conveyor->mutex);
	enum status status = store_get_base(conveyor->store, tile, codes, range, found);
	mutex_unlock(&conveyor->mutex);
	return status;
}

enum status intake_conveyor_settle(struct conveyor *conveyor)
{
	mutex_lock(&conveyor->mutex);
	while (conveyor->worker_count > 0 && conveyor->stored < conveyor->put)
		condition_wait(&conveyor->changed, &conveyor->mutex);
	enum status status = conveyor->failure.status;
	if (status != STATUS_OK)
		failure_restore(&conveyor->failure);
	mutex_unlock(&conveyor->mutex);
	return status;
}

enum status intake_conveyor_finish(struct conveyor *conveyor)
{
	conveyor_end(conveyor);
	enum status status = conveyor->failure.status;
	if (status != STATUS_OK)
		failure_restore(&conveyor->failure);
	conveyor_free(conveyor);
	return status;
}
