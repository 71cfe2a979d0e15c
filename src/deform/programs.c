/* Tells for each pass which shader files and defines its program has. Tells also which programs an object can need. */
#include "deform/programs.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "deform/internal.h"

static void begin(struct deform_request *out, const char *vertex, const char *fragment)
{
	*out = (struct deform_request){.gl = {.vertex = vertex, .fragment = fragment}};
}

/* Adds a define if it is wanted. */
static void define(struct deform_request *out, const char *name, bool wanted)
{
	size_t count = 0;
	while (out->gl.defines[count] != NULL)
		count++;
	assert(count + 1 < GPU_DEFINES_MAX);
	if (wanted)
		out->gl.defines[count] = name;
}

static void define_number(struct deform_request *out, const char *name, int number)
{
	assert(strlen(name) + sizeof " 2147483647" <= sizeof out->own);
	snprintf(out->own, sizeof out->own, "%s %d", name, number);
	define(out, out->own, true);
}

/* Which numbers of the soil come from rasters: lib/soil.glsl. */
static void define_rasters(const struct deform_params *params, struct deform_request *out)
{
	int which = 0;
	if (!deform_has_rasters(params))
		return;
	for (int i = 0; i < params->raster_count; i++)
		which |= (1 + (int)params->rasters[i].number) << 3 * i;
	define_number(out, "SOIL_RASTERS", which);
}
static const char *const shapes[SOIL_SHAPES] = {"SHAPE_WHEEL", "SHAPE_SPHERE", "SHAPE_BOX", NULL, "SHAPE_CYLINDER", "SHAPE_CAPSULE", "SHAPE_ELLIPSOID"};

static bool has_thickness(const struct deform_params *params)
{
	return (deform_planes(params->model, params->disturbance, params->slip_sinkage > 0) & PLANE_BIT(PLANE_DEPOSITED)) != 0;
}

/* A pass over all windows of a batch. `passed`: the define that says how many numbers the vertex shader passes on. */
static void begin_batch(struct deform_request *out, const char *passed, bool rows, bool reached, const char *fragment)
{
	begin(out, "deform/windows.vert", fragment);
	define(out, "BATCH", true);
	define(out, passed, true);
	define(out, "ROWS", rows);
	define(out, "REACHED", reached);
}

void deform_programs_envelope(const struct deform_params *params, enum soil_shape_kind kind, bool sideways, bool batch,
			struct deform_request *out)
{
	bool brief = deform_envelope_is_brief(kind, sideways);
	if (batch) {
		begin_batch(out, brief ? "PASSED 14" : "PASSED 18", false, false, "deform/under.frag");
	} else {
		begin(out, brief ? "passed.vert" : "full.vert", "deform/under.frag");
		define(out, "PASSED 14", brief);
	}
	define(out, shapes[kind], true);
	define(out, "REST", deform_needs_contacts(params));
	define(out, "SIDEWAYS", sideways);
}

void deform_programs_facet(const struct deform_params *params, struct deform_request *out)
{
	begin(out, "deform/facet.vert", "deform/facet.frag");
	define(out, "REST", deform_needs_contacts(params));
}

void deform_programs_contact(const struct deform_params *params, unsigned with, bool batch, struct deform_request *out)
{
	const struct soil_model *model = deform_model_row(params->model);
	if (batch)
		begin_batch(out, "PASSED 22", true, false, model->shader);
	else
		begin(out, "full.vert", model->shader);
	define(out, "FORCES", with & WITH_FORCES);
	define(out, "PATCH", with & WITH_PATCH);
	define(out, "LOAD", with & WITH_LOAD);
	define(out, "BELT", with & WITH_BELT);
	if (model->in_place)
		define(out, shapes[with / WITH_SHAPE], shapes[with / WITH_SHAPE] != NULL);
	define(out, "SOIL_MAP", model->in_place && deform_has_classes(params));
	define(out, "SLIP", model->in_place && params->slip_sinkage > 0);
	define(out, "GROUND_NORMALS", model->in_place && params->ground_normals);
	define_rasters(params, out);
	define(out, "CONTACT", !model->in_place && deform_needs_contacts(params));
	if (model->contact_soils)
		define_number(out, "SOILS", deform_soil_slots(params));
}

