/*
 * The ring of parameter blocks (see internal.h).
 *
 * Invariants:
 *   1. Segments [0, count) are mapped for as long as the gpu lives.
 *   2. The current segment has no fence; every other one has, or was never used.
 *   3. A segment is written only while it is current, beyond `used`.
 */
#include <string.h>

#include "gpu/internal.h"

#define ALIGNMENT ((size_t)256) /* the largest GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT GL allows */

static enum status segment_create(struct gpu *gpu, struct gpu_ring_segment *segment)
{
	const GLbitfield flags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
	*segment = (struct gpu_ring_segment){0};
	glCreateBuffers(1, &segment->buffer);
	glNamedBufferStorage(segment->buffer, (GLsizeiptr)GPU_RING_BYTES, NULL, flags);
	segment->map = glMapNamedBufferRange(segment->buffer, 0, (GLsizeiptr)GPU_RING_BYTES, flags);
	enum status status;
	TRY_OR(failed, gpu_check(gpu, "GPU parameter buffer"));
	if (segment->map == NULL)
		TRY_OR(failed, gpu_fail(gpu, fail_with(STATUS_FAILED,
			"GPU parameter buffer: it cannot be mapped; try another GL driver than %s", gpu->info.renderer)));
	gpu->stats.bytes += GPU_RING_BYTES;
	gpu->stats.ring_segments++;
	return STATUS_OK;
failed:
	glDeleteBuffers(1, &segment->buffer);
	return status;
}

static void segment_unfence(struct gpu_ring_segment *segment)
{
	if (segment->fence != NULL)
		glDeleteSync(segment->fence);
	segment->fence = NULL;
}

static bool segment_idle(struct gpu_ring_segment *segment, GLuint64 timeout)
{
	if (segment->fence != NULL) {
		GLenum result = glClientWaitSync(segment->fence, GL_SYNC_FLUSH_COMMANDS_BIT, timeout);
		if (result != GL_ALREADY_SIGNALED && result != GL_CONDITION_SATISFIED)
			return false;
		segment_unfence(segment);
	}
	return true;
}

/* Makes a segment current that no queued draw reads. */
static enum status advance(struct gpu *gpu)
{
	struct gpu_ring *ring = &gpu->ring;
	if (ring->count > 0) {
		struct gpu_ring_segment *full = &ring->segments[ring->current];
		uint32_t next = (ring->current + 1) % ring->count;
		full->fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
		if (full->fence == NULL)
			return gpu_fail(gpu, fail_with(STATUS_FAILED,
				"GPU fence: it cannot be made; lower cache.slots or close other programs"));
		/* The last resort, with all segments queued: wait, for up to ten seconds. */
		GLuint64 patience = ring->count == GPU_RING_SEGMENTS ? 10000000000u : 0;
		if (segment_idle(&ring->segments[next], patience)) {
			ring->current = next;
			ring->used = 0;
			return STATUS_OK;
		}
		if (patience > 0)
			return gpu_fail(gpu, fail_with(STATUS_FAILED,
				"GPU: it does not finish its work; run again, what was committed is kept"));
	}
	uint32_t at = ring->count > 0 ? ring->current + 1 : 0;
	struct gpu_ring_segment segment;
	TRY(segment_create(gpu, &segment));
	memmove(&ring->segments[at + 1], &ring->segments[at], (ring->count - at) * sizeof segment);
	ring->segments[at] = segment;
	ring->count++;
	ring->current = at;
	ring->used = 0;
	return STATUS_OK;
}

enum status gpu_ring_bind(struct gpu *gpu, const void *params, size_t bytes)
{
	struct gpu_ring *ring = &gpu->ring;
	size_t padded = (bytes + 15) / 16 * 16; /* a std140 block's size is a multiple of 16 */
	assert(bytes > 0 && bytes <= 16384);
	if (ring->count == 0 || ring->used + padded > GPU_RING_BYTES)
		TRY(advance(gpu));
	struct gpu_ring_segment *segment = &ring->segments[ring->current];
	memcpy(segment->map + ring->used, params, bytes);
	memset(segment->map + ring->used + bytes, 0, padded - bytes);
	glBindBufferRange(GL_UNIFORM_BUFFER, 0, segment->buffer, (GLintptr)ring->used, (GLsizeiptr)padded);
	ring->used += (padded + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
	return STATUS_OK;
}

void gpu_ring_finish(struct gpu *gpu)
{
	for (uint32_t i = 0; i < gpu->ring.count; i++) {
		segment_unfence(&gpu->ring.segments[i]);
		glDeleteBuffers(1, &gpu->ring.segments[i].buffer);
		gpu->stats.bytes -= GPU_RING_BYTES;
		gpu->stats.ring_segments--;
	}
	gpu->ring = (struct gpu_ring){0};
}
