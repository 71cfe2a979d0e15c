/* Stages by name, and the groups they are told in. */
#include <assert.h>

#include "gpu/gpu.h"

static const struct {
	const char *name;
	enum gpu_group group;
} stages[GPU_STAGES] = {
	[GPU_ENVELOPE] = {"underside", GPU_DISPLACE}, [GPU_FACETS] = {"facets", GPU_DISPLACE},
	[GPU_CONTACT] = {"press", GPU_DISPLACE},
	[GPU_SMOOTH] = {"smooth", GPU_REDISTRIBUTE},   [GPU_BEND] = {"bend", GPU_REDISTRIBUTE},
	[GPU_SPREAD] = {"spread", GPU_REDISTRIBUTE},
	[GPU_SLIDE] = {"slide", GPU_REDISTRIBUTE},     [GPU_HOLD] = {"hold", GPU_REDISTRIBUTE},
	[GPU_SETTLE] = {"settle", GPU_REDISTRIBUTE},   [GPU_DISTURBANCE] = {"dirt", GPU_ATTRIBUTES},
	[GPU_PYRAMID] = {"pyramid", GPU_DECIMATE},     [GPU_TERRAIN] = {"terrain", GPU_RENDER},
	[GPU_SHADOW] = {"shadow", GPU_RENDER},	       [GPU_OBJECTS] = {"objects", GPU_RENDER},
	[GPU_SKY] = {"sky", GPU_RENDER},	       [GPU_RESOLVE] = {"resolve", GPU_RENDER},
	[GPU_EXPOSE] = {"expose", GPU_RENDER},
	[GPU_SUBDIVIDE] = {"subdivide", GPU_DIVIDE},
};

const char *gpu_stage_name(enum gpu_stage stage)
{
	assert((unsigned)stage < GPU_STAGES);
	return stages[stage].name;
}

uint64_t gpu_group_passes(const struct gpu_stats *stats, enum gpu_group group)
{
	uint64_t passes = 0;
	for (int stage = 0; stage < GPU_STAGES; stage++)
		if (stages[stage].group == group)
			passes += stats->passes[stage];
	return passes;
}

double gpu_group_ms(const struct gpu_stats *stats, enum gpu_group group)
{
	double ms = 0;
	for (int stage = 0; stage < GPU_STAGES; stage++)
		if (stages[stage].group == group)
			ms += stats->stage_ms[stage];
	return ms;
}
