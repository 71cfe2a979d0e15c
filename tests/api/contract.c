/* What furrow.h promises of a world that is imported, stepped, asked and looked at. */
#include "../support/near.h"
#include "rut.h"
#include "../support/program.h"

#include <cjson/cJSON.h>

static void steps_end_at_multiples_of_the_time_step(void **state)
{
	struct furrow_world *world = hosted_world("steps.furrow");
	for (int i = 1; i <= 300; i++) {
		done(furrow_step(world, 0));
		assert_true(furrow_time(world) == i * 0.01);
	}
	done(furrow_step(world, 0.25));
	assert_near(furrow_time(world), 3.25, 1e-12);
	done(furrow_step(world, 0));
	assert_near(furrow_time(world), 3.26, 1e-12);
	done(furrow_world_close(world));
}

static void the_world_says_what_it_is(void **state)
{
	struct furrow_world *world = hosted_world_over("info.furrow", HOSTED_SCENE, support_hills);
	struct furrow_info info = {.size = sizeof info};
	done(furrow_info(world, &info));
	assert_int_equal(info.level, -1);
	assert_true(info.spacing == 0.125);
	assert_int_equal(info.columns, 257);
	assert_int_equal(info.rows, 257);
	assert_true(info.extent[0] == 32 && info.extent[1] == 32);
	assert_int_equal(info.cells, 32);
	assert_int_equal(info.coarsest, 2);
	assert_int_equal(info.levels, 4);
	assert_true(info.low > 96 && info.low < 100 && info.high > 100 && info.high < 105);
	assert_true(info.gravity == 9.81 && info.time_step == 0.01);
	assert_string_equal(info.srs, "");
	/* A host that knows fewer members gets those. */
	struct furrow_info partial;
	memset(&partial, 0x55, sizeof partial);
	partial.size = offsetof(struct furrow_info, gravity);
	done(furrow_info(world, &partial));
	assert_true(partial.low == info.low);
	for (size_t i = partial.size; i < sizeof partial; i++)
		assert_int_equal(((unsigned char *)&partial)[i], 0x55);
	done(furrow_world_close(world));
}

static void a_ball_leaves_a_rut_that_every_question_sees(void **state)
{
	struct furrow_world *world = hosted_world("rut.furrow");
	furrow_body ball = hosted_ball(world, 10, 16);
	make_rut(world, ball, 10, 16, 40);
	const struct furrow_contact contact = contact_of(world, ball);
	assert_int_equal(contact.state, FURROW_TOUCHING);
	assert_true(contact.force[2] > 100 && contact.normal_force > 100);
	/* 0.1 m below the flat ground; soil that is heaped before the ball counts, too. */
	assert_true(contact.area > 0 && contact.sinkage > 0.09 && contact.sinkage < 0.2);
	assert_near(contact.time, furrow_time(world), 1e-12);
	assert_true(isnan(contact.slip));
	assert_true(contact.stiffness[2][2] < 0 && contact.damping[2][2] <= 0);

	const struct furrow_point in = point_at(world, 11, 16), beside = point_at(world, 11, 20), out = point_at(world, -1, 16);
	assert_true(in.offset < -0.05 && in.height < 99.95 && !in.nodata);
	assert_near(in.height, 100 + in.offset, 1e-6);
	assert_true(beside.offset == 0 && beside.height == 100 && beside.normal[2] == 1);
	assert_true(out.nodata && isnan(out.height));

	const double from[2][3] = {{11, 16, 120}, {11, 16, 120}}, to[2][3] = {{0, 0, -3}, {0, 0, 1}};
	struct furrow_hit hits[2];
	done(furrow_rays(world, 2, &from[0][0], &to[0][0], hits));
	assert_true(hits[0].hit && !hits[1].hit);
	assert_near(hits[0].position[2], in.height, 1e-6);
	assert_near(hits[0].distance, 120 - in.height, 1e-6);

	struct furrow_info info;
	double *surface = hosted_read(world, FURROW_SURFACE, &info), *base = hosted_read(world, FURROW_BASE, &info),
	       *offset = hosted_read(world, FURROW_OFFSET, &info), *sinkage = hosted_read(world, FURROW_SINKAGE, &info);
	double deepest = 0, sunk = 0;
	for (int64_t i = 0; i < info.columns * info.rows; i++) {
		assert_near(surface[i], base[i] + offset[i], 1e-5);
		deepest = support_least(deepest, offset[i]);
		sunk = support_most(sunk, sinkage[i]);
	}
	assert_true(deepest < -0.05 && deepest > -0.15 && sunk > 0.01);
	assert_near(offset[128 * info.columns + 88], in.offset, 1e-6);
	free(surface);
	free(base);
	free(offset);
	free(sinkage);
	/* Part of the rows of a wider picture; what is between them is kept. */
	double rows[2][4] = {{-7, -7, -7, -7}, {-7, -7, -7, -7}};
	done(furrow_read(world, FURROW_OFFSET, info.level, 88, 128, 3, 2, rows[0], 4));
	assert_true(rows[0][0] < -0.05 && rows[0][3] == -7 && rows[1][3] == -7);

	done(furrow_place(world, ball, &(struct furrow_pose){{10, 10, 103}, {1, 0, 0, 0}}));
	done(furrow_step(world, 0));
	const struct furrow_contact air = contact_of(world, ball);
	assert_int_equal(air.state, FURROW_AIR);
	assert_true(air.force[0] == 0 && air.force[2] == 0);
	done(furrow_world_close(world));
}

