/*
 * Objects in the picture, and their shadows on the ground. Each different shape has its triangles in buffers once. Objects of one
 * shape that look about equally large are one draw. All shadows are two draws over the ground, before the objects are drawn. The
 * first reads the depth and keeps the darkest shadow in alpha, the second takes the light of the sun away by it.
 *
 * Invariants:
 * - One function decides what is planned of a shape and what is made of it.
 * - Places are made relative to the eye in doubles.
 * - At most as many objects are shown as there are in the scene.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/objects.h"

/* Radius in pixels of the ball around an object, from which on its finer details are drawn. */
static const double details_from[OBJECT_DETAILS] = {50, 12, 0};

static const uint16_t volume_sides[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
					  2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};

static bool same_shape(const struct soil_shape *a, const struct soil_shape *b)
{
	if (a->kind != b->kind)
		return false;
	if (a->kind == SOIL_MESH)
		return a->mesh == b->mesh;
	if (a->kind == SOIL_BOX || a->kind == SOIL_ELLIPSOID)
		return memcmp(a->size, b->size, sizeof a->size) == 0;
	if (a->kind == SOIL_CYLINDER || a->kind == SOIL_CAPSULE)
		return a->radius == b->radius && a->length == b->length;
	if (a->radius != b->radius || a->kind == SOIL_SPHERE)
		return a->radius == b->radius;
	return a->width == b->width && a->grousers == b->grousers &&
	       (a->grousers == 0 || (a->grouser_height == b->grouser_height && a->grouser_thickness == b->grouser_thickness));
}

/* Returns true if no object before it has its shape. */
static bool is_first(const struct scene_object *objects, size_t i, size_t *first)
{
	for (*first = 0; *first < i; ++*first)
		if (same_shape(&objects[*first].shape, &objects[i].shape))
			return false;
	return true;
}

/* --- programs and plan --- */

static bool shows(uint64_t effects, size_t count)
{
	return (effects >> EFFECT_OBJECTS & 1) && count > 0;
}

static bool casts(uint64_t effects, size_t count)
{
	return shows(effects, count) && (effects >> EFFECT_SHADOW & 1);
}

static struct gpu_program_request request_of(uint64_t effects, const char *body, int samples, bool shadow)
{
	struct gpu_program_request request = {
		.vertex = shadow ? "shadow.vert" : "object.vert",
		.fragment = shadow ? "shadow.frag" : "object.frag",
	};
	size_t count = 0;
	if (effects >> EFFECT_FOG & 1)
		request.defines[count++] = scene_effect_row(EFFECT_FOG)->define;
	if (shadow && samples > 1)
		request.defines[count++] = scene_effect_row(EFFECT_ANTIALIAS)->define;
	if (!shadow && (effects >> EFFECT_TERRAIN_SHADOW & 1))
		request.defines[count++] = scene_effect_row(EFFECT_TERRAIN_SHADOW)->define;
	if (!shadow && (effects >> EFFECT_LIGHT & 1))
		request.defines[count++] = render_light_define(effects);
	request.defines[count] = body;
	return request;
}

/* The request for what takes the sun's light away. */
static struct gpu_program_request umbra_of(int samples)
{
	return (struct gpu_program_request){.vertex = "full.vert", .fragment = "umbra.frag",
					    .defines = {samples > 1 ? scene_effect_row(EFFECT_ANTIALIAS)->define : NULL}};
}

static const struct gpu_program_request measure_request = {.vertex = "object.vert", .fragment = "measure_object.frag"};

static enum status program_of(struct render *render, bool shadow, struct gpu_program **out)
{
	if (render->measuring)
		return gpu_program_get(render->gpu, &measure_request, out);
	struct gpu_program_request request = request_of(render->effects, render_body_define(&render->light), (int)render->screen->samples, shadow);
	return gpu_program_get(render->gpu, &request, out);
}

