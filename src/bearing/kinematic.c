/*
 * A contact of a kinematic model: from the tiles into a window, the lower envelope into the ground, and back. All of the body is one window, however
 * large. What the GPU computes in several windows has the same bits.
 */
#include <math.h>
#include <string.h>

#include "bearing/internal.h"

static struct soil_kinematic_contact contact_of(const struct deform_contact *contact)
{
	return (struct soil_kinematic_contact){.shape = contact->shape, .from = contact->from, .to = contact->to, .turned = contact->turned};
}

/* Returns the posts that the body may be above. */
static struct post_rect shadow_of(const struct bearing *bearing, const struct deform_contact *contact)
{
	const struct soil_pose *from = deform_is_contact_only(contact) ? &contact->to : &contact->from;
	return soil_shadow(contact->shape, from, &contact->to, bearing->law.spacing);
}

void bearing_mark(struct bearing *bearing, const struct deform_contact *contact, struct post_rect posts)
{
	if (deform_marks(&bearing->params) == 0)
		return;
	const struct soil_mark mark = deform_mark_of(&bearing->params, contact);
	soil_kinematic_mark(&bearing->window.planes, &bearing->window.marks, posts, &mark);
}

enum status bearing_kinematic_begin(struct bearing *bearing, const struct deform_contact *contact, const struct bearing_area *area)
{
	const struct soil_kinematic_contact own = contact_of(contact);
	const struct post_rect read = area->read, world = bearing->world;
	const size_t width = (size_t)(read.x1 - read.x0), height = (size_t)(read.y1 - read.y0);
	TRY(bearing_window_need(bearing, read));
	TRY(bearing_scratch_need(bearing, bearing->elastic ? soil_sheet_room(contact->shape, width, height, contact->load > 0) : soil_kinematic_room(&bearing->kinematic, &own, width, height)));
	if (read.x0 < world.x0 || read.y0 < world.y0 || read.x1 > world.x1 || read.y1 > world.y1)
		bearing_window_clear(bearing);
	return STATUS_OK;
}

void bearing_kinematic_gather(struct bearing *bearing, const struct tile_slot *held, size_t count)
{
	bearing_window_gather(bearing, held, count, false, false);
}

/* Returns a rectangle around the posts of a part of the window whose contact has one of these bits; empty: none has. */
static struct post_rect posts_with(const struct soil_planes *planes, struct post_rect part, uint8_t bits)
{
	struct post_rect found = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN};
	const int64_t width = part.x1 - part.x0;
	for (int64_t y = part.y0; y < part.y1; y++) {
		const uint8_t *row = planes->contact + (size_t)(y - planes->rect.y0) * planes->width + (size_t)(part.x0 - planes->rect.x0);
		int64_t first = 0, last = width - 1;
		while (first < width && (row[first] & bits) == 0)
			first++;
		while (last > first && (row[last] & bits) == 0)
			last--;
		if (first < width)
			found = post_rect_around(found, (struct post_rect){part.x0 + first, y, part.x0 + last + 1, y + 1});
	}
	return found.x0 < found.x1 ? found : (struct post_rect){part.x0, part.y0, part.x0, part.y0};
}

/* Adds up what the contact displaced. */
static struct soil_measured measure(const struct bearing *bearing, const struct soil_laying *laying, struct post_rect below)
{
	const struct bearing_window *window = &bearing->window;
	const struct soil_planes *planes = &window->planes;
	struct soil_measured measured;
	soil_measured_begin(&measured);
	for (int64_t y = below.y0; y < below.y1 && below.x0 < below.x1; y++) {
		const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(below.x0 - planes->rect.x0);
		const struct soil_row row = {
			.x = below.x0, .y = y, .count = (int)(below.x1 - below.x0), .contact = planes->contact + at, .carried = window->carried + at,
			.offset = planes->offset + at, .classes = planes->classes != NULL ? planes->classes + at : NULL,
		};
		soil_measure_row(&measured, laying, bearing->laid, &row);
	}
	return measured;
}