/* A PNG of a pixel a post: one value in the west half, another in the east. */
static const char *halves_of(const char *name, double west, double east)
{
	static char path[400];
	struct dem_raster raster = {.path = support_path(name), .width = 129, .height = 129, .type = DEM_UINT16, .spacing = 1};
	struct dem_writer *writer;
	double row[129];
	snprintf(path, sizeof path, "%s", support_path(name));
	raster.path = path;
	for (int x = 0; x < 129; x++)
		row[x] = x < 64 ? west : east;
	must(dem_writer_create(&raster, &writer));
	for (int y = 0; y < 129; y++)
		must(dem_writer_rows(writer, 1, row));
	must(dem_writer_publish(writer));
	dem_writer_destroy(writer);
	return path;
}

static void a_shear_limit_is_of_the_rasters_number(void **state)
{
	static const double cohesions[] = {100, 6000};
	char scene[600];
	snprintf(scene, sizeof scene, "{\"scene\": 1, \"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\", \"rasters\": {\"cohesion\": \"%s\"}}, "
				      "\"redistribute\": {\"model\": \"scm\"}}", halves_of("cohesion.png", cohesions[0], cohesions[1]));
	struct furrow_world *world = hosted_world_over("rasters.furrow", scene, hosted_flat);
	for (int i = 0; i < 2; i++) {
		furrow_body ball = hosted_ball(world, 8 + 16 * i, 16);
		hosted_move(world, ball, 8 + 16 * i, 16, 100.45);
		const struct furrow_contact contact = contact_of(world, ball);
		assert_true(contact.area > 0.01 && contact.normal_force > 0);
		double cohesion = (contact.shear_limit - contact.normal_force * tan(28 * M_PI / 180)) / contact.area;
		assert_near(cohesion, cohesions[i], 0.01);
	}
	done(furrow_world_close(world));
}

/* A ball that is drawn along. */
static void a_shear_limit_is_of_the_body_s_surface(void **state)
{
	static const struct {
		const char *surface;
		double adhesion, angle;
	} rows[] = {{"", 1040, 28}, {", interface: {friction_angle: 10}", 1040, 10}, {", interface: {adhesion: 100, friction_angle: 20}", 100, 20},
		    {", interface: {adhesion: 5000}", 1040, 28}};
	/* Of the lower envelope: faces take two thirds of the soil's friction angle where none is given. */
	struct furrow_world *world = hosted_world_over("surface.furrow", "{time_step: 0.01, spacing: 0.125, soil: {name: dry_sand}, redistribute: {model: scm, faces: off}}", hosted_flat);
	double pull[4];
	for (int i = 0; i < 4; i++) {
		char object[120];
		furrow_body ball = -1;
		const double y = 6 + 6 * i;
		snprintf(object, sizeof object, "{shape: {sphere: {radius: 0.5}}%s}", rows[i].surface);
		done(furrow_body_add(world, object, &ball));
		const struct furrow_pose pose = hosted_pose(8, y, 100.45);
		done(furrow_place(world, ball, &pose));
		for (int step = 1; step <= 20; step++)
			hosted_move(world, ball, 8 + 0.025 * step, y, 100.45);
		const struct furrow_contact contact = contact_of(world, ball);
		double limit = rows[i].adhesion * contact.area + contact.normal_force * tan(rows[i].angle * M_PI / 180);
		assert_near(contact.shear_limit, limit, 1e-6 * limit);
		pull[i] = contact.force[0];
	}
	/* Weaker surfaces hold it back less, and a stronger one as the soil itself. */
	assert_true(pull[0] < pull[2] && pull[2] < 0 && pull[0] < pull[1] && pull[1] < 0);
	assert_true(pull[3] == pull[0]);
	done(furrow_world_close(world));
}

