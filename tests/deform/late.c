#include "late.h"

#include <assert.h>

#include "gpu/internal.h"

#define UNDER_WAY 64

void __wrap_gpu_buffer_read_into(struct gpu_buffer *buffer, size_t offset, size_t bytes, struct gpu_staging *staging,
				 size_t staging_offset);
bool __wrap_gpu_staging_idle(struct gpu_staging *staging);
void __wrap_gpu_finish(struct gpu *gpu);
void __real_gpu_buffer_read_into(struct gpu_buffer *buffer, size_t offset, size_t bytes, struct gpu_staging *staging,
				 size_t staging_offset);
bool __real_gpu_staging_idle(struct gpu_staging *staging);
void __real_gpu_finish(struct gpu *gpu);

int64_t late_by;
int late_misses;
static int64_t now;
static struct {
	const struct gpu_staging *staging;
	int64_t over;
} under_way[UNDER_WAY];
static size_t count;

static size_t place_of(const struct gpu_staging *staging)
{
	size_t i = 0;
	while (i < count && under_way[i].staging != staging)
		i++;
	return i;
}

void late_pass(void)
{
	now++;
}

void __wrap_gpu_buffer_read_into(struct gpu_buffer *buffer, size_t offset, size_t bytes, struct gpu_staging *staging,
				 size_t staging_offset)
{
	__real_gpu_buffer_read_into(buffer, offset, bytes, staging, staging_offset);
	size_t i = place_of(staging);
	if (late_by == 0 && i == count)
		return;
	assert(i < UNDER_WAY);
	count += i == count;
	under_way[i].staging = staging;
	under_way[i].over = late_by < INT64_MAX - now ? now + late_by : INT64_MAX;
}

bool __wrap_gpu_staging_idle(struct gpu_staging *staging)
{
	size_t i = place_of(staging);
	if (i < count && under_way[i].over <= now && late_misses > 0) {
		late_misses--;
		return false;
	}
	if (i < count && under_way[i].over > now)
		return false;
	__real_gpu_finish(staging->gpu); /* on hardware it may not be there yet */
	return __real_gpu_staging_idle(staging);
}

void __wrap_gpu_finish(struct gpu *gpu)
{
	__real_gpu_finish(gpu);
	count = 0;
}
