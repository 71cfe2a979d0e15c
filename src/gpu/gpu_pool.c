/*
 * Pools: textures of one kind that come one by one. Each is a view of one layer of an array. So a pass that binds the array can read and
 * write many of them. Everything else uses one of them as it uses any texture.
 *
 * Invariants: (1) There are never more layers than textures asked for at most. (2) Arrays are full, but for the last. (3) A view is
 * destroyed before its pool.
 */
#include "gpu/internal.h"

/* Bytes of the first two arrays of 4-byte texels, about. Each later array has as many layers as all before it. */
#define FIRST_BYTES ((uint64_t)4 << 20)
#define LAYERS_LEAST 8
#define LAYERS_MOST 256

struct gpu_pool {
	struct gpu *gpu;
	enum gpu_format format;
	uint32_t side, most;    /* the texture's side; how many textures there can be */
	struct gpu_texture **arrays;
	uint32_t count, layers; /* of arrays, and of their layers */
	uint32_t taken;         /* layers that have a view */
};

enum status gpu_pool_create(struct gpu *gpu, enum gpu_format format, uint32_t side, uint32_t most, struct gpu_pool **out)
{
	assert(most > 0);
	struct gpu_pool *pool = mem_alloc(1, sizeof *pool);
	struct gpu_texture **arrays = mem_calloc(most / LAYERS_MOST + LAYERS_MOST / LAYERS_LEAST, sizeof *arrays); /* more than there can be */
	if (pool == NULL || arrays == NULL) {
		mem_free_all(pool, arrays);
		return fail_memory("a pool of textures");
	}
	*pool = (struct gpu_pool){.gpu = gpu, .format = format, .side = side, .most = most, .arrays = arrays};
	*out = pool;
	return STATUS_OK;
}

void gpu_pool_destroy(struct gpu_pool *pool)
{
	if (pool == NULL)
		return;
	for (uint32_t i = 0; i < pool->count; i++)
		gpu_texture_destroy(pool->arrays[i]);
	mem_free_all(pool->arrays, pool);
}

static uint32_t least(uint32_t a, uint32_t b)
{
	return a < b ? a : b;
}

/* Adds an array. How many layers it has does not depend on the format, so pools of which textures are taken together have them alike. */
static enum status grow(struct gpu_pool *pool)
{
	const uint64_t first = FIRST_BYTES / gpu_texture_bytes(GPU_R32I, pool->side, pool->side, 1, 1);
	const uint32_t begin = first < LAYERS_LEAST ? LAYERS_LEAST : first < LAYERS_MOST ? (uint32_t)first : LAYERS_MOST;
	const uint32_t left = pool->most - pool->layers, next = least(pool->layers > begin ? pool->layers : begin, LAYERS_MOST);
	assert(pool->taken == pool->layers && left > 0);
	const uint32_t layers = least(next, left);
	TRY(gpu_texture_create(pool->gpu, pool->format, pool->side, pool->side, layers, &pool->arrays[pool->count]));
	pool->count++;
	pool->layers += layers;
	return STATUS_OK;
}

enum status gpu_pool_take(struct gpu_pool *pool, struct gpu_texture **out)
{
	if (pool->taken == pool->layers)
		TRY(grow(pool));
	struct gpu_texture *last = pool->arrays[pool->count - 1];
	TRY(gpu_texture_create_view(last, pool->taken - (pool->layers - last->layers), out));
	pool->taken++;
	return STATUS_OK;
}

void gpu_pool_return(struct gpu_pool *pool, struct gpu_texture *last)
{
	assert(pool->taken > 0 && last->array == pool->arrays[pool->count - 1]);
	gpu_texture_destroy(last);
	pool->taken--;
}

void gpu_pool_figures(const struct gpu_pool *pool, uint64_t *arrays, uint64_t *layers, uint64_t *bytes)
{
	*arrays = pool != NULL ? pool->count : 0;
	*layers = pool != NULL ? pool->layers : 0;
	*bytes = pool != NULL ? gpu_texture_bytes(pool->format, pool->side, pool->side, pool->layers, 1) * (pool->layers > 0) : 0;
}
