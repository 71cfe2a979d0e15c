/*
 * Buffers of fixed size. What passes wrote into storage buffers is made visible to a read or a
 * write from here, and to the next pass, by one barrier.
 */
#include <string.h>

#include "gpu/internal.h"

enum status gpu_buffer_create(struct gpu *gpu, enum gpu_buffer_use use, size_t bytes,
			      const void *data_or_null, struct gpu_buffer **out)
{
	if (!gpu_usable(gpu))
		return failure_restore(&gpu->failure);
	assert(bytes > 0 && bytes <= INT32_MAX);
	struct gpu_buffer *buffer = mem_alloc(1, sizeof *buffer);
	TRY_MEM(buffer, "GPU buffer");
	*buffer = (struct gpu_buffer){.gpu = gpu, .use = use, .bytes = bytes};
	glCreateBuffers(1, &buffer->name);
	glNamedBufferStorage(buffer->name, (GLsizeiptr)bytes, data_or_null, GL_DYNAMIC_STORAGE_BIT);
	if (data_or_null == NULL)
		glClearNamedBufferData(buffer->name, GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, NULL);
	enum status status = gpu_check(gpu, "GPU buffer");
	if (status != STATUS_OK) {
		glDeleteBuffers(1, &buffer->name);
		mem_free(buffer);
		return status;
	}
	gpu->stats.bytes += bytes;
	*out = buffer;
	return STATUS_OK;
}

void gpu_buffer_destroy(struct gpu_buffer *buffer)
{
	if (buffer == NULL)
		return;
	struct gpu *gpu = buffer->gpu;
	assert(pthread_equal(gpu->owner, pthread_self()));
	if (gpu->indices == buffer)
		gpu->indices = NULL;
	glDeleteBuffers(1, &buffer->name);
	gpu->stats.bytes -= buffer->bytes;
	mem_free(buffer);
}

void gpu_buffer_write(struct gpu_buffer *buffer, size_t offset, size_t bytes, const void *data)
{
	struct gpu *gpu = buffer->gpu;
	assert(offset <= buffer->bytes && bytes <= buffer->bytes - offset);
	if (!gpu_usable(gpu) || bytes == 0)
		return;
	gpu_written_barrier(gpu);
	if (!gpu->info.software)
		glFinish(); /* gpu_list.c says why. It is done when a drive begins, goes on or goes back. */
	glNamedBufferSubData(buffer->name, (GLintptr)offset, (GLsizeiptr)bytes, data);
	gpu->stats.uploads++;
	gpu->stats.upload_bytes += bytes;
}

void gpu_buffer_read(struct gpu_buffer *buffer, size_t offset, size_t bytes, void *data)
{
	struct gpu *gpu = buffer->gpu;
	assert(offset <= buffer->bytes && bytes <= buffer->bytes - offset);
	if (!gpu_usable(gpu)) {
		memset(data, 0, bytes);
		return;
	}
	gpu_written_barrier(gpu);
	glGetNamedBufferSubData(buffer->name, (GLintptr)offset, (GLsizeiptr)bytes, data);
	gpu->stats.read_backs++;
	gpu->stats.read_back_bytes += bytes;
}

void gpu_buffer_read_into(struct gpu_buffer *buffer, size_t offset, size_t bytes, struct gpu_staging *staging,
			  size_t staging_offset)
{
	struct gpu *gpu = buffer->gpu;
	assert(staging->gpu == gpu && (offset | staging_offset | bytes) % 4 == 0);
	assert(staging_offset <= staging->bytes && bytes <= staging->bytes - staging_offset);
	assert(offset <= buffer->bytes && bytes <= buffer->bytes - offset);
	if (staging->direct || !gpu_usable(gpu)) {
		gpu_buffer_read(buffer, offset, bytes, staging->map + staging_offset);
		return;
	}
	gpu_written_barrier(gpu);
	glCopyNamedBufferSubData(buffer->name, staging->name, (GLintptr)offset, (GLintptr)staging_offset,
				 (GLsizeiptr)bytes);
	gpu->stats.read_backs++;
	gpu->stats.read_back_bytes += bytes;
	gpu_staging_fence(staging);
}

void gpu_buffer_clear(struct gpu_buffer *buffer, size_t offset, size_t bytes)
{
	struct gpu *gpu = buffer->gpu;
	assert((offset | bytes) % 4 == 0 && offset <= buffer->bytes && bytes <= buffer->bytes - offset);
	if (!gpu_usable(gpu) || bytes == 0)
		return;
	gpu_written_barrier(gpu);
	glClearNamedBufferSubData(buffer->name, GL_R32UI, (GLintptr)offset, (GLsizeiptr)bytes, GL_RED_INTEGER,
				  GL_UNSIGNED_INT, NULL);
}
