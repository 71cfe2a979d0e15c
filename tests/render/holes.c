/*
 * No hole: nowhere is sky seen through the ground, from a thousand random cameras. Skipped without GL.
 *
 * A pixel without depth is a hole in either of two cases, neither of which depends on how coarse the ground is drawn:
 *
 *   1. Ground is drawn above it in the same upright plane through the eye. Ground has one height at a place and goes on to
 *      the world's edge: what passes below a ray that meets it meets it too. The cameras have no roll and look from above
 *      the ground inside the world. Three rows above on are looked at, the two pixels beside the plane in each: skylines
 *      are not so steep that a gap between hills could be narrower.
 *   2. A ray through it that is raised by more than what is drawn can be too low meets the true ground.
 */
#include "land.h"
#include "../support/program.h"

enum { WIDTH = 96, HEIGHT = 54, CAMERAS = 1000 };
#define FOV 0.95

enum kind { RUTS, EDGE, CORNER, MIDDLE, OVERVIEW, HORIZON, KINDS };
static const char *const kind_names[KINDS] = {"in ruts", "along edges", "above corners", "half way up", "overview", "horizon"};
enum detail { RADII, ERROR_1, ERROR_4, ERROR_16, DETAILS };
static const double errors[DETAILS] = {0, 1, 4, 16};
static const char *const detail_names[DETAILS] = {"by radii", "to a pixel", "to 4 pixels", "to 16 pixels"};
enum residence { WHOLE, FEW, FITTED, RESIDENCES };
static const char *const residence_names[RESIDENCES] = {"complete", "few tiles", "fitted"};

static struct render_selection selection;
static float depth[WIDTH * HEIGHT];

struct shot {
	uint64_t number;
	enum kind kind;
	enum detail detail;
	enum residence residence;
	struct render_camera camera;
};

struct found {
	int pixels;
	int x, y;           /* the first of them */
	bool under_drawn;   /* case 1 */
};

/* --- cameras --- */

static double spread(uint64_t *dice, double low, double high)
{
	return low * pow(high / low, land_dice(dice, 0, 1));
}

/* Where, and how high above the ground there; where to look, radians north of east and up. */
static void aim(enum kind kind, uint64_t *dice, double at[2], double *above, double *turn, double *rise)
{
	int level = (int)land_dice(dice, 0, 4);
	double side = LAND_CELLS * ldexp(1, level), tiles = (LAND_SIDE - 1) / side;
	double corner[2];
	for (int i = 0; i < 2; i++) {
		at[i] = land_dice(dice, 12, LAND_SIDE - 13);
		corner[i] = side * floor(land_dice(dice, 1, tiles));
	}
	*turn = land_dice(dice, 0, 2 * M_PI);
	*above = *rise = 0;
	switch (kind) {
	case RUTS: /* along them, or across */
		at[0] = land_dice(dice, 236, 276);
		at[1] = land_way(at[0]) + land_dice(dice, -2, 2);
		if (land_dice(dice, 0, 1) < 0.5)
			*turn = atan(5 / 6.0 * cos((at[0] - 256) / 6)) + (land_dice(dice, 0, 1) < 0.5 ? M_PI : 0);
		*above = spread(dice, 0.3, 2);
		*rise = land_dice(dice, -0.6, 0.05);
		return;
	case EDGE:
		at[level % 2] = corner[level % 2] + land_dice(dice, -0.05, 0.05);
		*turn = level % 2 ? 0 : M_PI / 2;
		*turn += land_dice(dice, -0.02, 0.02) + (land_dice(dice, 0, 1) < 0.5 ? M_PI : 0);
		*above = spread(dice, 0.3, 30);
		*rise = land_dice(dice, -0.3, 0.05);
		return;
	case CORNER:
		at[0] = corner[0] + land_dice(dice, -2, 2);
		at[1] = corner[1] + land_dice(dice, -2, 2);
		*above = spread(dice, 1, 60);
		*rise = land_dice(dice, -1.57, -0.4);
		return;
	case MIDDLE:
		*above = spread(dice, 15, 90);
		*rise = land_dice(dice, -1.2, 0);
		return;
	case OVERVIEW:
		*above = spread(dice, 150, 900);
		*rise = land_dice(dice, -1.57, -0.3);
		return;
	case HORIZON:
		*above = spread(dice, 0.4, 15);
		*rise = land_dice(dice, -0.12, 0.12);
		return;
	case KINDS:
		break;
	}
	fail();
}

