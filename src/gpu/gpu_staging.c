/*
 * Staging: memory through which tiles go to the GPU and come from it without anyone waiting.
 *
 * States: idle -> busy with each transfer that is begun -> idle, when a poll finds them all over.
 * While it is busy the bytes of its transfers are the GPU's.
 *
 * Invariants:
 *   1. The buffer is mapped for as long as it lives.
 *   2. `fence` comes after the last transfer; NULL: idle. Fences pass in order, so one is enough.
 */

#include "gpu/internal.h"

#define PATIENCE_NS 10000000000u /* of destroy: ten seconds */

/*
 * On a software driver the mapped bytes are passed to GL as a plain pointer, and no fence is needed. A pixel buffer has no
 * advantage there: llvmpipe copies it with the CPU, within the call, after it has waited for queued work. A fence behind the
 * copy makes llvmpipe draw everything queued, even work that does not use the tile.
 *
 * Measured with bench_transfer, for 257 x 257 R32I and Mesa 22.3 on two cores. Each entry is the call's time in microseconds, by
 * pointer / by pixel buffer. The first of two entries is a read, the second an upload. +: until its fence passes.
 *
 *      after 25 ms of passes ...           without raster threads      with them
 *      none                                4/4         3/4             4/4         3/4
 *      that write the tile                 26k/26k     26k/26k         30k/27k     29k/30k
 *      that sample it                      32/27k      26k/26k         32/60+44k   28k/27k
 *      of other textures                   36/28k      36/27k          37/70+42k   37/64+45k
 *
 * After a pass that writes the tile, both ways wait for it.
 *
 * Both flags matter for reads by the CPU. With GL_CLIENT_STORAGE_BIT and GL_MAP_READ_BIT, Mesa's drivers use cached host memory.
 * Without the first flag it may be the GPU's own memory, which the CPU reads uncached over the bus. NVIDIA's driver uses cached
 * host memory for GL_MAP_READ_BIT alone.
 */
#define MAP_FLAGS (GL_MAP_READ_BIT | GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT)

enum status gpu_staging_create(struct gpu *gpu, size_t bytes, struct gpu_staging **out)
{
	if (!gpu_usable(gpu))
		return failure_restore(&gpu->failure);
	assert(bytes > 0 && bytes <= INT32_MAX);
	struct gpu_staging *staging = mem_alloc(1, sizeof *staging);
	TRY_MEM(staging, "GPU staging memory");
	*staging = (struct gpu_staging){.gpu = gpu, .bytes = bytes, .direct = gpu->info.software};
	glCreateBuffers(1, &staging->name);
	glNamedBufferStorage(staging->name, (GLsizeiptr)bytes, NULL, MAP_FLAGS | GL_CLIENT_STORAGE_BIT);
	staging->map = glMapNamedBufferRange(staging->name, 0, (GLsizeiptr)bytes, MAP_FLAGS);
	enum status status;
	TRY_OR(failed, gpu_check(gpu, "GPU staging memory"));
	if (staging->map == NULL)
		TRY_OR(failed, gpu_fail(gpu, fail_with(STATUS_FAILED,
			"GPU staging memory: it cannot be mapped; try another GL driver than %s", gpu->info.renderer)));
	gpu->stats.bytes += bytes;
	*out = staging;
	return STATUS_OK;
failed:
	glDeleteBuffers(1, &staging->name);
	mem_free(staging);
	return status;
}

/* Returns true if the transfer's fence has passed, or never will. The flush bit makes sure that the GPU reaches the fence. */
static bool pass_fence(struct gpu_staging *staging, GLuint64 patience)
{
	GLenum result = glClientWaitSync(staging->fence, GL_SYNC_FLUSH_COMMANDS_BIT, patience);
	/* A failed wait is a GL error, and after a reset of the GPU every wait ends at once. In both cases the fence is gone, but the
	 * transfer is not done. */
	if (gpu_check(staging->gpu, "transfer of a tile") == STATUS_OK && result == GL_TIMEOUT_EXPIRED)
		return false;
	glDeleteSync(staging->fence);
	staging->fence = NULL;
	return true;
}

void gpu_staging_destroy(struct gpu_staging *staging)
{
	if (staging == NULL)
		return;
	struct gpu *gpu = staging->gpu;
	assert(pthread_equal(gpu->owner, pthread_self()));
	if (staging->fence != NULL) {
		if (gpu_usable(gpu))
			(void)pass_fence(staging, PATIENCE_NS);
		glDeleteSync(staging->fence); /* takes NULL */
	}
	glDeleteBuffers(1, &staging->name);
	gpu->stats.bytes -= staging->bytes;
	mem_free(staging);
}

void *gpu_staging_bytes(struct gpu_staging *staging)
{
	return staging->map;
}

bool gpu_staging_idle(struct gpu_staging *staging)
{
	return !gpu_usable(staging->gpu) || staging->fence == NULL || pass_fence(staging, 0);
}

void gpu_staging_fence(struct gpu_staging *staging)
{
	struct gpu *gpu = staging->gpu;
	glDeleteSync(staging->fence);
	staging->fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
	if (staging->fence == NULL)
		(void)gpu_fail(gpu, fail_with(STATUS_FAILED,
			"GPU fence: it cannot be made; lower cache.slots or close other programs"));
}

static void assert_within(const struct gpu_staging *staging, const struct gpu_texture *texture, struct gpu_rect rect,
			  size_t offset)
{
	assert(staging->gpu == texture->gpu);
	assert(offset <= staging->bytes && gpu_rect_bytes(texture, rect) <= staging->bytes - offset);
	assert(offset % gpu_texel_bytes(texture) == 0);
	(void)staging, (void)texture, (void)rect, (void)offset;
}

void gpu_texture_upload_from(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect,
			     struct gpu_staging *staging, size_t offset)
{
	assert_within(staging, texture, rect, offset);
	if (!gpu_usable(staging->gpu))
		return;
	if (staging->direct) {
		gpu_texture_upload(texture, layer, rect, staging->map + offset);
		return;
	}
	glBindBuffer(GL_PIXEL_UNPACK_BUFFER, staging->name);
	gpu_texture_upload(texture, layer, rect, (const void *)offset);
	glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
	gpu_staging_fence(staging);
}

/* The mapping is coherent: what GL writes into it is seen when the fence has passed, and
 * GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT is for those that are not. */
void gpu_texture_read_into(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect,
			   struct gpu_staging *staging, size_t offset)
{
	assert_within(staging, texture, rect, offset);
	if (staging->direct || !gpu_usable(staging->gpu)) {
		gpu_texture_read(texture, layer, rect, staging->map + offset);
		return;
	}
	glBindBuffer(GL_PIXEL_PACK_BUFFER, staging->name);
	gpu_texture_read(texture, layer, rect, (void *)offset);
	glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
	gpu_staging_fence(staging);
}