void deform_programs_find(const struct deform_params *params, unsigned what, enum soil_shape_kind kind, bool batch, struct deform_request *out)
{
	*out = (struct deform_request){.gl = {.compute = "deform/scm_find.comp"}};
	define(out, "BATCH", batch);
	define(out, "PATCH", what & FIND_PATCH);
	define(out, "LOAD", what & FIND_LOAD);
	define(out, "BELT", what & FIND_BELT);
	define(out, shapes[kind], shapes[kind] != NULL);
	define(out, "SOIL_MAP", (what & FIND_LOAD) && deform_has_classes(params));
	define(out, "SLIP", (what & FIND_LOAD) && params->slip_sinkage > 0);
	define(out, "GROUND_NORMALS", (what & FIND_LOAD) && params->ground_normals);
	if (what & FIND_LOAD)
		define_rasters(params, out);
}

void deform_programs_box(const struct deform_params *params, struct deform_request *out)
{
	begin(out, "full.vert", "deform/box.frag");
	define_number(out, "RADIUS", params->box_radius);
}

enum spread_pass deform_spread_first(enum deform_model model)
{
	return deform_model_row(model)->measures ? SPREAD_WEIGH : SPREAD_MEASURE;
}

void deform_programs_spread(const struct deform_params *params, enum spread_pass pass, bool batch, struct deform_request *out)
{
	static const char *const files[SPREAD_PASSES] = {
		[SPREAD_MEASURE] = "deform/spread_measure.frag",
		[SPREAD_WEIGH] = "deform/spread_weigh.frag",
		[SPREAD_LAY] = "deform/spread_lay.frag",
	};
	if (batch)
		begin_batch(out, "PASSED 7", true, false, files[pass]);
	else
		begin(out, "full.vert", files[pass]);
	define_number(out, "SOILS", deform_soil_slots(params));
}

/* A pass of sliding. The vertex shader passes parameters on. `passed`: the define that says how many. Over a window all passes but the
 * last also compute the still posts around, since the next pass reads them. */
static void begin_passed(struct deform_request *out, enum deform_over over, const char *passed, const char *fragment)
{
	if (over == OVER_BATCH) {
		begin_batch(out, passed, false, true, fragment);
		return;
	}
	begin(out, over == OVER_BLOCKS ? "deform/regions.vert" : "deform/reached.vert", fragment);
	define(out, "BLOCKS", over == OVER_BLOCKS);
	define(out, passed, true);
}

void deform_programs_begin(const struct deform_params *params, enum deform_over over, bool loaded, struct deform_request *out)
{
	begin_passed(out, over, "PASSED 5", "deform/slide_begin.frag");
	define(out, "LOAD", over == OVER_WINDOW && loaded);
	define(out, "THICKNESS", has_thickness(params));
	define(out, "BOUNDED", deform_is_bounded(params));
	define(out, "STEEP", deform_is_steep(params));
	define(out, "HELD_STILL", deform_model_row(params->model)->slide->held_still);
}

void deform_programs_slide(const struct deform_params *params, enum slide_what what, enum deform_over over, bool last,
		    struct deform_request *out)
{
	const bool blocks = over == OVER_BLOCKS;
	static const char *const files[] = {
		[SLIDE_EXCESS] = "deform/slide_excess.frag",
		[SLIDE_SHED] = "deform/slide_shed.frag",
		[SLIDE_TAKE] = "deform/slide_take.frag",
	};
	begin_passed(out, over, what == SLIDE_EXCESS ? "PASSED 6" : "PASSED 5", files[what]);
	define(out, "BY_CELLS", what == SLIDE_EXCESS && blocks && last && deform_has_slopes(params));
	define(out, "OF_BLOCKS", what == SLIDE_EXCESS && blocks && last && deform_has_slopes(params));
	if (what != SLIDE_TAKE) {
		define_number(out, "SOILS", deform_soil_slots(params));
		define(out, "BOUNDED", what == SLIDE_EXCESS && deform_is_bounded(params));
		define(out, "STOOD", deform_asks_what_stood(params));
	}
	define(out, "SLOPES", what == SLIDE_EXCESS && blocks && deform_has_slopes(params));
	if (what != SLIDE_SHED && last) {
		define(out, "LAST", true);
		define(out, "WAKES", what == SLIDE_EXCESS && deform_has_slopes(params));
		define(out, "THICKNESS", has_thickness(params));
		define(out, "TOUCHED", params->touched);
	}
}