/* Above whatever is drawn there: in what draws the place, or where that slides to. */
static double highest_drawn(const double at[2])
{
	double most = land_surface(0, at[0], at[1]);
	for (size_t i = 0; i < selection.draw_count; i++) {
		const struct render_draw *draw = &selection.draws[i];
		double low[2], high[2];
		render_box(&land_world, draw->tile, low, high);
		bool in = at[0] >= low[0] && at[0] <= high[0] && at[1] >= low[1] && at[1] <= high[1];
		if (in && draw->replaces)
			return draw->high;
		for (int level = draw->tile.level; in && level <= draw->tile.level + 1 && level <= extent_coarsest(&land_world); level++)
			most = fmax(most, land_surface(level, at[0], at[1]));
	}
	return most;
}

static void select_for(const struct render *render, const struct shot *shot, uint64_t *dice)
{
	struct render_view view;
	render_view(render, &shot->camera, &view);
	land.seed = land_mix(shot->number);
	land.resident_of = shot->residence == FEW ? 20 + land.seed % 60 : 100;
	if (shot->residence == FITTED)
		render_fit(&land_world, &land_source, 4 + (size_t)land_dice(dice, 0, 40), &view);
	render_select(&land_world, &view, &land_source, &selection);
}

static void place(const struct render *render, struct shot *shot)
{
	uint64_t dice = land_mix(shot->number + 1), again;
	double at[2], above, turn, rise;
	aim(shot->kind, &dice, at, &above, &turn, &rise);
	double ground = land_surface(LAND_FINEST, at[0], at[1]);
	for (int i = 0; i < 4; i++) {
		double *eye = shot->camera.eye, *target = shot->camera.target;
		eye[0] = at[0];
		eye[1] = at[1];
		eye[2] = ground + above;
		target[0] = eye[0] + cos(turn) * cos(rise);
		target[1] = eye[1] + sin(turn) * cos(rise);
		target[2] = eye[2] + sin(rise);
		again = dice;
		select_for(render, shot, &again);
		double highest = highest_drawn(at);
		if (ground + fmin(above, 0.25) >= highest)
			break;
		ground = highest;
	}
}

/* --- holes --- */

/* Case 1. `top`: the highest row with ground. False, too, where the picture ends first. */
static bool is_under_drawn(const struct render_axes *axes, int x, int y, int top)
{
	double across = x + 0.5 - WIDTH / 2.0, up = y + 0.5 - HEIGHT / 2.0;
	/* The upright plane through the ray is a straight line in the picture: towards where the ray + s (0, 0, 1) is seen. */
	double forward = axes->forward[2], upward = axes->up[2];
	double slope_x = -across / axes->focal * forward, slope_y = upward - up / axes->focal * forward;
	if (fabs(slope_y) < 0.05)
		return false;
	/* Below the nadir up runs down the picture. */
	int step = slope_y > 0 ? 1 : -1;
	int drawn = 0;
	for (int row = y + 3 * step; row >= 0 && row <= top; row += step) {
		double column = across + slope_x / slope_y * (row - y) + WIDTH / 2.0 - 0.5;
		int left = (int)floor(column);
		if (left < 0 || left + 1 >= WIDTH)
			return false;
		if (depth[row * WIDTH + left] > 0 && depth[row * WIDTH + left + 1] > 0 && ++drawn == 3)
			return true;
	}
	return false;
}

