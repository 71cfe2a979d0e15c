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
	if (buffer == NULL)
		return fail_memory("GPU buffer");
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
	gpu_storage_barrier(gpu);
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
	gpu_storage_barrier(gpu);
	glGetNamedBufferSubData(buffer->name, (GLintptr)offset, (GLsizeiptr)bytes, data);
	gpu->stats.read_backs++;
	gpu->stats.read_back_bytes += bytes;
}