/* Finds the roofs of bodies beside the contact. Returns the posts that the contact touched, as soil_lay reads them: what others hold is none of it. */
static enum status find_roofs(struct bearing *bearing, const struct deform_contact *contact, const uint8_t **patch)
{
	bearing_roofs_clear(bearing);
	*patch = bearing->window.planes.contact;
	if (contact->rest_count == 0)
		return STATUS_OK;
	TRY(bearing_roofs_keep_touched(bearing, patch));
	return bearing_hold(bearing, contact->rests, contact->rest_count);
}

/* Lays what the contact displaced, and lets soil slide. Gives the posts that may have changed. below: posts below the body. */
static enum status redistribute(struct bearing *bearing, const struct deform_contact *contact, const struct bearing_area *area, struct post_rect below,
				struct post_rect *changed)
{
	struct bearing_window *window = &bearing->window;
	const struct soil_planes *planes = &window->planes;
	const struct soil_laying laying = soil_laying_of(contact->shape, &contact->from, &contact->to, contact->turned, contact->rotated, bearing->law.spacing);
	const struct soil_measured measured = measure(bearing, &laying, below);
	const bool carries = measured.carried > 0, near = deform_slides_near(contact, bearing->law.spacing);
	struct post_rect reached = posts_with(planes, below, (uint8_t)~SOIL_NO_GROUND);
	struct soil_lay_result laid = {.compacted = 0};
	struct soil_slid slid = {0};
	struct soil_roofs roofs;
	const uint8_t *patch;
	TRY(find_roofs(bearing, contact, &patch));
	if (carries) {
		memset(window->deposits, 0, planes->width * (size_t)(planes->rect.y1 - planes->rect.y0) * sizeof *window->deposits);
		bearing_roofs_close(bearing);
		soil_lay(&laying, &measured, bearing->laid, planes, patch, NULL, area->write, window->scratch, window->deposits, &laid);
		bearing_roofs_open(bearing);
		laid.compacted += bearing_roofs_limit(bearing, laid.posts);
		reached = post_rect_joined(reached, laid.posts);
	}
	const struct soil_slide_window slide = {
		.written = area->write, .posts = near ? soil_slide_posts(area->write, reached, bearing->around) : area->write, .world = bearing->world,
		.deposits = carries ? window->deposits : NULL, .loaded = window->roofed,
	};
	soil_slide_window_below(&bearing->rule, planes, &slide, bearing_roofs(bearing, &roofs), window->scratch, window->words, &slid);
	bearing->tally.compacted += laid.compacted + (int64_t)slid.compacted;
	bearing->tally.refused += laid.refused + slid.refused;
	bearing->tally.confined += laid.confined;
	*changed = post_rect_intersect(area->write, post_rect_joined(reached, slide.posts));
	return STATUS_OK;
}

static enum status wake(struct bearing *bearing, struct post_rect write, bool alone)
{
	if (!alone || !bearing->held_is_stable)
		return bearing_wake(bearing, write);
	return soil_active_add_words(&bearing->active, bearing->world, soil_slide_blocks(write), bearing->window.words);
}

/* Finds how deep a sheet bears a body with a load, and puts it there. */
static void stand(struct bearing *bearing, const struct deform_contact *contact, struct soil_sheet_contact *own, struct deform_forces *told)
{
	struct bearing_window *window = &bearing->window;
	const struct soil_sheet_rest found = soil_sheet_rest(&bearing->sheet, &bearing->kinematic, own, contact->load, bearing->params.tension, &window->planes, window->scratch);
	own->body.to.z = found.z;
	if (contact->loaded_body > 0)
		bearing->standing[contact->loaded_body - 1] = (int32_t)(found.z - contact->to.z);
	bearing->tally.sunk += found.sunk;
	*told = (struct deform_forces){
		.force = {0, 0, found.sunk || found.posts == 0 ? 0 : contact->load}, .sinkage = ldexp((double)found.sinkage, -OFFSET_BITS),
		.area = (double)found.posts * bearing->law.spacing * bearing->law.spacing, .z = found.z,
		.state = found.sunk ? DEFORM_SUNK : found.posts > 0 ? DEFORM_TOUCHING : DEFORM_AIR,
	};
}