/* Metres by which what is drawn may lie under the true ground wherever it stands in, and as a tangent elsewhere. */
static void find_slack(const struct render *render, const struct render_axes *axes, const struct shot *shot, double *metres,
		       double *tangent)
{
	*metres = 0;
	*tangent = (errors[shot->detail] * 1.25 + 2) / axes->focal;
	if (shot->residence != WHOLE)
		for (size_t i = 0; i < selection.draw_count; i++)
			*metres = fmax(*metres, land_find(selection.draws[i].tile)->error);
	if (shot->detail != RADII)
		return;
	for (int level = LAND_FINEST + 1; level <= extent_coarsest(&land_world); level++) {
		double error = 0;
		for (uint32_t i = 0; i < land.count; i++)
			if (land.tiles[i].tile.level == level)
				error = fmax(error, land.tiles[i].error);
		double from = 0.8 * render_mesh_reach(&(struct render){.truth = false}, axes) * extent_spacing(&land_world, level);
		*tangent = fmax(*tangent, error / from + 2 / axes->focal);
	}
}

static void find_holes(const struct render *render, const struct shot *shot, struct found *found)
{
	struct render_axes axes;
	double metres, tangent;
	int top = -1;
	render_axes(render, &shot->camera, &axes);
	find_slack(render, &axes, shot, &metres, &tangent);
	*found = (struct found){.pixels = 0};
	for (int i = 0; i < WIDTH * HEIGHT; i++)
		if (depth[i] > 0)
			top = i / WIDTH;
	static struct resident_ray rays[WIDTH * HEIGHT];
	static struct resident_hit hits[WIDTH * HEIGHT];
	static int of[WIDTH * HEIGHT];
	size_t count = 0;
	for (int i = 0; i < WIDTH * HEIGHT; i++) {
		if (depth[i] > 0)
			continue;
		if (is_under_drawn(&axes, i % WIDTH, i / WIDTH, top)) {
			if (found->pixels++ == 0)
				*found = (struct found){1, i % WIDTH, i / WIDTH, true};
			continue;
		}
		/* The lowest pixels without ground: what is above them cannot be a hole if they are none. */
		if (i >= WIDTH && depth[i - WIDTH] == 0)
			continue;
		struct resident_ray *ray = &rays[count];
		*ray = (struct resident_ray){.length = RENDER_FAR};
		memcpy(ray->origin, shot->camera.eye, sizeof ray->origin);
		land_ray(render, &axes, i % WIDTH + 0.5, i / WIDTH + 0.5, ray->direction);
		ray->origin[2] += metres;
		double level = hypot(ray->direction[0], ray->direction[1]), length = hypot(level, ray->direction[2]);
		ray->direction[2] += tangent * length * length / fmax(level, 0.1);
		of[count++] = i;
	}
	assert_ok(resident_rays(&land_ground, rays, count, hits));
	for (size_t k = 0; k < count; k++)
		if (hits[k].hit && !hits[k].below && found->pixels++ == 0)
			*found = (struct found){1, of[k] % WIDTH, of[k] / WIDTH, false};
}

static void tell(const struct shot *shot, const struct found *found)
{
	const double *eye = shot->camera.eye, *target = shot->camera.target;
	print_error("camera %d (%s, %s, %s): %d pixels, the first at %d, %d (%s); eye %.9g %.9g %.9g, looking %.9g %.9g %.9g; "
		    "%zu tiles\n",
		    (int)shot->number, kind_names[shot->kind], detail_names[shot->detail], residence_names[shot->residence],
		    found->pixels, found->x, found->y, found->under_drawn ? "under drawn ground" : "by the true ground", eye[0], eye[1],
		    eye[2], target[0] - eye[0], target[1] - eye[1], target[2] - eye[2], selection.draw_count);
}

struct counts {
	int cameras[KINDS], drawn[KINDS], holed[KINDS], pixels[KINDS];
	int of_detail[DETAILS][RESIDENCES];
};

