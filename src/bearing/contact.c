/* One contact of bearing soil: from the tiles into a window, the body into the ground, and back. */
#include <math.h>
#include <string.h>

#include "bearing/internal.h"
#include "soil/kinematic/kinematic.h"

enum status bearing_area(const struct bearing *bearing, const struct deform_contact *contact, struct bearing_area *area)
{
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	*area = (struct bearing_area){{0, 0, 0, 0}, {0, 0, 0, 0}};
	enum status status = deform_cut(&bearing->params, contact, windows, &count);
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		area->read = post_rect_joined(area->read, windows[i].read);
		area->write = post_rect_joined(area->write, windows[i].write);
	}
	return status;
}

static struct soil_motion motion_of(const struct deform_contact *contact)
{
	struct soil_motion motion = {
		.shape = contact->shape, .interface = contact->interface, .from = contact->from, .to = contact->to, .turned = contact->turned, .load = contact->load,
		.stamped = contact->stamped, .hosted = contact->hosted, .jumped = deform_is_contact_only(contact) && !contact->hosted,
	};
	memcpy(motion.rotated, contact->rotated, sizeof motion.rotated);
	memcpy(motion.linear, contact->linear, sizeof motion.linear);
	memcpy(motion.angular, contact->angular, sizeof motion.angular);
	motion.runs = contact->runs;
	return motion;
}

static enum status gather(struct bearing *bearing, struct post_rect read, const struct tile_slot *held, size_t count)
{
	const struct soil_planes *planes = &bearing->window.planes;
	enum status status = bearing_window_need(bearing, read);
	if (status != STATUS_OK)
		return status;
	resident_host_gather(bearing->slots, held, count, planes);
	memset(planes->contact, 0, planes->width * (size_t)(read.y1 - read.y0));
	return STATUS_OK;
}

static enum status scatter(struct bearing *bearing, struct post_rect rect, const struct tile_slot *held, size_t count)
{
	enum status status = STATUS_OK;
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		if (!post_rect_empty(post_rect_intersect(tile_post_rect(bearing->params.extent, held[i].tile), rect)))
			status = resident_host_write(bearing->slots, held[i].slot, bearing->planes);
	if (status == STATUS_OK)
		resident_host_scatter(bearing->slots, held, count, &bearing->window.planes, rect, bearing->planes);
	return status;
}

/* --- forces --- */

/* Returns the mean slope of the base between two posts along an axis; 0: not known. */
static double slope_between(const struct soil_planes *planes, double spacing, int64_t x0, int64_t y0, int64_t x1, int64_t y1)
{
	const int32_t *base = planes->base;
	const int64_t mx = (x0 + x1) / 2, my = (y0 + y1) / 2;
#define POST(x, y) base[(size_t)((y) - planes->rect.y0) * planes->width + (size_t)((x) - planes->rect.x0)]
	int32_t first = POST(x0, y0), last = POST(x1, y1), middle = POST(mx, my);
#undef POST
	int64_t posts = x1 - x0 + y1 - y0;
	if (first == BASE_NODATA || last == BASE_NODATA) {
		posts = first == BASE_NODATA ? x1 - mx + y1 - my : mx - x0 + my - y0;
		first = first == BASE_NODATA ? middle : first;
		last = last == BASE_NODATA ? middle : last;
	}
	if (first == BASE_NODATA || last == BASE_NODATA || posts <= 0)
		return 0;
	return fmin(fmax(lattice_base_metres((int64_t)last - first) / ((double)posts * spacing), -1e4), 1e4);
}

/* Gives the mean slope of the base under the body: the ground as it was before all drives. */
static void put_slope(const struct bearing *bearing, const struct soil_motion *motion, double slope[2])
{
	const struct soil_planes *planes = &bearing->window.planes;
	const struct post_rect below = post_rect_intersect(soil_shadow(motion->shape, &motion->from, &motion->to, bearing->law.spacing), planes->rect);
	slope[0] = slope[1] = 0;
	if (post_rect_empty(below))
		return;
	const int64_t x0 = below.x0, y0 = below.y0, x1 = below.x1 - 1, y1 = below.y1 - 1, mx = (x0 + x1) / 2, my = (y0 + y1) / 2;
	slope[0] = slope_between(planes, bearing->law.spacing, x0, my, x1, my);
	slope[1] = slope_between(planes, bearing->law.spacing, mx, y0, mx, y1);
}

