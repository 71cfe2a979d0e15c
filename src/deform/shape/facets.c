/*
 * Draws moving triangles over a window. Each is one instance: a rectangle around the posts that it can be above. The
 * fragment shader computes its height in whole numbers. An atomic minimum keeps the lowest, so the order does not matter.
 */
#include "soil/shape/facet.h"
#include "deform/internal.h"

#define ROOM 512 /* facets a draw: small enough that drivers need not ask the system for memory */

struct facets {
	struct gpu_list *sent;
	struct post_rect read;
	uint32_t layer, count;
	bool drawn; /* the program was run once; drivers compile it at its first run */
	struct facet list[ROOM];
};

void deform_facets_destroy(struct facets *facets)
{
	if (facets == NULL)
		return;
	gpu_list_destroy(facets->sent);
	mem_free(facets);
}

void deform_facets_plan(const char *effect, struct plan *plan)
{
	deform_plan_buffer(plan, effect, 1, gpu_list_bytes(ROOM * sizeof(struct facet)), "triangles");
}

static enum status make(struct deform *deform)
{
	struct facets *facets = mem_calloc(1, sizeof *facets);
	TRY_MEM(facets, "the triangles of objects");
	enum status status = gpu_list_create(deform->params.gpu, sizeof facets->list, &facets->sent);
	if (status != STATUS_OK) {
		mem_free(facets);
		return status;
	}
	deform->facets = facets;
	return STATUS_OK;
}

enum status deform_facets_begin(struct deform *deform, struct post_rect read, uint32_t layer)
{
	struct deform_request request;
	deform_programs_facet(&deform->params, &request);
	TRY(deform_program(deform, &request, &deform->facet));
	if (deform->facets == NULL)
		TRY(make(deform));
	deform->facets->read = read;
	deform->facets->layer = layer;
	deform->facets->count = 0;
	return STATUS_OK;
}

static void draw(struct deform *deform)
{
	struct facets *facets = deform->facets;
	struct window_params params = deform_window_params(facets->read, facets->layer);
	gpu_list_write(facets->sent, facets->count * sizeof facets->list[0], facets->list);
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_FACETS,
		.program = deform->facet,
		.target = deform->scratch[facets->layer].to[TO_BARE],
		.viewport = {0, 0, (uint32_t)params.window[0], (uint32_t)params.window[1]},
		.lists = {facets->sent},
		.images = {deform->under, deform->rest},
		.params = &params,
		.params_bytes = sizeof params,
		.instances = facets->count,
	});
	deform->figures.facets++;
	facets->count = 0;
	facets->drawn = true;
}

void deform_facets_add(void *user, const struct facet *facet)
{
	struct deform *deform = user;
	if (deform->facets->count == ROOM)
		draw(deform);
	deform->facets->list[deform->facets->count++] = *facet;
}

void deform_facets_end(struct deform *deform)
{
	struct facets *facets = deform->facets;
	if (facets->count == 0 && !facets->drawn)
		/* A facet that is above no post: its first edge leaves before the motion begins. */
		facets->list[facets->count++] = (struct facet){
			.cover = {1 << 16, 1 << 16, 2 << 2, 64 | 64 << 8 | 64 << 16 | 64 << 24},
			.edges = {{-1, -1, 0, 0}},
		};
	if (facets->count > 0)
		draw(deform);
}