void deform_programs_lines(const struct deform_params *params, bool diagonal, bool batch, struct deform_request *out)
{
	if (batch)
		begin_batch(out, "PASSED 3", true, true, "deform/slide_lines.frag");
	else
		begin(out, "full.vert", "deform/slide_lines.frag");
	define(out, "DIAGONAL", diagonal);
	define_number(out, "SOILS", deform_soil_slots(params));
	define(out, "BOUNDED", deform_is_bounded(params));
	define(out, "STOOD", deform_asks_what_stood(params));
}

void deform_programs_steep(struct deform_request *out)
{
	begin_passed(out, OVER_BLOCKS, "PASSED 2", "deform/steep.frag");
}

void deform_programs_slope(const struct deform_params *params, enum slope_hop hop, struct deform_request *out)
{
	begin_passed(out, OVER_BLOCKS, "PASSED 2", "deform/slope.frag");
	define(out, "BY_CELLS", true);
	define(out, "FIRST", hop == SLOPE_FIRST);
	define(out, "LAST", hop == SLOPE_LAST);
	define_number(out, "SOILS", deform_soil_slots(params));
}

void deform_programs_held(bool loaded, struct deform_request *out)
{
	begin(out, "full.vert", "deform/held.frag");
	define(out, "LOAD", loaded);
}

void deform_programs_disturbance(struct deform_request *out)
{
	begin(out, "full.vert", "deform/disturbance.frag");
}

void deform_programs_batch(const struct deform_params *params, enum deform_batch_pass pass, struct deform_request *out)
{
	static const struct {
		const char *passed, *shape, *fragment;
	} passes[] = {
		[BATCH_WHEELS] = {"PASSED 19", "SHAPE_WHEEL", NULL},
		[BATCH_SIDEWAYS_WHEELS] = {"PASSED 23", "SHAPE_WHEEL", NULL},
		[BATCH_SPHERES] = {"PASSED 19", "SHAPE_SPHERE", NULL},
		[BATCH_OTHERS] = {"PASSED 5", NULL, NULL},
		[BATCH_GATHER] = {"PASSED 2", NULL, "deform/gather.frag"},
		[BATCH_BOX] = {"PASSED 3", NULL, "deform/box.frag"},
		[BATCH_BOX_STORE] = {"PASSED 3", NULL, "deform/box.frag"},
		[BATCH_STORE] = {"PASSED 2", NULL, "deform/store.frag"},
		[BATCH_DISTURBANCE] = {"PASSED 2", NULL, "deform/disturbance.frag"},
	};
	_Static_assert(DEFORM_BATCH_RECORD == 25 && GPU_PASSED_MOST == 23, "RECORD, PASSED");
	const bool contact = pass <= BATCH_OTHERS, box = pass == BATCH_BOX || pass == BATCH_BOX_STORE;
	begin(out, "deform/batch.vert", contact ? deform_model_row(params->model)->shader : passes[pass].fragment);
	define(out, passes[pass].passed, true);
	define(out, "RECORD 25", true);
	define(out, "HULL", pass != BATCH_GATHER && pass != BATCH_BOX);
	define(out, "BATCH", contact || box || pass == BATCH_DISTURBANCE);
	define(out, "STORE", pass == BATCH_BOX_STORE);
	define(out, "WITH_ENVELOPE", passes[pass].shape != NULL);
	define(out, passes[pass].shape, passes[pass].shape != NULL);
	define(out, "SIDEWAYS", pass == BATCH_SIDEWAYS_WHEELS);
	define(out, "CONTACT", (contact || pass == BATCH_GATHER) && deform_needs_contacts(params));
	if (box)
		define_number(out, "RADIUS", params->box_radius);
}

/* --- programs that an object can need --- */

