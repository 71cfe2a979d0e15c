/* Tells for each pass which shader files and defines its program has. Tells also which programs an object can need. */
#include "deform/programs.h"

#include <assert.h>
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

static const char *const shapes[SOIL_SHAPES] = {"SHAPE_WHEEL", "SHAPE_SPHERE", "SHAPE_BOX", NULL, "SHAPE_CYLINDER", "SHAPE_CAPSULE", "SHAPE_ELLIPSOID"};

void deform_programs_envelope(const struct deform_params *params, enum soil_shape_kind kind, bool sideways, struct deform_request *out)
{
	bool brief = deform_envelope_is_brief(kind, sideways);
	begin(out, brief ? "passed.vert" : "full.vert", "deform/under.frag");
	define(out, "PASSED 14", brief);
	define(out, shapes[kind], true);
	define(out, "REST", deform_needs_contacts(params));
	define(out, "SIDEWAYS", sideways);
}

void deform_programs_facet(const struct deform_params *params, struct deform_request *out)
{
	begin(out, "deform/facet.vert", "deform/facet.frag");
	define(out, "REST", deform_needs_contacts(params));
}

void deform_programs_contact(const struct deform_params *params, struct deform_request *out)
{
	const struct soil_model *model = deform_model_row(params->model);
	begin(out, "full.vert", model->shader);
	define(out, "CONTACT", deform_needs_contacts(params));
	if (model->contact_soils)
		define_number(out, "SOILS", deform_soil_slots(params));
}

void deform_programs_box(const struct deform_params *params, struct deform_request *out)
{
	begin(out, "full.vert", "deform/box.frag");
	define_number(out, "RADIUS", params->box_radius);
}

void deform_programs_spread(const struct deform_params *params, enum spread_pass pass, struct deform_request *out)
{
	static const char *const files[SPREAD_PASSES] = {
		[SPREAD_MEASURE] = "deform/spread_measure.frag",
		[SPREAD_WEIGH] = "deform/spread_weigh.frag",
		[SPREAD_LAY] = "deform/spread_lay.frag",
	};
	begin(out, "full.vert", files[pass]);
	define_number(out, "SOILS", deform_soil_slots(params));
}

/* A pass of sliding. The vertex shader passes parameters on. `passed`: the define that says how many. Over a window all passes but the
 * last also compute the still posts around, since the next pass reads them. */
static void begin_passed(struct deform_request *out, enum deform_over over, const char *passed, const char *fragment)
{
	begin(out, over == OVER_BLOCKS ? "deform/regions.vert" : "deform/reached.vert", fragment);
	define(out, "BLOCKS", over == OVER_BLOCKS);
	define(out, passed, true);
}

void deform_programs_begin(const struct deform_params *params, enum deform_over over, struct deform_request *out)
{
	begin_passed(out, over, "PASSED 5", "deform/slide_begin.frag");
	define(out, "BOUNDED", deform_is_bounded(params));
	define(out, "STEEP", deform_is_steep(params));
	define(out, "HELD_STILL", deform_model_row(params->model)->slide->held_still);
}

void deform_programs_roof(enum roof_pass pass, struct deform_request *out)
{
	begin(out, "full.vert", pass == ROOF_NOTE ? "deform/roof.frag" : pass == ROOF_LIMIT ? "deform/roof_limit.frag" : "deform/roof_lines.frag");
	define(out, "OPENS", pass == ROOF_OPEN);
}

void deform_programs_slide(const struct deform_params *params, enum slide_what what, enum deform_over over, bool last, bool roofed,
		    struct deform_request *out)
{
	const bool blocks = over == OVER_BLOCKS;
	static const char *const files[] = {
		[SLIDE_EXCESS] = "deform/slide_excess.frag",
		[SLIDE_SHED] = "deform/slide_shed.frag",
		[SLIDE_TAKE] = "deform/slide_take.frag",
	};
	begin_passed(out, over, what == SLIDE_EXCESS ? "PASSED 6" : "PASSED 5", files[what]);
	define(out, "ROOFS", roofed);
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
		define(out, "TOUCHED", params->touched);
	}
}

void deform_programs_lines(const struct deform_params *params, bool diagonal, struct deform_request *out)
{
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
	define(out, "STOOD", hop == SLOPE_LAST && deform_asks_what_stood(params));
	define_number(out, "SOILS", deform_soil_slots(params));
}

void deform_programs_held(struct deform_request *out)
{
	begin(out, "full.vert", "deform/held.frag");
}

void deform_programs_disturbance(struct deform_request *out)
{
	begin(out, "full.vert", "deform/disturbance.frag");
}

void deform_programs_fixed(const struct deform_params *params, enum deform_fixed_pass pass, struct deform_request *out)
{
	const bool contact = pass <= FIXED_CONTACT_KEPT, box = pass == FIXED_BOX;
	begin(out, "full.vert", contact ? deform_model_row(params->model)->shader : box ? "deform/box.frag" : "deform/disturbance.frag");
	define(out, "REGION", true);
	define(out, "KEPT", pass == FIXED_CONTACT_KEPT);
	define(out, "CONTACT", contact && deform_needs_contacts(params));
	if (box)
		define_number(out, "RADIUS", params->box_radius);
}

void deform_programs_marks(const struct deform_params *params, struct deform_request *out)
{
	begin(out, "full.vert", "deform/marks.frag");
	define(out, "HEALS", params->heals > 0);
	define(out, "GROWS", params->rises > 0);
}