/* A wheel that leans to the left and one that leans to the right, driven at a slip of 0.2: what the soil does to one is mirrored on the other,
 * it pushes each to the side to which it leans, and their slip is told about their own axles. */
static void wheels_may_lean(void **state)
{
	struct furrow_world *world = hosted_world("lean.furrow");
	struct furrow_contact contacts[2];
	const double lean = 0.2, speed = 2, spin = speed / (0.5 * 0.8);
	for (int i = 0; i < 2; i++) {
		furrow_body wheel = -1;
		const double half = (i == 0 ? lean : -lean) / 2, y = 10 + 8 * i, z = 100 + 0.5 * cos(lean) + 0.2 * sin(lean) - 0.08;
		struct furrow_state at = {.pose = {{8, y, z}, {cos(half), sin(half), 0, 0}}, .linear = {speed, 0, 0}};
		at.angular[1] = spin * cos(2 * half);
		at.angular[2] = spin * sin(2 * half);
		done(furrow_body_add(world, "{shape: {wheel: {radius: 0.5, width: 0.4, grousers: 12}}}", &wheel));
		done(furrow_place(world, wheel, &at.pose));
		for (int step = 0; step < 40; step++) {
			at.pose.position[0] += speed * 0.01;
			done(furrow_set_states(world, 1, &wheel, &at));
			done(furrow_step(world, 0));
		}
		contacts[i] = contact_of(world, wheel);
		assert_near(contacts[i].slip, 0.2, 1e-9);
	}
	assert_true(contacts[0].force[1] < -0.02 * contacts[0].force[2] && contacts[0].force[0] > 0);
	for (int k = 0; k < 3; k++) { /* a mirror turns forces across it, and moments along it */
		const double size = 2e-3 * contacts[0].force[2];
		assert_near(contacts[1].force[k], (k == 1 ? -1 : 1) * contacts[0].force[k], size);
		assert_near(contacts[1].moment[k], (k == 1 ? 1 : -1) * contacts[0].moment[k], size);
	}
	done(furrow_world_close(world));
}

static void a_body_that_rasters_do_not_bear_is_refused(void **state)
{
	char scene[600];
	snprintf(scene, sizeof scene, "{\"scene\": 1, \"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\", \"bekker_kc\": -10, \"rasters\": "
				      "{\"bekker_kphi\": \"%s\"}}, \"redistribute\": {\"model\": \"scm\"}}", halves_of("kphi.png", 20, 60000));
	struct furrow_world *world = hosted_world_over("weak.furrow", scene, hosted_flat);
	furrow_body body = -1;
	refused(FURROW_INPUT, furrow_body_add(world, "{name: thin, shape: {wheel: {radius: 0.5, width: 0.25}}}", &body));
	assert_non_null(strstr(furrow_last_error(), "soil.rasters: bekker_kc / b + bekker_kphi is as low as -20 under thin"));
	done(furrow_body_add(world, "{name: wide, shape: {wheel: {radius: 0.5, width: 1}}}", &body));
	done(furrow_world_close(world));
}

static void states_are_as_they_were_set(void **state)
{
	struct furrow_world *world = hosted_world("states.furrow");
	const furrow_body ball = hosted_ball(world, 16, 16);
	struct furrow_state set = hosted_state(16.25, 16, 100.45), got;
	set.linear[0] = 25;
	set.angular[1] = 3;
	done(furrow_set_states(world, 1, &ball, &set));
	done(furrow_get_states(world, 1, &ball, &got));
	assert_near(got.pose.position[0], 16, 1e-6); /* until the step */
	done(furrow_step(world, 0));
	done(furrow_get_states(world, 1, &ball, &got));
	assert_memory_equal(&got, &set, sizeof got);
	done(furrow_world_close(world));
}