/* Pictures with no more than so many pixels of holes pass. */
static void shoot(uint64_t effects, bool only_radii, int pinholes, struct counts *counts)
{
	struct render *renders[DETAILS];
	*counts = (struct counts){.cameras = {0}};
	for (int detail = 0; detail < DETAILS; detail++)
		renders[detail] = land_render(WIDTH, HEIGHT, effects, errors[detail]);
	for (int i = 0; i < CAMERAS; i++) {
		uint64_t dice = land_mix((uint64_t)i + 77);
		struct shot shot = {.number = (uint64_t)i, .kind = i % KINDS, .camera.fov = FOV};
		shot.detail = only_radii ? RADII : (enum detail)land_dice(&dice, 0, DETAILS);
		shot.residence = only_radii ? WHOLE : (enum residence)land_dice(&dice, 0, RESIDENCES);
		struct render *render = renders[shot.detail];
		struct found found;
		place(render, &shot);
		assert_ok(render_frame(render, &shot.camera, &selection));
		land_depth(render, depth);
		find_holes(render, &shot, &found);
		counts->pixels[shot.kind] += found.pixels;
		if (found.pixels > pinholes && counts->holed[shot.kind] < 3)
			tell(&shot, &found);
		counts->cameras[shot.kind]++;
		counts->holed[shot.kind] += found.pixels > pinholes;
		counts->of_detail[shot.detail][shot.residence] += found.pixels > pinholes;
		for (int k = 0; k < WIDTH * HEIGHT; k++)
			counts->drawn[shot.kind] += depth[k] > 0;
	}
	for (int detail = 0; detail < DETAILS; detail++)
		render_destroy(renders[detail]);
}

static int tell_counts(const struct counts *counts)
{
	int holed = 0;
	for (int kind = 0; kind < KINDS; kind++) {
		print_message("%s: %d cameras, %.0f%% ground, %d with holes (%d pixels)\n", kind_names[kind], counts->cameras[kind],
			      100.0 * counts->drawn[kind] / counts->cameras[kind] / (WIDTH * HEIGHT), counts->holed[kind],
			      counts->pixels[kind]);
		holed += counts->holed[kind];
	}
	for (int detail = 0; detail < DETAILS; detail++)
		for (int residence = 0; residence < RESIDENCES; residence++)
			if (counts->of_detail[detail][residence] > 0)
				print_message("  %s, %s: %d\n", detail_names[detail], residence_names[residence],
					      counts->of_detail[detail][residence]);
	return holed;
}

static void no_sky_is_seen_through_the_ground_from_a_thousand_cameras(void **state)
{
	need_land();
	struct counts counts;
	shoot(EFFECT_BIT(EFFECT_GEOMORPH) | EFFECT_BIT(EFFECT_SKIRTS), false, 0, &counts);
	assert_int_equal(tell_counts(&counts), 0);
}

/* Levels meet in the same vertices, so nothing has to hide what is between them. Only where tiles below level 0 end beside
 * coarser ground do their posts lie on its edges without being its posts: a pixel may be missed there. */
static void the_complete_picture_by_radii_needs_no_skirts(void **state)
{
	need_land();
	struct counts counts;
	land.unruffled = true;
	shoot(EFFECT_BIT(EFFECT_GEOMORPH), true, 0, &counts);
	int holed = tell_counts(&counts);
	land.unruffled = false;
	print_message("with ruts:\n");
	shoot(EFFECT_BIT(EFFECT_GEOMORPH), true, 1, &counts);
	assert_int_equal(holed + tell_counts(&counts), 0);
}

TEST_PROGRAM(holes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(no_sky_is_seen_through_the_ground_from_a_thousand_cameras),
		cmocka_unit_test(the_complete_picture_by_radii_needs_no_skirts),
	};
	return cmocka_run_group_tests(tests, land_open, land_close);
}
