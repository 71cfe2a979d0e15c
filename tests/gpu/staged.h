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

static inline enum status staged_from(struct gpu *gpu, const void *data, size_t bytes, struct gpu_staging **out)
{
	enum status status = gpu_staging_create(gpu, STAGED_AT + bytes, out);
	if (status != STATUS_OK)
		return status;
	memcpy((char *)gpu_staging_bytes(*out) + STAGED_AT, data, bytes);
	return STATUS_OK;
}

static inline enum status staged_upload_base(struct gpu *gpu, struct gpu_slots *slots, uint32_t cells, uint32_t slot,
					     const int32_t *posts)
{
	struct gpu_staging *staging;
	enum status status = staged_from(gpu, posts, staged_posts(cells) * sizeof *posts, &staging);
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
	enum status status = staged_from(gpu, patch, side * side * sizeof *patch, &staging);
	if (status != STATUS_OK)
		return status;
	status = gpu_slots_subdivide_base(slots, slot, staging, STAGED_AT, shift, sub_x, sub_y);
	gpu_staging_destroy(staging);
	return status;
}

/* A place for each plane that is not NULL, one after the other; *bytes: to their end. */
static inline void staged_places(uint32_t cells, const void *const planes[PLANES], size_t places[PLANES], size_t *bytes)
{
	*bytes = STAGED_AT;
	for (int plane = 0; plane < PLANES; plane++) {
		places[plane] = planes[plane] != NULL ? *bytes : GPU_NO_PLANE;
		if (planes[plane] != NULL)
			*bytes += (staged_posts(cells) * plane_bytes(plane) + 3) / 4 * 4;
	}
}

static inline enum status staged_upload_planes(struct gpu *gpu, struct gpu_slots *slots, uint32_t cells, uint32_t slot,
					       const void *const planes[PLANES])
{
	size_t places[PLANES], bytes;
	struct gpu_staging *staging;
	staged_places(cells, planes, places, &bytes);
	enum status status = gpu_staging_create(gpu, bytes, &staging);
	if (status != STATUS_OK)
		return status;
	for (int plane = 0; plane < PLANES; plane++)
		if (planes[plane] != NULL)
			memcpy((char *)gpu_staging_bytes(staging) + places[plane], planes[plane],
			       staged_posts(cells) * plane_bytes(plane));
	status = gpu_slots_upload_deform(slots, slot, staging, places);
	gpu_staging_destroy(staging);
	return status;
}

static inline enum status staged_read_planes(struct gpu *gpu, struct gpu_slots *slots, uint32_t cells, uint32_t slot,
					     void *const planes[PLANES])
{
	size_t places[PLANES], bytes;
	struct gpu_staging *staging;
	staged_places(cells, (const void *const *)planes, places, &bytes);
	enum status status = gpu_staging_create(gpu, bytes, &staging);
	if (status != STATUS_OK)
		return status;
	memset(gpu_staging_bytes(staging), 0xa5, bytes);
	status = gpu_slots_read_deform(slots, slot, staging, places);
	while (!gpu_staging_idle(staging))
		gpu_finish(gpu);
	for (int plane = 0; plane < PLANES; plane++)
		if (planes[plane] != NULL)
			memcpy(planes[plane], (char *)gpu_staging_bytes(staging) + places[plane],
			       staged_posts(cells) * plane_bytes(plane));
	gpu_staging_destroy(staging);
	return status;
}

static inline enum status staged_upload_deform(struct gpu *gpu, struct gpu_slots *slots, uint32_t cells, uint32_t slot,
					       const int32_t *offset, const uint8_t *dirt_or_null)
{
	return staged_upload_planes(gpu, slots, cells, slot,
				    (const void *const[PLANES]){[PLANE_OFFSET] = offset, [PLANE_DISTURBANCE] = dirt_or_null});
}

static inline enum status staged_read_deform(struct gpu *gpu, struct gpu_slots *slots, uint32_t cells, uint32_t slot,
					     int32_t *offset, uint8_t *dirt_or_null)
{
	return staged_read_planes(gpu, slots, cells, slot,
				  (void *const[PLANES]){[PLANE_OFFSET] = offset, [PLANE_DISTURBANCE] = dirt_or_null});
}

#endif