enum status render_objects_warm(struct render *render)
{
	struct gpu_program *program;
	if (render->objects == NULL)
		return STATUS_OK;
	TRY(program_of(render, false, &program));
	if (render->measures)
		TRY(gpu_program_get(render->gpu, &measure_request, &program));
	if (!render->objects->casts)
		return STATUS_OK;
	const struct gpu_program_request umbra = umbra_of((int)render->screen->samples);
	TRY(program_of(render, true, &program));
	return gpu_program_get(render->gpu, &umbra, &program);
}

static void add(struct plan *plan, enum plan_kind kind, enum plan_unit unit, enum scene_effect effect, uint64_t bytes, const char *name)
{
	plan_add(plan, &(struct plan_line){.kind = kind, .unit = unit, .effect = scene_effect_row(effect)->name, .object = -1, .amount = 1, .bytes = bytes},
		 name);
}

static void add_program(struct plan *plan, enum scene_effect effect, const struct gpu_program_request *request)
{
	char name[GPU_PROGRAM_NAME];
	gpu_program_name(request, name, sizeof name);
	add(plan, PLAN_PROGRAM, PLAN_ONCE, effect, 0, name);
}

static void add_bodies_program(struct plan *plan, enum scene_effect effect, const struct render_params *params)
{
	struct scene_light light = params->light != NULL ? *params->light : scene_light_default();
	struct gpu_program_request request = request_of(params->effects, render_body_define(&light), params->samples, effect == EFFECT_SHADOW);
	add_program(plan, effect, &request);
}

void render_objects_plan(const struct render_params *params, struct plan *plan)
{
	if (!shows(params->effects, params->object_count))
		return;
	add_bodies_program(plan, EFFECT_OBJECTS, params);
	if (params->measures)
		add_program(plan, EFFECT_CAMERAS, &measure_request);
	add(plan, PLAN_PASS, PLAN_OBJECTS, EFFECT_OBJECTS, 0, gpu_stage_name(GPU_OBJECTS));
	add(plan, PLAN_BUFFER, PLAN_ONCE, EFFECT_OBJECTS, gpu_list_bytes(params->object_count * sizeof(struct object_posed)), "objects: where they are");
	for (size_t i = 0; i < params->object_count; i++) {
		struct object_mesh mesh;
		char name[96];
		size_t first;
		if (!is_first(params->objects, i, &first))
			continue;
		if (render_object_mesh_make(&params->objects[i].shape, &mesh) != STATUS_OK) {
			plan->failed = true;
			return;
		}
		snprintf(name, sizeof name, "objects: corners of %s", params->objects[i].name);
		add(plan, PLAN_BUFFER, PLAN_ONCE, EFFECT_OBJECTS, mesh.corner_count * sizeof *mesh.corners, name);
		snprintf(name, sizeof name, "objects: triangles of %s", params->objects[i].name);
		add(plan, PLAN_BUFFER, PLAN_ONCE, EFFECT_OBJECTS, mesh.index_count * sizeof *mesh.indices, name);
		render_object_mesh_finish(&mesh);
	}
	if (!casts(params->effects, params->object_count))
		return;
	const struct gpu_program_request umbra = umbra_of(params->samples);
	const uint64_t samples = (uint64_t)params->width * (uint64_t)params->height * (params->samples > 1 ? (uint64_t)params->samples : 1);
	add_bodies_program(plan, EFFECT_SHADOW, params);
	add_program(plan, EFFECT_SHADOW, &umbra);
	for (int pass = 0; pass < 2; pass++)
		add(plan, PLAN_PASS, PLAN_SHADOWED, EFFECT_SHADOW, 0, gpu_stage_name(GPU_SHADOW));
	add(plan, PLAN_TEXTURE, PLAN_ONCE, EFFECT_SHADOW, gpu_format_bytes(render_light_format(params->effects)) * samples, "ground without sun");
	add(plan, PLAN_BUFFER, PLAN_ONCE, EFFECT_SHADOW, gpu_list_bytes(params->object_count * sizeof(struct object_shadow)), "shadows: where they are");
	add(plan, PLAN_BUFFER, PLAN_ONCE, EFFECT_SHADOW, sizeof volume_sides, "shadows: a volume");
}