/* Returns true if every contact of the object fits one window, wherever it is. */
static bool always_fits(const struct deform_params *params, const struct soil_shape *shape)
{
	if (params->extent == NULL)
		return true;
	/* Two path samples are one post apart, at corners more, and places are rounded. */
	double across = 2 * soil_shape_bound(shape) / extent_spacing(params->extent, params->level) + 2 * M_SQRT2 + 4;
	return across + 2 * (double)deform_reach(params) <= (double)deform_core(params);
}

bool deform_is_counted(const struct deform_params *params, const struct soil_shape *shape, bool loaded)
{
	bool round = shape->kind != SOIL_WHEEL && shape->kind != SOIL_BOX && shape->kind != SOIL_CYLINDER;
	/* A loaded object too large for one window is refused, so a loaded one always fits. */
	return deform_tells_forces(params->model) && round && (loaded || always_fits(params, shape));
}

struct each {
	const struct deform_params *params;
	programs_fn each;
	void *user;
	struct deform_request request;
};

static void add(struct each *each, const char *effect)
{
	each->each(each->user, effect, &each->request.gl);
}

static void each_envelope(struct each *each, const struct deform_planned *object)
{
	const struct soil_shape *shape = object->shape;
	const char *displace = deform_displace_effect(each->params->model);
	if (shape->kind != SOIL_MESH) {
		deform_programs_envelope(each->params, shape->kind, false, false, &each->request);
		add(each, displace);
	}
	if (object->leans) {
		deform_programs_envelope(each->params, SOIL_CYLINDER, false, false, &each->request);
		add(each, displace);
	}
	if (shape->kind == SOIL_WHEEL && object->moves) {
		deform_programs_envelope(each->params, shape->kind, true, false, &each->request);
		add(each, displace);
	}
	if (shape->kind == SOIL_MESH || shape->grousers > 0) {
		deform_programs_facet(each->params, &each->request);
		add(each, shape->kind == SOIL_MESH ? "mesh" : "lugs");
	}
}

static void each_find(struct each *each, unsigned with, enum soil_shape_kind kind, bool batch)
{
	const bool load = with & WITH_LOAD;
	if (!(with & (WITH_PATCH | WITH_LOAD)))
		return;
	deform_programs_find(each->params, with / WITH_PATCH % FIND_SHAPE, kind, batch, &each->request);
	add(each, load ? "load" : deform_displace_effect(each->params->model));
}

/* The contact passes of a model that tells forces. */
static void each_felt(struct each *each, const struct deform_planned *object, bool forces, bool batch)
{
	bool load = object->load > 0, patch = deform_is_counted(each->params, object->shape, load);
	for (int leans = 0; leans <= object->leans; leans++) {
		const enum soil_shape_kind form = leans ? SOIL_CYLINDER : object->shape->kind;
		unsigned with = (patch ? WITH_PATCH : 0) | (load ? WITH_LOAD : 0) | (object->shape->belt ? WITH_BELT : 0) | WITH_SHAPE * (unsigned)form;
		each_find(each, with, form, batch);
		deform_programs_contact(each->params, with, batch, &each->request);
		add(each, load ? "load" : deform_displace_effect(each->params->model));
		if (forces || load) {
			deform_programs_contact(each->params, with | WITH_FORCES, batch, &each->request);
			add(each, "forces");
		}
	}
}

static void each_slide(struct each *each, enum deform_over over, bool loaded)
{
	const bool blocks = over == OVER_BLOCKS;
	const struct deform_params *params = each->params;
	const char *effect = deform_slide_effect(params->model);
	const struct soil_slide *slide = deform_model_row(params->model)->slide;
	const int last_pass = slide->pass_count - 1;
	deform_programs_begin(params, over, loaded, &each->request);
	add(each, !blocks && loaded ? "load" : effect);
	if (blocks && deform_has_slopes(params)) {
		deform_programs_steep(&each->request);
		add(each, effect);
	}
	for (int hop = 0; hop < SLOPE_HOPS && blocks && deform_has_slopes(params); hop++) {
		deform_programs_slope(params, (enum slope_hop)hop, &each->request);
		add(each, effect);
	}
	for (int diagonal = 0; diagonal < 2 && !blocks && deform_line_passes(params) > 0; diagonal++) {
		deform_programs_lines(params, diagonal, over == OVER_BATCH, &each->request);
		add(each, effect);
	}
	for (int pass = 0; pass < last_pass; pass++) {
		deform_programs_slide(params, slide->passes[pass], over, false, &each->request);
		add(each, effect);
	}
	for (int last = params->iterations == 1; last < 2; last++) {
		deform_programs_slide(params, slide->passes[last_pass], over, last, &each->request);
		add(each, effect);
	}
}

