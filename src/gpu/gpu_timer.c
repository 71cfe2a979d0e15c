/*
 * How long each stage's passes took.
 *
 * On hardware: a GL_TIME_ELAPSED query a pass, read when its result is there and never waited for.
 * A pass that finds no free query is not measured, and counts as the mean of its stage's others.
 * On software the driver's timers are not to be believed and cost: the time its caller spends in a
 * pass is taken.
 *
 * Invariant: queries [first, first + count) of the ring are in flight, in the order of their passes.
 */
#include "gpu/internal.h"

void gpu_timer_begin(struct gpu *gpu, enum gpu_stage stage)
{
	struct gpu_timer *timer = &gpu->timer;
	timer->running = true;
	if (gpu->info.software) {
		timer->began = clock_seconds();
		return;
	}
	if (timer->queries[0] == 0)
		glCreateQueries(GL_TIME_ELAPSED, GPU_TIMER_QUERIES, timer->queries);
	if (timer->count == GPU_TIMER_QUERIES)
		gpu_timer_collect(gpu);
	timer->running = timer->count < GPU_TIMER_QUERIES;
	if (!timer->running)
		return;
	uint32_t at = (timer->first + timer->count++) % GPU_TIMER_QUERIES;
	timer->stages[at] = (uint8_t)stage;
	glBeginQuery(GL_TIME_ELAPSED, timer->queries[at]);
}

void gpu_timer_end(struct gpu *gpu, enum gpu_stage stage)
{
	struct gpu_timer *timer = &gpu->timer;
	if (!timer->running)
		return;
	timer->running = false;
	if (!gpu->info.software) {
		glEndQuery(GL_TIME_ELAPSED);
		return;
	}
	timer->ms[stage] += (clock_seconds() - timer->began) * 1e3;
	timer->timed[stage]++;
}

void gpu_timer_collect(struct gpu *gpu)
{
	struct gpu_timer *timer = &gpu->timer;
	while (timer->count > 0) {
		GLuint query = timer->queries[timer->first];
		GLuint there = GL_FALSE;
		GLuint64 nanoseconds = 0;
		glGetQueryObjectuiv(query, GL_QUERY_RESULT_AVAILABLE, &there);
		if (!there)
			break;
		glGetQueryObjectui64v(query, GL_QUERY_RESULT, &nanoseconds);
		timer->ms[timer->stages[timer->first]] += (double)nanoseconds * 1e-6;
		timer->timed[timer->stages[timer->first]]++;
		timer->first = (timer->first + 1) % GPU_TIMER_QUERIES;
		timer->count--;
	}
	for (int stage = 0; stage < GPU_STAGES; stage++)
		if (timer->timed[stage] > 0)
			gpu->stats.stage_ms[stage] =
				timer->ms[stage] * (double)gpu->stats.passes[stage] / (double)timer->timed[stage];
}

void gpu_timer_finish(struct gpu *gpu)
{
	if (gpu->timer.queries[0] != 0)
		glDeleteQueries(GPU_TIMER_QUERIES, gpu->timer.queries);
	gpu->timer = (struct gpu_timer){0};
}