/* --- life --- */

static enum status make_shape(struct render *render, const struct soil_shape *shape, struct object_shape *out)
{
	struct object_mesh mesh;
	enum status status;
	TRY(render_object_mesh_make(shape, &mesh));
	*out = (struct object_shape){.shape = shape, .bound = soil_shape_bound(shape), .closed = mesh.closed};
	memcpy(out->first, mesh.first, sizeof out->first);
	TRY_OR(done, gpu_buffer_create(render->gpu, GPU_STORAGE, mesh.corner_count * sizeof *mesh.corners, mesh.corners, &out->corners));
	TRY_OR(done, gpu_buffer_create(render->gpu, GPU_INDICES, mesh.index_count * sizeof *mesh.indices, mesh.indices, &out->indices));
done:
	render_object_mesh_finish(&mesh);
	return status;
}

static enum status make_shapes(struct render *render, struct render_objects *objects)
{
	uint32_t shapes = 0;
	for (size_t i = 0; i < objects->count; i++) {
		size_t first;
		if (!is_first(objects->objects, i, &first)) {
			objects->shape_of[i] = objects->shape_of[first];
			continue;
		}
		objects->shape_of[i] = shapes;
		TRY(make_shape(render, &objects->objects[i].shape, &objects->shapes[shapes++]));
	}
	return STATUS_OK;
}

bool render_objects_are_cast(const struct render_params *params)
{
	return casts(params->effects, params->object_count);
}

bool render_objects_cast(const struct render_objects *objects)
{
	return objects != NULL && objects->casts;
}

static enum status make_shadows(struct render *render, struct render_objects *objects)
{
	struct gpu *gpu = render->gpu;
	TRY(mem_make(&objects->shadows, objects->count, sizeof *objects->shadows, "the picture's shadows"));
	TRY(gpu_list_create(gpu, objects->count * sizeof *objects->shadows, &objects->casters));
	return gpu_buffer_create(gpu, GPU_INDICES, sizeof volume_sides, volume_sides, &objects->volume);
}

enum status render_objects_create(struct render *render, const struct render_params *params)
{
	size_t count = params->object_count;
	if (!shows(params->effects, count))
		return STATUS_OK;
	struct render_objects *objects = mem_calloc(1, sizeof *objects);
	TRY_MEM(objects, "the picture's objects");
	render->objects = objects; /* from here on render_destroy frees it */
	objects->objects = params->objects;
	objects->count = count;
	objects->casts = casts(params->effects, count);
	objects->shapes = mem_calloc(count, sizeof *objects->shapes);
	objects->shape_of = mem_alloc(count, sizeof *objects->shape_of);
	objects->shown = mem_alloc(count, sizeof *objects->shown);
	objects->seen = mem_alloc(count, sizeof *objects->seen);
	objects->posed = mem_alloc(count, sizeof *objects->posed);
	if (objects->shapes == NULL || objects->shape_of == NULL || objects->shown == NULL || objects->seen == NULL ||
	    objects->posed == NULL)
		return fail_memory("the picture's objects");
	TRY(gpu_list_create(render->gpu, count * sizeof *objects->posed, &objects->instances));
	TRY(make_shapes(render, objects));
	return objects->casts ? make_shadows(render, objects) : STATUS_OK;
}

void render_objects_destroy(struct render_objects *objects)
{
	if (objects == NULL)
		return;
	for (size_t i = 0; objects->shapes != NULL && i < objects->count; i++) {
		gpu_buffer_destroy(objects->shapes[i].corners);
		gpu_buffer_destroy(objects->shapes[i].indices);
	}
	gpu_list_destroy(objects->instances);
	gpu_list_destroy(objects->casters);
	gpu_buffer_destroy(objects->volume);
	mem_free_all(objects->shapes, objects->shape_of, objects->shown, objects->seen, objects->posed, objects->shadows, objects);
}

