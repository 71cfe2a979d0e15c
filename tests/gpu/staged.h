/* Slots filled and read from a test's own arrays: staging of its own for each call. */
#ifndef FURROW_TESTS_GPU_STAGED_H
#define FURROW_TESTS_GPU_STAGED_H

#include <string.h>

#include "gpu/gpu.h"

#define STAGED_AT 12 /* where data begins */

static inline size_t staged_posts(uint32_t cells)
{
	return (size_t)(cells + 1) * (cells + 1);
}

static inline enum status staged_from(struct gpu *gpu, const void *data, size_t bytes, const void *more,
				      size_t more_bytes, struct gpu_staging **out)
{
	enum status status = gpu_staging_create(gpu, STAGED_AT + bytes + more_bytes, out);
	if (status != STATUS_OK)
		return status;
	char *map = gpu_staging_bytes(*out);
	memcpy(map + STAGED_AT, data, bytes);
	if (more_bytes > 0)
		memcpy(map + STAGED_AT + bytes, more, more_bytes);
	return STATUS_OK;
}

static inline enum status staged_upload_base(struct gpu *gpu, struct gpu_slots *slots, uint32_t cells, uint32_t slot,
					     const int32_t *posts)
{
	struct gpu_staging *staging;
	enum status status = staged_from(gpu, posts, staged_posts(cells) * sizeof *posts, NULL, 0, &staging);
	if (status != STATUS_OK)
		return status;
	status = gpu_slots_upload_base(slots, slot, staging, STAGED_AT);
	gpu_staging_destroy(staging);
	return status;
}

static inline enum status staged_subdivide_base(struct gpu *gpu, struct gpu_slots *slots, uint32_t cells, uint32_t slot,
						const int32_t *patch, int shift, uint32_t sub_x, uint32_t sub_y)
{
	size_t side = lattice_patch_posts(cells, shift);
	struct gpu_staging *staging;
	enum status status = staged_from(gpu, patch, side * side * sizeof *patch, NULL, 0, &staging);
	if (status != STATUS_OK)
		return status;
	status = gpu_slots_subdivide_base(slots, slot, staging, STAGED_AT, shift, sub_x, sub_y);
	gpu_staging_destroy(staging);
	return status;
}

static inline enum status staged_upload_deform(struct gpu *gpu, struct gpu_slots *slots, uint32_t cells, uint32_t slot,
					       const int32_t *offset, const uint8_t *dirt_or_null)
{
	size_t posts = staged_posts(cells), bytes = posts * sizeof *offset;
	struct gpu_staging *staging;
	enum status status = staged_from(gpu, offset, bytes, dirt_or_null, dirt_or_null != NULL ? posts : 0, &staging);
	if (status != STATUS_OK)
		return status;
	status = gpu_slots_upload_deform(slots, slot, staging, STAGED_AT, dirt_or_null != NULL ? STAGED_AT + bytes : GPU_NO_PLANE);
	gpu_staging_destroy(staging);
	return status;
}

static inline enum status staged_read_deform(struct gpu *gpu, struct gpu_slots *slots, uint32_t cells, uint32_t slot,
					     int32_t *offset, uint8_t *dirt_or_null)
{
	size_t posts = staged_posts(cells), bytes = posts * sizeof *offset;
	struct gpu_staging *staging;
	enum status status = gpu_staging_create(gpu, STAGED_AT + bytes + posts, &staging);
	if (status != STATUS_OK)
		return status;
	char *map = gpu_staging_bytes(staging);
	memset(map, 0xa5, STAGED_AT + bytes + posts);
	status = gpu_slots_read_deform(slots, slot, staging, STAGED_AT, dirt_or_null != NULL ? STAGED_AT + bytes : GPU_NO_PLANE);
	while (!gpu_staging_idle(staging))
		gpu_finish(gpu);
	memcpy(offset, map + STAGED_AT, bytes);
	if (dirt_or_null != NULL)
		memcpy(dirt_or_null, map + STAGED_AT + bytes, posts);
	gpu_staging_destroy(staging);
	return status;
}

#endif