static void a_picture_has_depths_in_metres(void **state)
{
	struct furrow_world *world = hosted_world("picture.furrow");
	enum { WIDTH = 64, HEIGHT = 48 };
	static uint8_t rgb[HEIGHT][WIDTH][3];
	static float depth[HEIGHT][WIDTH], again[HEIGHT][WIDTH];
	const double half = sqrt(0.5);
	/* Straight down from 10 m: its own x axis to -z. */
	struct furrow_camera camera = {sizeof camera, {{16, 16, 110}, {half, 0, half, 0}}, 0.8, WIDTH, HEIGHT};
	done(furrow_render(world, &camera, rgb[0][0], depth[0]));
	for (int y = 0; y < HEIGHT; y++)
		for (int x = 0; x < WIDTH; x++)
			assert_near(depth[y][x], 10, 0.01);
	/* Level, to the east: the ground below, the sky above. */
	camera.pose = (struct furrow_pose){{16, 16, 101}, {1, 0, 0, 0}};
	done(furrow_render(world, &camera, rgb[0][0], depth[0]));
	assert_true(isinf(depth[0][WIDTH / 2]) && depth[0][WIDTH / 2] > 0);
	assert_true(depth[HEIGHT - 1][WIDTH / 2] > 1 && depth[HEIGHT - 1][WIDTH / 2] < 4);
	assert_memory_not_equal(rgb[0][WIDTH / 2], rgb[HEIGHT - 1][WIDTH / 2], 3);
	done(furrow_render(world, &camera, NULL, again[0]));
	assert_memory_equal(depth, again, sizeof depth);
	done(furrow_render(world, &camera, rgb[0][0], NULL));
	camera.width = 32;
	done(furrow_render(world, &camera, rgb[0][0], depth[0]));
	done(furrow_world_close(world));
	/* A sky that is drawn is as far as one that is not. */
	world = hosted_world_over("sky.furrow", "{\"scene\": 1, \"spacing\": 0.125, \"view\": {\"effects\": [\"texture\", \"sky\"], "
				  "\"camera\": {\"fixed\": {\"eye\": [1, 1, 110], \"target\": [9, 9, 100]}}}}", hosted_flat);
	camera.width = WIDTH;
	done(furrow_render(world, &camera, rgb[0][0], again[0]));
	assert_true(isinf(again[0][WIDTH / 2]));
	assert_true(again[HEIGHT - 1][WIDTH / 2] > 1 && again[HEIGHT - 1][WIDTH / 2] < 4);
	done(furrow_world_close(world));
}

/* How far the middle of a picture is from a camera 10 m above the ground that looks straight down. */
static double depth_below(struct furrow_world *world, double x, double y)
{
	float depth[9];
	const struct furrow_camera camera = {sizeof camera, {{x, y, 110}, {sqrt(0.5), 0, sqrt(0.5), 0}}, 0.02, 3, 3};
	done(furrow_render(world, &camera, NULL, depth));
	return (double)depth[4];
}

/* Bodies are drawn where they are: those that a scene has without a path, and those that are added after the first picture. */
static void a_picture_has_the_bodies_that_a_host_moves(void **state)
{
	struct furrow_world *world = hosted_world_over("shown.furrow", "{view: {effects: [objects]}, spacing: 0.125, "
						       "objects: [{name: own, shape: {sphere: {radius: 1}}}]}", hosted_flat);
	furrow_body own, wheel;
	const struct furrow_pose first = hosted_pose(8, 8, 101), second = {{16, 16, 101}, {sqrt(0.5), 0, 0, sqrt(0.5)}};
	assert_near(depth_below(world, 8, 8), 10, 0.01);
	done(furrow_body_find(world, "own", &own));
	done(furrow_place(world, own, &first));
	assert_near(depth_below(world, 8, 8), 8, 0.05);
	const furrow_body ball = hosted_ball(world, 24, 24);
	done(furrow_body_add(world, "{shape: {wheel: {radius: 1, width: 0.5}}}", &wheel));
	assert_near(depth_below(world, 16, 16), 10, 0.01); /* it is nowhere yet */
	done(furrow_place(world, wheel, &second));
	/* It rolls to the north: 0.8 m ahead there is its rim, 0.8 m beside it the ground. */
	assert_near(depth_below(world, 16, 16.8), 8.4, 0.05);
	assert_near(depth_below(world, 16.8, 16), 10, 0.05);
	assert_near(depth_below(world, 24, 24), 9, 0.05);
	done(furrow_body_remove(world, ball));
	assert_near(depth_below(world, 24, 24), 10, 0.05);
	assert_near(depth_below(world, 8, 8), 8, 0.05);
	done(furrow_world_close(world));
}