/* A contact with the sheet. below: posts below the body. told: NULL, or for a body with a load: where it rests. */
static void run_sheet(struct bearing *bearing, const struct deform_contact *contact, struct post_rect below, struct deform_forces *told, struct post_rect *changed)
{
	struct bearing_window *window = &bearing->window;
	struct soil_sheet_contact own = {.body = contact_of(contact), .leaves = contact->leaves};
	if (contact->loaded_body > 0) { /* its path is that of a body which nothing raises */
		own.body.from.z += bearing->standing[contact->loaded_body - 1];
		own.body.to.z += bearing->standing[contact->loaded_body - 1];
	}
	if (told != NULL)
		stand(bearing, contact, &own, told);
	const bool marks = bearing->params.disturbance || deform_marks(&bearing->params) != 0;
	struct soil_kinematic_tally tally = {.compacted = 0};
	soil_sheet_run(&bearing->sheet, &bearing->kinematic, &own, &window->planes, window->scratch, &tally, changed);
	bearing->tally.compacted += tally.compacted;
	bearing->tally.refused += tally.refused;
	/* What the body touches is marked, even where it lies as before. */
	const struct post_rect touched = contact->leaves || !marks ? (struct post_rect){0, 0, 0, 0} : posts_with(&window->planes, below, SOIL_LOWERED);
	if (post_rect_empty(touched))
		return;
	if (bearing->params.disturbance)
		soil_kinematic_disturb(&window->planes, touched);
	bearing_mark(bearing, contact, touched);
	*changed = post_rect_joined(*changed, touched);
}

void bearing_kinematic_leave(struct bearing *bearing, const struct deform_contact *contact, struct post_rect *changed)
{
	run_sheet(bearing, contact, (struct post_rect){0, 0, 0, 0}, NULL, changed);
}

enum status bearing_kinematic_run(struct bearing *bearing, const struct deform_contact *contact, const struct bearing_area *area, bool alone,
				  struct deform_forces *told, struct post_rect *changed)
{
	struct bearing_window *window = &bearing->window;
	const struct soil_kinematic_contact own = contact_of(contact);
	const struct post_rect shadow = shadow_of(bearing, contact), below = post_rect_intersect(shadow, area->write);
	struct soil_kinematic_tally tally = {.compacted = 0};
	bearing->contacts++;
	if (bearing->elastic) {
		run_sheet(bearing, contact, below, contact->load > 0 ? told : NULL, changed);
		return STATUS_OK;
	}
	soil_kinematic_run(&bearing->kinematic, &own, &window->planes, area->write, window->carried, window->scratch, &tally);
	bearing->tally.compacted += tally.compacted;
	bearing->tally.refused += tally.refused;
	if (!bearing->conserves) {
		bearing_mark(bearing, contact, post_rect_intersect(shadow, window->planes.rect));
		/* Where the body lowered no post, it left none, and nothing is smoothed. */
		const struct post_rect lowered = posts_with(&window->planes, post_rect_intersect(shadow, area->read), SOIL_LOWERED);
		*changed = post_rect_empty(lowered) ? lowered : post_rect_intersect(area->write, post_rect_grown(lowered, bearing->kinematic.radius));
		return STATUS_OK;
	}
	TRY(redistribute(bearing, contact, area, below, changed));
	if (bearing->params.disturbance)
		soil_kinematic_disturb(&window->planes, below);
	bearing_mark(bearing, contact, below);
	return wake(bearing, area->write, alone);
}

enum status bearing_kinematic_scatter(struct bearing *bearing, struct post_rect changed, const struct tile_slot *held, size_t count)
{
	const unsigned planes = bearing->planes & ~PLANE_BIT(PLANE_SLOPE); /* intervals alone read and change that */
	for (size_t i = 0; i < count; i++)
		if (!post_rect_empty(post_rect_intersect(tile_post_rect(bearing->params.extent, held[i].tile), changed)))
			TRY(resident_host_write(bearing->slots, held[i].slot, planes));
	resident_host_scatter(bearing->slots, held, count, &bearing->window.planes, changed, planes);
	bearing_marks_scatter(bearing, held, count, changed);
	return STATUS_OK;
}
