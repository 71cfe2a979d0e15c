/*
 * Lists: storage that passes read and the CPU writes anew, as a whole, again and again. Each writing goes into the next of several
 * copies, since passes that are queued may still read the one before. Drivers do not keep glBufferSubData behind such passes: llvmpipe
 * only after a barrier, NVIDIA's not even then. So all copies are mapped.
 *
 * Invariant: copy `copy` is the one that passes read. Its fence is NULL. Another copy's fence comes after the last pass that read it; NULL: none does.
 */
#include <string.h>

#include "gpu/internal.h"

#define PATIENCE_NS 10000000000u /* ten seconds */
#define ALIGNMENT ((size_t)256)  /* the largest GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT GL allows */
#define MAP_FLAGS (GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT)

static size_t copy_bytes(size_t bytes)
{
	return (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

uint64_t gpu_list_bytes(size_t bytes)
{
	return GPU_LIST_COPIES * copy_bytes(bytes);
}

enum status gpu_list_create(struct gpu *gpu, size_t bytes, struct gpu_list **out)
{
	const size_t all = gpu_list_bytes(bytes);
	if (!gpu_usable(gpu))
		return failure_restore(&gpu->failure);
	assert(bytes > 0 && all <= INT32_MAX);
	struct gpu_list *list = mem_alloc(1, sizeof *list);
	TRY_MEM(list, "GPU list");
	*list = (struct gpu_list){.gpu = gpu, .bytes = copy_bytes(bytes)};
	glCreateBuffers(1, &list->name);
	glNamedBufferStorage(list->name, (GLsizeiptr)all, NULL, MAP_FLAGS);
	list->map = glMapNamedBufferRange(list->name, 0, (GLsizeiptr)all, MAP_FLAGS);
	enum status status;
	TRY_OR(failed, gpu_check(gpu, "GPU list"));
	if (list->map == NULL)
		TRY_OR(failed, gpu_fail(gpu, fail_with(STATUS_FAILED,
			"GPU list: it cannot be mapped; try another GL driver than %s", gpu->info.renderer)));
	gpu->stats.bytes += all;
	*out = list;
	return STATUS_OK;
failed:
	glDeleteBuffers(1, &list->name);
	mem_free(list);
	return status;
}

void gpu_list_destroy(struct gpu_list *list)
{
	if (list == NULL)
		return;
	assert(pthread_equal(list->gpu->owner, pthread_self()));
	for (int i = 0; i < GPU_LIST_COPIES; i++)
		glDeleteSync(list->fences[i]); /* takes NULL */
	glDeleteBuffers(1, &list->name);
	list->gpu->stats.bytes -= GPU_LIST_COPIES * list->bytes;
	mem_free(list);
}

/* Makes the next copy current, and waits until no queued pass reads it. */
static void next_copy(struct gpu_list *list)
{
	struct gpu *gpu = list->gpu;
	list->fences[list->copy] = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
	if (list->fences[list->copy] == NULL) {
		(void)gpu_fail(gpu, fail_with(STATUS_FAILED, "GPU fence: it cannot be made; lower cache.slots or close other programs"));
		return;
	}
	list->copy = (list->copy + 1) % GPU_LIST_COPIES;
	GLsync fence = list->fences[list->copy];
	if (fence != NULL && glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, PATIENCE_NS) == GL_TIMEOUT_EXPIRED)
		(void)gpu_fail(gpu, fail_with(STATUS_FAILED, "GPU: it does not finish its work; run again, what was committed is kept"));
	glDeleteSync(fence);
	list->fences[list->copy] = NULL;
}

void gpu_list_write(struct gpu_list *list, size_t bytes, const void *data)
{
	struct gpu *gpu = list->gpu;
	assert(bytes <= list->bytes);
	if (!gpu_usable(gpu) || bytes == 0)
		return;
	next_copy(list);
	if (gpu_usable(gpu))
		memcpy(list->map + list->copy * list->bytes, data, bytes);
	gpu->stats.uploads++;
	gpu->stats.upload_bytes += bytes;
}

void gpu_list_bind(const struct gpu_list *list, uint32_t binding)
{
	glBindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, list->name, (GLintptr)(list->copy * list->bytes), (GLsizeiptr)list->bytes);
}
