/*
 * Counts the samples that passed the depth test in draws between two calls. Each time uses one GL_SAMPLES_PASSED query. Its result
 * is read when it is ready; nothing waits for it. If no query is free, nothing is counted that time.
 *
 * Invariant: queries [first, first + count) of the ring are in flight, in the order in which they began.
 */
#include "gpu/internal.h"

#define QUERIES 16

struct gpu_counter {
	struct gpu *gpu;
	GLuint queries[QUERIES];
	uint32_t first, count;
	bool running;
	uint64_t samples, times; /* that have come, and were not taken yet */
};

enum status gpu_counter_create(struct gpu *gpu, struct gpu_counter **out)
{
	struct gpu_counter *counter = mem_calloc(1, sizeof *counter);
	TRY_MEM(counter, "a counter of samples");
	counter->gpu = gpu;
	if (gpu_usable(gpu))
		glCreateQueries(GL_SAMPLES_PASSED, QUERIES, counter->queries);
	enum status status = gpu_check(gpu, "a counter of samples");
	if (status != STATUS_OK) {
		gpu_counter_destroy(counter);
		return status;
	}
	*out = counter;
	return STATUS_OK;
}

void gpu_counter_destroy(struct gpu_counter *counter)
{
	if (counter == NULL)
		return;
	if (counter->queries[0] != 0)
		glDeleteQueries(QUERIES, counter->queries);
	mem_free(counter);
}

static void collect(struct gpu_counter *counter)
{
	while (counter->count > 0) {
		GLuint query = counter->queries[counter->first], there = GL_FALSE;
		GLuint64 samples = 0;
		glGetQueryObjectuiv(query, GL_QUERY_RESULT_AVAILABLE, &there);
		if (!there)
			return;
		glGetQueryObjectui64v(query, GL_QUERY_RESULT, &samples);
		counter->samples += samples;
		counter->times++;
		counter->first = (counter->first + 1) % QUERIES;
		counter->count--;
	}
}

void gpu_counter_begin(struct gpu_counter *counter)
{
	assert(!counter->running);
	if (!gpu_usable(counter->gpu))
		return;
	if (counter->count == QUERIES)
		collect(counter);
	counter->running = counter->count < QUERIES;
	if (counter->running)
		glBeginQuery(GL_SAMPLES_PASSED, counter->queries[(counter->first + counter->count++) % QUERIES]);
}

void gpu_counter_end(struct gpu_counter *counter)
{
	if (counter->running && gpu_usable(counter->gpu))
		glEndQuery(GL_SAMPLES_PASSED);
	counter->running = false;
}

void gpu_counter_take(struct gpu_counter *counter, uint64_t *samples, uint64_t *times)
{
	assert(!counter->running);
	if (gpu_usable(counter->gpu))
		collect(counter);
	*samples = counter->samples;
	*times = counter->times;
	counter->samples = counter->times = 0;
}