bool render_shows_objects(const struct render *render)
{
	return render->objects != NULL;
}

void render_set_objects(struct render *render, const struct render_object *list, size_t count)
{
	struct render_objects *objects = render->objects;
	if (objects == NULL)
		return;
	assert(count <= objects->count);
	if (count > 0)
		memcpy(objects->shown, list, count * sizeof *list);
	objects->shown_count = count;
}

/* --- a picture --- */

static bool ball_visible(const struct render_view *view, const double eye[3], const double at[3], double radius)
{
	for (int p = 0; p < 5; p++) {
		const double *plane = view->planes[p];
		/* The eye is on all planes but the far one. */
		double beyond = plane[3];
		for (int k = 0; k < 3; k++)
			beyond += plane[k] * (at[k] + eye[k]);
		if (beyond < -radius)
			return false;
	}
	return true;
}

static int in_order(const void *a, const void *b)
{
	const struct object_seen *x = a, *y = b;
	if (x->shape != y->shape)
		return x->shape < y->shape ? -1 : 1;
	return (x->detail > y->detail) - (x->detail < y->detail);
}

/* Lists the objects in the picture, by shape and detail. Also lists the shadows in the picture: their objects may be outside. */
static void look(const struct render *render, const struct render_camera *camera, const struct render_axes *axes,
		 const struct render_view *view, const double sun[3], size_t *seen_count, size_t *shadow_count)
{
	struct render_objects *objects = render->objects;
	*seen_count = *shadow_count = 0;
	for (size_t i = 0; i < objects->shown_count; i++) {
		const struct render_object *object = &objects->shown[i];
		const struct object_shape *shape = &objects->shapes[objects->shape_of[object->object]];
		double at[3], own[3][3], middle[3], far, radius, pixels;
		for (int k = 0; k < 3; k++)
			at[k] = object->at[k] - camera->eye[k];
		if (object->posed)
			memcpy(own, object->axes, sizeof own);
		else
			soil_axes(object->yaw, object->pitch, object->roll, object->turned, own);
		if (objects->casts) {
			render_object_shadow_of(shape->shape, own, at, sun, &objects->shadows[*shadow_count], middle, &radius);
			*shadow_count += ball_visible(view, camera->eye, middle, radius);
		}
		if (!ball_visible(view, camera->eye, at, shape->bound))
			continue;
		struct object_seen *seen = &objects->seen[(*seen_count)++];
		far = sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
		pixels = far > shape->bound ? shape->bound / far * axes->focal : INFINITY;
		*seen = (struct object_seen){.shape = objects->shape_of[object->object], .posed = {.size = {(float)shape->bound, (float)object->number}}};
		if (object->painted)
			memcpy(seen->posed.paint, (const float[4]){object->colour[0], object->colour[1], object->colour[2], shape->shape->kind == SOIL_WHEEL ? 2 : 1}, sizeof seen->posed.paint);
		while (pixels < details_from[seen->detail])
			seen->detail++;
		while (shape->first[seen->detail] == shape->first[seen->detail + 1])
			seen->detail--;
		for (int a = 0; a < 3; a++) {
			for (int k = 0; k < 3; k++)
				seen->posed.axes[a][k] = (float)own[a][k];
			seen->posed.axes[a][3] = (float)at[a];
		}
	}
	qsort(objects->seen, *seen_count, sizeof *objects->seen, in_order);
}

