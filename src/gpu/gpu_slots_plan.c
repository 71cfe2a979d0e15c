/* What slots will make and run; the programs that their passes run with. */
#include "gpu/internal.h"

static const struct gpu_program_request subdivide[2] = {
	{.vertex = "full.vert", .fragment = "subdivide.frag"},
	{.vertex = "full.vert", .fragment = "subdivide.frag", .defines = {"RELIEF"}},
};
#define DECIMATE(...) {.vertex = "full.vert", .fragment = "decimate.frag", .defines = {__VA_ARGS__}}
static const struct gpu_program_request decimate[4][2] = { /* by how many marks that fade, and with disturbance */
	{{.vertex = "full.vert", .fragment = "decimate.frag"}, DECIMATE("DISTURBANCE")},
	{DECIMATE("MARKS 1"), DECIMATE("DISTURBANCE", "MARKS 1")},
	{DECIMATE("MARKS 2"), DECIMATE("DISTURBANCE", "MARKS 2")},
	{DECIMATE("MARKS 3"), DECIMATE("DISTURBANCE", "MARKS 3")},
};

const struct gpu_program_request *gpu_slots_subdivide_request(bool relief)
{
	return &subdivide[relief];
}

const struct gpu_program_request *gpu_slots_decimate_request(unsigned planes)
{
	return &decimate[__builtin_popcount(planes & PLANE_MARKS)][(planes & PLANE_BIT(PLANE_DISTURBANCE)) != 0];
}

static void add_program(struct plan *plan, const char *effect, const struct gpu_program_request *request)
{
	char name[GPU_PROGRAM_NAME];
	gpu_program_name(request, name, sizeof name);
	plan_add(plan, &(struct plan_line){.kind = PLAN_PROGRAM, .effect = effect, .object = -1, .amount = 1}, name);
}

static void add_pass(struct plan *plan, const char *effect, enum plan_unit unit, enum gpu_stage stage)
{
	plan_add(plan, &(struct plan_line){.kind = PLAN_PASS, .unit = unit, .effect = effect, .object = -1, .amount = 1},
		 gpu_stage_name(stage));
}

static void add_texture(struct plan *plan, const char *effect, enum plan_unit unit, uint64_t bytes, const char *name)
{
	plan_add(plan, &(struct plan_line){.kind = PLAN_TEXTURE, .unit = unit, .effect = effect, .object = -1, .amount = 1,
					   .bytes = bytes}, name);
}

/* An array is a texture. Another layer adds bytes, but no texture. */
static void add_array(struct plan *plan, const char *effect, enum plan_unit array, enum plan_unit layer, uint64_t bytes, const char *name)
{
	add_texture(plan, effect, array, 0, name);
	plan_add(plan, &(struct plan_line){.kind = PLAN_TEXTURE, .unit = layer, .effect = effect, .object = -1, .bytes = bytes}, name);
}

void gpu_slots_plan(uint32_t cells, unsigned planes, bool classes, enum gpu_division division, bool arrays, bool decimates,
		    const char *effect, struct plan *plan)
{
	uint64_t posts = (uint64_t)(cells + 1) * (cells + 1);
	planes |= planes != 0 ? PLANE_BIT(PLANE_OFFSET) : 0;
	plan_add(plan, &(struct plan_line){.kind = PLAN_PLANE, .object = -1, .amount = 1, .bytes = sizeof(int32_t)}, "base");
	add_texture(plan, NULL, PLAN_BASE_SLOT, arrays ? 0 : posts * sizeof(int32_t), "base");
	if (arrays)
		add_array(plan, NULL, PLAN_BASE_ARRAY, PLAN_BASE_LAYER, posts * sizeof(int32_t), "base");
	if (classes) {
		plan_add(plan, &(struct plan_line){.kind = PLAN_PLANE, .effect = "soil_map", .object = -1, .amount = 1, .bytes = 1},
			 "classes");
		add_texture(plan, "soil_map", PLAN_CLASS_SLOT, posts, "classes");
	}
	for (int plane = 0; plane < PLANES; plane++) {
		const bool drawn = GPU_DRAWN_PLANES & PLANE_BIT(plane);
		const char *of = effect == NULL ? NULL : plane == PLANE_DISTURBANCE || plane == PLANE_HEALED ? "dirt" : PLANE_MARKS & PLANE_BIT(plane) ? "vegetation" : plane == PLANE_DUG ? "slip" : effect;
		const uint64_t bytes = posts * plane_bytes((enum plane)plane);
		if (!(planes & PLANE_BIT(plane)))
			continue;
		add_texture(plan, of, drawn ? PLAN_DEFORM_SLOT : PLAN_STATE_SLOT, drawn && arrays ? 0 : bytes, plane_name((enum plane)plane));
		if (drawn && arrays)
			add_array(plan, of, PLAN_DEFORM_ARRAY, PLAN_DEFORM_LAYER, bytes, plane_name((enum plane)plane));
	}
	if (division != GPU_UNDIVIDED) {
		uint64_t side = cells / 2 + 1;
		add_texture(plan, "subdivide", PLAN_PATCH, side * side * sizeof(int32_t), "patch");
		add_program(plan, division == GPU_DIVIDED_RELIEF ? "relief" : "subdivide",
			    gpu_slots_subdivide_request(division == GPU_DIVIDED_RELIEF));
		add_pass(plan, "subdivide", PLAN_SUBDIVIDED, GPU_SUBDIVIDE);
	}
	if (decimates) {
		add_program(plan, "pyramid", gpu_slots_decimate_request(planes));
		add_pass(plan, "pyramid", PLAN_DECIMATED, GPU_PYRAMID);
	}
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = PLAN_RING, .object = -1, .amount = 1,
					   .bytes = GPU_RING_BYTES}, "parameters");
}

void gpu_slots_plan_mirror(uint32_t cells, unsigned planes, const char *classes_effect, const char *effect, struct plan *plan)
{
	const uint64_t posts = (uint64_t)(cells + 1) * (cells + 1);
	add_texture(plan, effect, PLAN_BASE_SLOT, posts * sizeof(int32_t), "base");
	if (classes_effect != NULL)
		add_texture(plan, classes_effect, PLAN_CLASS_SLOT, posts, "classes");
	for (int plane = 0; plane < PLANES; plane++)
		if (planes & GPU_DRAWN_PLANES & PLANE_BIT(plane))
			add_texture(plan, plane == PLANE_DISTURBANCE || plane == PLANE_HEALED ? "dirt" : PLANE_MARKS & PLANE_BIT(plane) ? "vegetation" : effect, PLAN_DEFORM_SLOT, posts * plane_bytes((enum plane)plane),
				    plane_name((enum plane)plane));
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = PLAN_RING, .effect = effect, .object = -1, .amount = 1, .bytes = GPU_RING_BYTES},
		 "parameters");
}

enum status gpu_slots_warm(struct gpu_slots *slots, enum gpu_division division, bool decimates)
{
	struct gpu *gpu = gpu_slots_gpu(slots);
	struct gpu_program *program;
	if (division != GPU_UNDIVIDED)
		TRY(gpu_program_get(gpu, gpu_slots_subdivide_request(division == GPU_DIVIDED_RELIEF), &program));
	if (decimates)
		TRY(gpu_program_get(gpu, gpu_slots_decimate_request(gpu_slots_planes(slots)), &program));
	return STATUS_OK;
}