/* A scene without a view, and a view without a camera: a picture needs neither. Nothing is seen through the ground. */
static void a_picture_needs_no_view(void **state)
{
	enum { SIZE = 32 };
	static uint8_t rgb[SIZE][SIZE][3], sunlit[SIZE][SIZE][3];
	struct furrow_camera camera = {sizeof camera, {{16, 16, 102}, {1, 0, 0, 0}}, 0.8, SIZE, SIZE};
	struct furrow_world *world = hosted_world("bare.furrow");
	done(furrow_render(world, &camera, rgb[0][0], NULL));
	assert_true(rgb[0][0][2] > 100 && rgb[0][0][2] > rgb[0][0][0]); /* a sky, and grass */
	assert_true(rgb[SIZE - 1][0][1] > rgb[SIZE - 1][0][2]);
	done(furrow_world_close(world));
	world = hosted_world_over("dark.furrow", "{view: {effects: [sky, skirts], sun: {height: 2}}}", hosted_flat);
	done(furrow_render(world, &camera, sunlit[0][0], NULL));
	assert_true(sunlit[SIZE - 1][0][1] < rgb[SIZE - 1][0][1]);
	done(furrow_world_close(world));
}

static void figures_are_json(void **state)
{
	struct furrow_world *world = hosted_world("stats.furrow");
	char *json = NULL;
	done(furrow_step(world, 0));
	done(furrow_step(world, 0));
	done(furrow_stats(world, &json));
	cJSON *tree = cJSON_Parse(json);
	assert_non_null(tree);
	assert_int_equal(cJSON_GetObjectItem(tree, "steps")->valueint, 2);
	cJSON_Delete(tree);
	furrow_free(json);
	done(furrow_world_close(world));
}

static bool stop_early(double share, void *user)
{
	assert_true(share >= 0 && share <= 1);
	return ++*(int *)user < 2;
}

static bool go_on(double share, void *user)
{
	assert_true(share >= *(double *)user && share <= 1);
	*(double *)user = share;
	return true;
}

/* A PNG of 16 bits, one metre a unit. */
static void write_png(const char *path)
{
	enum { SIDE = 600 };
	struct dem_writer *writer;
	const struct dem_raster raster = {.path = path, .width = SIDE, .height = SIDE, .type = DEM_UINT16, .srs = "", .spacing = 1};
	double *heights = malloc(sizeof *heights * SIDE * SIDE);
	assert_non_null(heights);
	for (int i = 0; i < SIDE * SIDE; i++)
		heights[i] = 200 + i % SIDE % 7;
	must(dem_writer_create(&raster, &writer));
	must(dem_writer_rows(writer, SIDE, heights));
	must(dem_writer_publish(writer));
	dem_writer_destroy(writer);
	free(heights);
}

static void an_import_stops_and_goes_on(void **state)
{
	const char *png = support_path("dem.png"), *store = support_path("imported.furrow");
	int asked = 0;
	double share = 0;
	write_png(png);
	refused(FURROW_INTERRUPTED, furrow_import(&png, 1, store, "{spacing: 2, tile: 32}", stop_early, &asked));
	assert_int_equal(access(store, F_OK), -1);
	done(furrow_import(&png, 1, store, "{spacing: 2, tile: 32, resume: true}", go_on, &share));
	assert_true(share == 1);
	support_verify(store);
	refused(FURROW_INPUT, furrow_import(&png, 1, store, NULL, NULL, NULL));
	done(furrow_import(&png, 1, store, "{overwrite: true}", NULL, NULL));
	struct furrow_world *world;
	const struct furrow_open open = hosted_open("{scene: 1}", store);
	struct furrow_info info = {.size = sizeof info};
	done(furrow_world_open(&open, &world));
	done(furrow_info(world, &info));
	assert_int_equal(info.columns, 600);
	assert_true(info.spacing == 1 && info.low == 200 && info.high == 206);
	assert_true(point_at(world, 3, 300).height == 203);
	done(furrow_world_close(world));
}