void deform_programs_sheet(enum sheet_pass pass, struct deform_request *out)
{
	static const char *const files[SHEET_PASSES] = {
		[SHEET_FREE] = "deform/sheet_free.frag",
		[SHEET_CONTACT] = "deform/sheet_contact.frag",
		[SHEET_MARK_ROWS] = "deform/sheet_rows.frag",
		[SHEET_MARK_COLUMNS] = "deform/sheet_columns.frag",
		[SHEET_BEND] = "deform/sheet_bend.frag",
		[SHEET_SET] = "deform/sheet_set.frag",
	};
	begin(out, "full.vert", files[pass]);
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
		deform_programs_envelope(each->params, shape->kind, false, &each->request);
		add(each, displace);
	}
	if (object->leans) {
		deform_programs_envelope(each->params, SOIL_CYLINDER, false, &each->request);
		add(each, displace);
	}
	if (shape->kind == SOIL_WHEEL && object->moves) {
		deform_programs_envelope(each->params, shape->kind, true, &each->request);
		add(each, displace);
	}
	if (shape->kind == SOIL_MESH || shape->grousers > 0) {
		deform_programs_facet(each->params, &each->request);
		add(each, shape->kind == SOIL_MESH ? "mesh" : "lugs");
	}
}

static void each_slide(struct each *each, enum deform_over over)
{
	const bool blocks = over == OVER_BLOCKS;
	const struct deform_params *params = each->params;
	const char *effect = deform_slide_effect(params->model);
	const struct soil_slide *slide = deform_model_row(params->model)->slide;
	const int last_pass = slide->pass_count - 1;
	deform_programs_begin(params, over, &each->request);
	add(each, effect);
	if (blocks && deform_has_slopes(params)) {
		deform_programs_steep(&each->request);
		add(each, effect);
	}
	for (int hop = 0; hop < SLOPE_HOPS && blocks && deform_has_slopes(params); hop++) {
		deform_programs_slope(params, (enum slope_hop)hop, &each->request);
		add(each, effect);
	}
	for (int diagonal = 0; diagonal < 2 && !blocks && deform_line_passes(params) > 0; diagonal++) {
		deform_programs_lines(params, diagonal, &each->request);
		add(each, effect);
	}
	for (int roofed = 0; roofed <= params->roofs; roofed++) {
		for (int pass = 0; pass < last_pass; pass++) {
			deform_programs_slide(params, slide->passes[pass], over, false, roofed, &each->request);
			add(each, effect);
		}
		for (int last = params->iterations == 1; last < 2; last++) {
			deform_programs_slide(params, slide->passes[last_pass], over, last, roofed, &each->request);
			add(each, effect);
		}
	}
}

static void each_roof(struct each *each)
{
	const bool lines = deform_line_passes(each->params) > 0;
	for (int pass = 0; pass < (lines ? ROOF_PASSES : ROOF_CLOSE) && each->params->roofs; pass++) {
		deform_programs_roof((enum roof_pass)pass, &each->request);
		add(each, deform_slide_effect(each->params->model));
	}
}

static void each_fixed(struct each *each, const struct deform_planned *object)
{
	const struct deform_params *params = each->params;
	const char *displace = deform_displace_effect(params->model), *model = deform_model_row(params->model)->effect.name;
	const int times = deform_model_row(params->model)->smooths && object->moves ? params->box_repetitions : 0;
	const struct {
		enum deform_fixed_pass pass;
		bool wanted;
		const char *effect;
	} passes[] = {
		{FIXED_CONTACT, true, displace},
		{FIXED_CONTACT_KEPT, times > 0, displace},
		{FIXED_BOX, times > 0, model},
		{FIXED_DISTURBANCE, params->disturbance, "dirt"},
	};
	for (size_t i = 0; i < sizeof passes / sizeof *passes && params->fixed; i++)
		if (passes[i].wanted) {
			deform_programs_fixed(params, passes[i].pass, &each->request);
			add(each, passes[i].effect);
		}
}

static void each_batch(struct each *each, const struct deform_planned *object)
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
	for (size_t i = 0; i < sizeof passes / sizeof *passes; i++)
		if (passes[i].wanted) {
			deform_programs_batch(params, passes[i].pass, &each->request);
			add(each, passes[i].effect);
		}
}

void deform_programs_each(const struct deform_params *params, const struct deform_planned *object, programs_fn fn, void *user)
{
	struct each each = {.params = params, .each = fn, .user = user};
	each_envelope(&each, object);
	for (int pass = 0; pass < SHEET_PASSES && deform_is_elastic(params->model); pass++) {
		deform_programs_sheet((enum sheet_pass)pass, &each.request);
		add(&each, deform_displace_effect(params->model));
	}
	if (!deform_is_elastic(params->model)) {
		deform_programs_contact(params, &each.request);
		add(&each, deform_displace_effect(params->model));
	}
	if (deform_model_row(params->model)->smooths && object->moves) {
		deform_programs_box(params, &each.request);
		add(&each, deform_model_row(params->model)->effect.name);
	}
	if (deform_conserves(params->model)) {
		for (int pass = 0; pass < SPREAD_PASSES; pass++) {
			deform_programs_spread(params, (enum spread_pass)pass, &each.request);
			add(&each, "spread");
		}
		each_slide(&each, OVER_WINDOW);
		each_slide(&each, OVER_BLOCKS);
		each_roof(&each);
		deform_programs_held(&each.request);
		add(&each, deform_slide_effect(params->model));
	}
	if (params->disturbance) {
		deform_programs_disturbance(&each.request);
		add(&each, "dirt");
	}
	if (deform_marks(params) != 0) {
		deform_programs_marks(params, &each.request);
		add(&each, deform_marks_effect(params));
	}
	each_fixed(&each, object);
	each_batch(&each, object);
}