/* The programs of a batch under a model that conserves soil (together.c). */
static void each_together(struct each *each, const struct deform_planned *object, bool forces)
{
	const struct deform_params *params = each->params;
	const char *displace = deform_displace_effect(params->model);
	const enum soil_shape_kind kind = object->shape->kind;
	for (int sideways = 0; sideways < 2; sideways++)
		if ((kind == SOIL_WHEEL && (!sideways || object->moves)) || (kind == SOIL_SPHERE && !sideways)) {
			deform_programs_envelope(params, kind, sideways, true, &each->request);
			add(each, displace);
		}
	each_felt(each, object, forces, true);
	for (int pass = deform_spread_first(params->model); pass < SPREAD_PASSES; pass++) {
		deform_programs_spread(params, (enum spread_pass)pass, true, &each->request);
		add(each, "spread");
	}
	each_slide(each, OVER_BATCH, false);
}

static void each_batch(struct each *each, const struct deform_planned *object, bool forces)
{
	const struct deform_params *params = each->params;
	const char *displace = deform_displace_effect(params->model);
	const enum soil_shape_kind kind = object->shape->kind;
	const bool smooths = deform_model_row(params->model)->smooths;
	const struct {
		enum deform_batch_pass pass;
		bool wanted;
		const char *effect;
	} passes[] = {
		{BATCH_WHEELS, kind == SOIL_WHEEL, displace},
		{BATCH_SIDEWAYS_WHEELS, kind == SOIL_WHEEL && object->moves, displace},
		{BATCH_SPHERES, kind == SOIL_SPHERE, displace},
		{BATCH_OTHERS, (kind != SOIL_WHEEL && kind != SOIL_SPHERE) || object->leans, displace},
		{BATCH_GATHER, true, displace},
		{BATCH_BOX, smooths && params->box_repetitions > 1, deform_model_row(params->model)->effect.name},
		{BATCH_BOX_STORE, smooths, deform_model_row(params->model)->effect.name},
		{BATCH_STORE, !smooths, displace},
		{BATCH_DISTURBANCE, params->disturbance, "dirt"},
	};
	if (!deform_batches(params, object))
		return;
	if (deform_conserves(params->model)) {
		each_together(each, object, forces);
		return;
	}
	for (size_t i = 0; i < sizeof passes / sizeof *passes; i++)
		if (passes[i].wanted) {
			deform_programs_batch(params, passes[i].pass, &each->request);
			add(each, passes[i].effect);
		}
}

void deform_programs_each(const struct deform_params *params, const struct deform_planned *object, bool forces, programs_fn fn,
		   void *user)
{
	struct each each = {.params = params, .each = fn, .user = user};
	bool loaded = deform_tells_forces(params->model) && object->load > 0;
	each_envelope(&each, object);
	if (deform_tells_forces(params->model)) {
		each_felt(&each, object, forces, false);
	} else {
		deform_programs_contact(params, 0, false, &each.request);
		add(&each, deform_displace_effect(params->model));
	}
	if (deform_model_row(params->model)->smooths && object->moves) {
		deform_programs_box(params, &each.request);
		add(&each, deform_model_row(params->model)->effect.name);
	}
	if (deform_conserves(params->model)) {
		for (int pass = deform_spread_first(params->model); pass < SPREAD_PASSES; pass++) {
			deform_programs_spread(params, (enum spread_pass)pass, false, &each.request);
			add(&each, "spread");
		}
		each_slide(&each, OVER_WINDOW, loaded);
		each_slide(&each, OVER_BLOCKS, false);
		deform_programs_held(loaded && params->loaded_bodies > 0, &each.request);
		add(&each, loaded && params->loaded_bodies > 0 ? "load" : deform_slide_effect(params->model));
	}
	if (params->disturbance) {
		deform_programs_disturbance(&each.request);
		add(&each, "dirt");
	}
	each_batch(&each, object, forces);
}