/* --- a host's body and one with a path --- */

#define WAY_POSTS 24
#define WAY_SCENE(objects) \
	"{\"scene\": 1, \"time_step\": 0.125, \"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\"}, \"redistribute\": {\"model\": \"" \
	"%s}" objects "}"

static struct furrow_world *way_world(const char *name, const char *format, const char *model)
{
	char scene[600];
	snprintf(scene, sizeof scene, format, model);
	return hosted_world_over(name, scene, hosted_flat);
}

/* A ball goes along x at 1 m/s, 0.1 m deep: by a path of the scene, and by a host that moves it by a post a step. */
static void a_host_on_a_path_leaves_what_the_path_leaves(void **state)
{
	/* The ground at large does not relax meanwhile: the host is a step behind. */
	static const char *const models[] = {"none\"", "slippage\", \"interval\": 1000", "scm\", \"interval\": 1000"};
	static const enum furrow_layer layers[] = {FURROW_OFFSET, FURROW_SINKAGE, FURROW_DEPOSITED};
	(void)state;
	for (size_t m = 0; m < sizeof models / sizeof *models; m++) {
		struct furrow_world *by_path = way_world("by_path.furrow", WAY_SCENE(", \"objects\": [{\"name\": \"ball\", \"shape\": {\"sphere\": "
			"{\"radius\": 0.5}}, \"sink\": 0.1, \"path\": {\"points\": [[10, 16], [13, 16]], \"speed\": 1}}]"), models[m]);
		struct furrow_world *by_host = way_world("by_host.furrow", WAY_SCENE(""), models[m]);
		furrow_body ball;
		const struct furrow_pose from = hosted_pose(10, 16, 100.4);
		done(furrow_body_add(by_host, HOSTED_BALL, &ball));
		done(furrow_place(by_host, ball, &from));
		/* The path's first sample is due in the first step, like its second; the host's first step touches where the ball was placed. */
		done(furrow_step(by_host, 0));
		for (int i = 1; i <= WAY_POSTS; i++) {
			struct furrow_state at = hosted_state(10 + 0.125 * i, 16, 100.4);
			at.linear[0] = 1;
			done(furrow_set_states(by_host, 1, &ball, &at));
			done(furrow_step(by_host, 0));
			done(furrow_step(by_path, 0));
		}
		double lowest = 0;
		for (size_t l = 0; l < sizeof layers / sizeof *layers; l++) {
			struct furrow_info info;
			double *a = hosted_read(by_path, layers[l], &info), *b = hosted_read(by_host, layers[l], &info);
			for (int64_t i = 0; i < info.columns * info.rows; i++)
				if (a[i] != b[i] && !(isnan(a[i]) && isnan(b[i])))
					print_error("%s, layer %zu, post %lld: %g, %g\n", models[m], l, (long long)i, a[i], b[i]);
			assert_memory_equal(a, b, (size_t)(info.columns * info.rows) * sizeof *a);
			for (int64_t i = 0; l == 0 && i < info.columns * info.rows; i++)
				lowest = support_least(lowest, a[i]);
			free(a);
			free(b);
		}
		assert_true(lowest < -0.09);
		done(furrow_world_close(by_path));
		done(furrow_world_close(by_host));
	}
}

TEST_PROGRAM(contract)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(steps_end_at_multiples_of_the_time_step),
		cmocka_unit_test(the_world_says_what_it_is),
		cmocka_unit_test(a_ball_leaves_a_rut_that_every_question_sees),
		cmocka_unit_test(a_shear_limit_is_of_the_rasters_number),
		cmocka_unit_test(a_shear_limit_is_of_the_body_s_surface),
		cmocka_unit_test(wheels_may_lean),
		cmocka_unit_test(a_body_that_rasters_do_not_bear_is_refused),
		cmocka_unit_test(states_are_as_they_were_set),
		cmocka_unit_test(a_picture_has_depths_in_metres),
		cmocka_unit_test(a_picture_has_the_bodies_that_a_host_moves),
		cmocka_unit_test(a_picture_needs_no_view),
		cmocka_unit_test(figures_are_json),
		cmocka_unit_test(an_import_stops_and_goes_on),
		cmocka_unit_test(a_host_on_a_path_leaves_what_the_path_leaves),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