static enum status draw_shadows(struct render *render, const struct picture_params *params, size_t count)
{
	struct render_objects *objects = render->objects;
	gpu_list_write(objects->casters, count * sizeof *objects->shadows, objects->shadows);
	struct gpu_pass pass = {
		.stage = GPU_SHADOW,
		.target = render->screen->over,
		.viewport = {0, 0, render->screen->width, render->screen->height},
		.textures = {render->screen->depth},
		.lists = {objects->casters},
		.only_reads = true,
		.params = params,
		.params_bytes = RENDER_PARAMS_BYTES,
		.indices = objects->volume,
		.index_count = sizeof volume_sides / sizeof *volume_sides,
		.instances = (uint32_t)count,
		.cull_front = true,
		.multiply = true,
	};
	struct gpu_pass umbra = {
		.stage = GPU_SHADOW,
		.target = render->screen->target,
		.viewport = pass.viewport,
		.textures = {render->screen->umbra},
		.only_reads = true,
		.fill = true,
	};
	const struct gpu_program_request request = umbra_of((int)render->screen->samples);
	render->tiles.shadowed = 1;
	TRY(program_of(render, true, &pass.program));
	TRY(gpu_program_get(render->gpu, &request, &umbra.program));
	gpu_pass_run(render->gpu, &pass);
	gpu_pass_run(render->gpu, &umbra);
	return STATUS_OK;
}

static void run_objects(struct render *render, const struct picture_params *params, struct gpu_program *program,
			const struct object_shape *shape, uint32_t first, uint32_t end, size_t count)
{
	gpu_pass_run(render->gpu, &(struct gpu_pass){
		.stage = GPU_OBJECTS,
		.program = program,
		.target = render->measuring ? render->screen->measure : render->screen->target,
		.viewport = {0, 0, render->screen->width, render->screen->height},
		.textures = {[6] = render->measuring ? NULL : render_shade_texture(render->shade)},
		.storage = {shape->corners},
		.lists = {[1] = render->objects->instances},
		.params = params,
		.params_bytes = RENDER_PARAMS_BYTES,
		.indices = shape->indices,
		.wide_indices = true,
		.first_index = first,
		.index_count = end - first,
		.instances = (uint32_t)count,
		.depth_test = true,
		.cull_back = shape->closed,
	});
}

/* Draws `count` seen objects from `first` on, which have one shape and one detail. */
static void draw_alike(struct render *render, struct picture_params *params, struct gpu_program *program, size_t first, size_t count)
{
	const struct object_seen *seen = &render->objects->seen[first];
	const struct object_shape *shape = &render->objects->shapes[seen->shape];
	uint32_t begin = shape->first[seen->detail], end = shape->first[seen->detail + 1];
	params->tile[1] = (int32_t)first;
	run_objects(render, params, program, shape, begin, end, count);
	render->tiles.objects++;
	render->triangles += (uint64_t)(end - begin) / 3 * count;
}

enum status render_objects_draw_unseen(struct render *render, const struct picture_params *params)
{
	struct render_objects *objects = render->objects;
	struct gpu_program *program;
	TRY(program_of(render, false, &program));
	run_objects(render, params, program, &objects->shapes[0], 0, 3, 1);
	if (objects->casts && !render->measuring) {
		objects->shadows[0] = (struct object_shadow){.kind = {0}};
		TRY(draw_shadows(render, params, 1));
	}
	return STATUS_OK;
}

enum status render_objects_draw(struct render *render, const struct render_camera *camera, const struct render_axes *axes,
				const struct render_view *view, struct picture_params *params)
{
	struct render_objects *objects = render->objects;
	const double sun[3] = {params->sun[0], params->sun[1], params->sun[2]};
	struct gpu_program *program;
	size_t seen, shadows;
	look(render, camera, axes, view, sun, &seen, &shadows);
	if (shadows > 0 && !render->measuring)
		TRY(draw_shadows(render, params, shadows));
	TRY(program_of(render, false, &program));
	if (seen == 0)
		return STATUS_OK;
	for (size_t i = 0; i < seen; i++)
		objects->posed[i] = objects->seen[i].posed;
	gpu_list_write(objects->instances, seen * sizeof *objects->posed, objects->posed);
	for (size_t i = 0, end; i < seen; i = end) {
		for (end = i + 1; end < seen && in_order(&objects->seen[i], &objects->seen[end]) == 0;)
			end++;
		draw_alike(render, params, program, i, end - i);
	}
	return STATUS_OK;
}