/* Returns true if a slope is too steep to hold a load: W sin a > c A + W cos a tan phi. c and phi are of the soil below the body's middle, or of the
 * body's surface. */
static bool slides(const struct bearing *bearing, const struct soil_motion *motion, const struct deform_forces *forces)
{
	const struct soil_planes *planes = &bearing->window.planes;
	const double steep = hypot(forces->slope[0], forces->slope[1]), sine = steep / hypot(1, steep);
	const int64_t x = (int64_t)llround(lattice_offset_metres(motion->to.x) / bearing->law.spacing), y = (int64_t)llround(lattice_offset_metres(motion->to.y) / bearing->law.spacing);
	const struct post_rect *rect = &planes->rect;
	size_t at = 0;
	if (x >= rect->x0 && x < rect->x1 && y >= rect->y0 && y < rect->y1)
		at = (size_t)(y - rect->y0) * planes->width + (size_t)(x - rect->x0);
	const struct soil_numbers soil = soil_numbers_at(&bearing->law, planes, at);
	return motion->load * sine > soil_shear_limit(&soil, &motion->interface, forces->area, motion->load * sqrt(1 - sine * sine));
}

/* The force that the path must add to the soil's, so that the body keeps its motion. */
static double residual_of(const struct deform_contact *contact, const struct deform_forces *forces)
{
	const double ahead[2] = {cos(contact->to.yaw), sin(contact->to.yaw)}, *force = forces->force;
	const double rise = forces->slope[0] * ahead[0] + forces->slope[1] * ahead[1], weight = contact->load > 0 ? contact->load : force[2];
	return -(force[0] * ahead[0] + force[1] * ahead[1] + (force[2] - weight) * rise) / hypot(1, rise);
}

static void tell(const struct bearing *bearing, const struct deform_contact *contact, const struct soil_motion *motion, const struct soil_forces *from,
		 struct deform_forces *forces)
{
	static const enum deform_state states[SOIL_STATES] = {DEFORM_TOUCHING, DEFORM_SLIDES, DEFORM_SUNK, DEFORM_AIR};
	*forces = (struct deform_forces){.sinkage = fmax(from->sinkage, 0), .area = from->area, .pull = from->pull, .z = from->z,
					 .saturated = from->saturated, .state = states[from->state]};
	memcpy(forces->force, from->force, sizeof forces->force);
	memcpy(forces->moment, from->moment, sizeof forces->moment);
	put_slope(bearing, motion, forces->slope);
	if (!(forces->area > 0) && forces->state != DEFORM_SUNK)
		forces->state = DEFORM_AIR;
	if (forces->state == DEFORM_TOUCHING && contact->load > 0 && slides(bearing, motion, forces))
		forces->state = DEFORM_SLIDES;
	if (forces->area > 0)
		forces->residual = residual_of(contact, forces);
}

/* --- contacts --- */

static enum status sink(struct bearing *bearing, const struct deform_contact *contact, const struct soil_motion *motion, struct soil_laying *laying,
			 struct soil_imprint *imprint)
{
	*laying = soil_laying_of(contact->shape, &contact->from, &contact->to, contact->turned, bearing->law.spacing);
	const struct soil_sink how = {laying, bearing->laid, contact->loaded_body > 0 ? bearing->standing[contact->loaded_body - 1] : 0};
	return soil_sink_body(&bearing->law, &bearing->window.planes, motion, &how, bearing->work, imprint);
}

static void add_tally(struct bearing *bearing, const struct soil_imprint *imprint, const struct soil_lay_result *laid, const struct soil_slid *slid,
		      enum deform_state state)
{
	bearing->tally.compacted += imprint->compacted + laid->compacted + (int64_t)slid->compacted;
	bearing->tally.refused += imprint->refused + laid->refused + slid->refused;
	bearing->tally.confined += laid->confined;
	bearing->tally.sunk += state == DEFORM_SUNK;
	bearing->tally.slid += state == DEFORM_SLIDES;
}

