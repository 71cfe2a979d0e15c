#include "conveyor.h"

#include <string.h>

#define BUFFERS 16

struct parcel {
	struct tile tile;
	struct store_range range;
	int32_t *codes;
};

struct conveyor {
	struct store *store;
	size_t posts;
	struct parcel parcels[BUFFERS]; /* a ring: [taken, put) wait to be stored */
	uint64_t put, taken;
	bool ended;
	struct failure failure;
	struct mutex mutex;
	struct condition changed;
	struct thread thread;
};

static void *store_body(void *argument)
{
	struct conveyor *conveyor = argument;
	mutex_lock(&conveyor->mutex);
	for (;;) {
		while (conveyor->taken == conveyor->put && !conveyor->ended)
			condition_wait(&conveyor->changed, &conveyor->mutex);
		if (conveyor->taken == conveyor->put)
			break;
		struct parcel *parcel = &conveyor->parcels[conveyor->taken % BUFFERS];
		bool failed = conveyor->failure.status != STATUS_OK;
		mutex_unlock(&conveyor->mutex);
		enum status status = STATUS_OK;
		if (!failed)
			status = store_put_base(conveyor->store, parcel->tile, parcel->codes, &parcel->range);
		mutex_lock(&conveyor->mutex);
		if (status != STATUS_OK)
			failure_capture(&conveyor->failure, status);
		conveyor->taken++;
		condition_wake_all(&conveyor->changed);
	}
	mutex_unlock(&conveyor->mutex);
	return NULL;
}

static void conveyor_free(struct conveyor *conveyor)
{
	for (int i = 0; i < BUFFERS; i++)
		mem_free(conveyor->parcels[i].codes);
	condition_finish(&conveyor->changed);
	mutex_finish(&conveyor->mutex);
	mem_free(conveyor);
}

enum status conveyor_create(struct store *store, uint32_t cells, struct conveyor **out)
{
	struct conveyor *conveyor = mem_calloc(1, sizeof *conveyor);
	if (conveyor == NULL)
		return fail_memory("an import");
	conveyor->store = store;
	conveyor->posts = (size_t)(cells + 1) * (cells + 1);
	mutex_init(&conveyor->mutex);
	condition_init(&conveyor->changed);
	enum status status = STATUS_OK;
	for (int i = 0; i < BUFFERS && status == STATUS_OK; i++) {
		conveyor->parcels[i].codes = mem_alloc(conveyor->posts, sizeof *conveyor->parcels[i].codes);
		if (conveyor->parcels[i].codes == NULL)
			status = fail_memory("an import");
	}
	if (status == STATUS_OK)
		status = thread_start(&conveyor->thread, store_body, conveyor, "furrow-store");
	if (status != STATUS_OK) {
		conveyor_free(conveyor);
		return status;
	}
	*out = conveyor;
	return STATUS_OK;
}

enum status conveyor_put(void *user, const struct dem_tile *tile)
{
	struct conveyor *conveyor = user;
	mutex_lock(&conveyor->mutex);
	while (conveyor->put - conveyor->taken == BUFFERS)
		condition_wait(&conveyor->changed, &conveyor->mutex);
	enum status status = conveyor->failure.status;
	if (status == STATUS_OK) {
		struct parcel *parcel = &conveyor->parcels[conveyor->put % BUFFERS];
		parcel->tile = tile->tile;
		parcel->range = (struct store_range){tile->low, tile->high, tile->error};
		memcpy(parcel->codes, tile->codes, conveyor->posts * sizeof *parcel->codes);
		conveyor->put++;
		condition_wake_all(&conveyor->changed);
	} else {
		failure_restore(&conveyor->failure);
	}
	mutex_unlock(&conveyor->mutex);
	return status;
}

enum status conveyor_finish(struct conveyor *conveyor)
{
	mutex_lock(&conveyor->mutex);
	conveyor->ended = true;
	condition_wake_all(&conveyor->changed);
	mutex_unlock(&conveyor->mutex);
	thread_join(&conveyor->thread);
	enum status status = conveyor->failure.status;
	if (status != STATUS_OK)
		failure_restore(&conveyor->failure);
	conveyor_free(conveyor);
	return status;
}