/* Lays what the contact displaced, lets it slide, and returns the posts that may have changed. */
static struct post_rect redistribute(struct bearing *bearing, const struct deform_contact *contact, const struct bearing_area *area, const struct soil_laying *laying,
				     const struct soil_imprint *imprint, struct soil_lay_result *laid, struct soil_slid *slid)
{
	struct bearing_window *window = &bearing->window;
	const struct soil_planes *planes = &window->planes;
	const size_t posts = planes->width * (size_t)(planes->rect.y1 - planes->rect.y0);
	const bool carries = imprint->measured.carried > 0;
	if (carries) {
		memset(window->deposits, 0, posts * sizeof *window->deposits);
		soil_lay(laying, &imprint->measured, bearing->laid, planes, planes->contact, area->write, window->scratch, window->deposits, laid);
	}
	const struct post_rect reached = post_rect_joined(imprint->reached, laid->posts);
	const struct soil_slide_window slide = {
		.written = area->write, .posts = soil_slide_posts(area->write, reached, bearing->around), .world = bearing->world,
		.deposits = carries ? window->deposits : NULL, .loaded = contact->load > 0,
	};
	soil_slide_window(&bearing->rule, planes, &slide, window->scratch, window->words, slid);
	return post_rect_intersect(area->write, post_rect_grown(post_rect_joined(reached, slide.posts), 1));
}

enum status bearing_contact(struct bearing *bearing, const struct deform_contact *contact, const struct bearing_area *area, const struct tile_slot *held,
			    size_t count, struct bearing_contact *out)
{
	const struct soil_motion motion = motion_of(contact);
	struct soil_laying laying;
	struct soil_imprint imprint;
	struct soil_lay_result laid = {.posts = {0, 0, 0, 0}};
	struct soil_slid slid = {0};
	*out = (struct bearing_contact){.changed = {0, 0, 0, 0}};
	enum status status = gather(bearing, area->read, held, count);
	if (status == STATUS_OK)
		status = sink(bearing, contact, &motion, &laying, &imprint);
	if (status != STATUS_OK)
		return status;
	bearing->contacts++;
	tell(bearing, contact, &motion, &imprint.forces, &out->forces);
	if (!post_rect_empty(imprint.reached)) {
		out->changed = redistribute(bearing, contact, area, &laying, &imprint, &laid, &slid);
		if (bearing->params.disturbance)
			soil_kinematic_disturb(&bearing->window.planes, post_rect_intersect(imprint.reached, area->write));
		status = scatter(bearing, out->changed, held, count);
		if (status == STATUS_OK)
			status = soil_active_add_words(&bearing->active, bearing->world, soil_slide_blocks(area->write), bearing->window.words);
		if (status != STATUS_OK)
			return status;
	}
	add_tally(bearing, &imprint, &laid, &slid, out->forces.state);
	if (contact->loaded_body > 0)
		bearing->standing[contact->loaded_body - 1] = imprint.raised;
	return STATUS_OK;
}

enum status bearing_feel(struct bearing *bearing, const struct deform_contact *contact, const struct bearing_area *area, const struct tile_slot *held,
			 size_t count, struct deform_forces *forces)
{
	const struct soil_motion motion = motion_of(contact);
	struct soil_laying laying;
	struct soil_imprint imprint;
	enum status status = gather(bearing, area->read, held, count);
	if (status == STATUS_OK)
		status = sink(bearing, contact, &motion, &laying, &imprint);
	if (status != STATUS_OK)
		return status;
	bearing->feels++;
	tell(bearing, contact, &motion, &imprint.forces, forces);
	return STATUS_OK;
}

/* --- probes --- */

struct post_rect bearing_probe_posts(const struct bearing *bearing, const struct soil_motion *motion)
{
	const struct post_rect shadow = soil_shadow(motion->shape, motion->jumped ? &motion->to : &motion->from, &motion->to, bearing->law.spacing);
	return post_rect_empty(shadow) ? shadow : post_rect_intersect(post_rect_grown(shadow, 2), post_rect_grown(bearing->world, 1));
}

enum status bearing_probe(struct bearing *bearing, const struct soil_motion *motion, const struct tile_slot *held, size_t count, struct soil_probed *out)
{
	const struct post_rect read = bearing_probe_posts(bearing, motion);
	*out = (struct soil_probed){.known = false};
	if (post_rect_empty(read))
		return STATUS_OK;
	enum status status = gather(bearing, read, held, count);
	return status == STATUS_OK ? soil_probe(&bearing->law, &bearing->window.planes, motion, bearing->work, out) : status;
}
