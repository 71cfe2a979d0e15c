/* Soil is laid on the CPU as on the GPU, bit for bit: each is the other's oracle. */
#include "../deform/ground.h"
#include "../support/program.h"
#include "soil/laying/laying.h"

#define SIDE_POSTS 240 /* the most that a window writes here */
#define POSTS (SIDE_POSTS * SIDE_POSTS)
#define BIAS (1u << 30)

/* What a contact left, before its soil is laid; row by row of the written posts. */
struct field {
	struct post_rect write;
	int32_t base[POSTS], offset[POSTS], carried[POSTS];
	uint8_t contact[POSTS], patch[POSTS], classes[POSTS];
};
/* What was laid. */
struct laid {
	int32_t deposits[POSTS];
	struct soil_measured measured;
	int64_t compacted;
	uint64_t confined, refused;
	struct post_rect posts; /* that soil may slide from: changed, or free posts of the bands */
};
static struct field field;
static struct laid laid[2]; /* on the GPU, on the CPU */

static int width_of(const struct field *of)
{
	return (int)(of->write.x1 - of->write.x0);
}

static int count_of(const struct field *of)
{
	return width_of(of) * (int)(of->write.y1 - of->write.y0);
}

static struct deform_window window_of(const struct field *of)
{
	return (struct deform_window){.write = of->write, .read = {of->write.x0 - 1, of->write.y0 - 1, of->write.x1 + 1, of->write.y1 + 1}};
}

/* --- on the GPU --- */

/* Reads what its passes hand on (lib/laying.glsl). */
static void read_state(struct ground *ground, const struct deform_window *window, struct laid *to)
{
	uint32_t state[47];
	gpu_buffer_read(ground->deform->laying, 0, sizeof state, state);
	soil_measured_begin(&to->measured);
	to->measured.carried = (int64_t)((uint64_t)state[5] << 32 | state[4]);
	to->measured.givers = state[6];
	to->measured.deep = (int32_t)state[7];
	to->measured.classes = state[8];
	for (int k = 0; k < 2 && state[9] != 0; k++) {
		to->measured.most[k] = (int32_t)(state[9 + 2 * k] - BIAS);
		to->measured.least[k] = (int32_t)(BIAS - state[10 + 2 * k]);
	}
	to->posts = (struct post_rect){0, 0, 0, 0};
	if (state[0] != 0)
		to->posts = (struct post_rect){window->read.x0 + BIAS - state[1], window->read.y0 + BIAS - state[3],
					       window->read.x0 + (int64_t)state[0] - BIAS + 1, window->read.y0 + (int64_t)state[2] - BIAS + 1};
}

static void lay_on_gpu(struct ground *ground, const struct deform_contact *contact, struct laid *to)
{
	struct deform *deform = ground->deform;
	const struct deform_window window = window_of(&field);
	const struct gpu_rect rect = rect_of(1, 1, (uint32_t)width_of(&field), (uint32_t)(count_of(&field) / width_of(&field)));
	struct deform_tally before, after;
	gpu_texture_upload(deform->bases, 0, rect, field.base);
	gpu_texture_upload(deform->contacts, 0, rect, field.contact);
	gpu_texture_upload(deform->carried, 0, rect, field.carried);
	gpu_texture_upload(deform->planes_of[1][PLANE_OFFSET], 0, rect, field.offset);
	if (deform->classes != NULL)
		gpu_texture_upload(deform->classes, 0, rect, field.classes);
	assert_ok(deform_tally(deform, &before));
	const struct spread_params params = deform_spread_params(deform, contact, &window, 0);
	assert_ok(deform_spread(deform, contact, &params, &window, 0));
	gpu_texture_read(deform->deposits, 0, rect, to->deposits);
	assert_ok(deform_tally(deform, &after));
	to->compacted = after.compacted - before.compacted;
	to->confined = after.confined - before.confined;
	to->refused = after.refused - before.refused;
	read_state(ground, &window, to);
}

/* --- on the CPU --- */

static void measure(const struct deform *deform, const struct deform_contact *contact, const struct soil_laid *soils, struct soil_measured *measured)
{
	const struct soil_laying laying = deform_laying(deform, contact);
	const struct post_rect shadow = post_rect_intersect(deform_shadow(deform, contact), field.write);
	soil_measured_begin(measured);
	for (int64_t y = shadow.y0; y < shadow.y1; y++) {
		const int64_t at = (y - field.write.y0) * width_of(&field) + shadow.x0 - field.write.x0;
		const struct soil_row row = {
			.x = shadow.x0, .y = y, .count = (int)(shadow.x1 - shadow.x0), .contact = field.contact + at, .carried = field.carried + at,
			.offset = field.offset + at, .classes = deform->classes != NULL ? field.classes + at : NULL,
		};
		if (row.count > 0)
			soil_measure_row(measured, &laying, soils, &row);
	}
}

static void lay(const struct deform *deform, const struct deform_contact *contact, const struct soil_laid *soils, struct laid *to)
{
	const struct soil_laying laying = deform_laying(deform, contact);
	const struct soil_planes planes = {.rect = field.write, .width = (size_t)width_of(&field), .base = field.base, .contact = field.contact};
	const size_t bytes = soil_lay_scratch(planes.width, (size_t)(field.write.y1 - field.write.y0));
	unsigned char *scratch = mem_alloc(bytes + 1, 1);
	struct soil_lay_result result;
	assert_non_null(scratch);
	memset(scratch, 0xa5, bytes + 1);
	memset(to->deposits, 0, sizeof to->deposits);
	soil_lay(&laying, &to->measured, soils, &planes, field.patch, NULL, field.write, scratch, to->deposits, &result);
	assert_int_equal(scratch[bytes], 0xa5);
	mem_free(scratch);
	to->compacted = result.compacted;
	to->confined = result.confined;
	to->refused = result.refused;
	to->posts = result.posts;
}

/* --- both --- */

/* The GPU adds the posts that the contact reached, too. */
static void widen_to_reached(const struct deform *deform, const struct deform_contact *contact, struct post_rect *posts)
{
	const struct post_rect shadow = post_rect_intersect(deform_shadow(deform, contact), field.write);
	for (int64_t y = shadow.y0; y < shadow.y1; y++)
		for (int64_t x = shadow.x0; x < shadow.x1; x++)
			if ((field.contact[(y - field.write.y0) * width_of(&field) + x - field.write.x0] & ~SOIL_NO_GROUND) != 0)
				*posts = post_rect_around(*posts, (struct post_rect){x, y, x + 1, y + 1});
}

static void assert_same(int round, const struct deform_contact *contact)
{
	const struct laid *a = &laid[0], *b = &laid[1];
	int64_t sum = b->compacted;
	for (int i = 0; i < count_of(&field); i++) {
		if (a->deposits[i] != b->deposits[i])
			fail_msg("round %d, shape %d: post %d, %d gets %d on the GPU, %d on the CPU", round, contact->shape->kind, i % width_of(&field),
				 i / width_of(&field), a->deposits[i], b->deposits[i]);
		sum += b->deposits[i];
	}
	assert_true(sum == b->measured.carried);
	assert_true(a->compacted == b->compacted && a->confined == b->confined && a->refused == b->refused);
}

static void assert_measured_alike(void)
{
	const struct soil_measured *a = &laid[0].measured, *b = &laid[1].measured;
	assert_true(a->carried == b->carried && a->givers == b->givers && a->deep == b->deep && a->classes == b->classes);
	assert_memory_equal(a->least, b->least, sizeof a->least);
	assert_memory_equal(a->most, b->most, sizeof a->most);
}

static double between(double low, double high)
{
	return low + (high - low) * (any_share() + 1) / 2;
}

static float corners[4][3] = {{-0.3f, -0.2f, -0.2f}, {0.4f, -0.2f, -0.1f}, {0.0f, 0.3f, -0.2f}, {0.0f, 0.0f, 0.3f}};
static uint32_t triangles[4][3] = {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
static const struct soil_mesh mesh = {corners, triangles, 4, 4, {-0.3, -0.2, -0.2}, {0.4, 0.3, 0.3}};

/* A body of so many metres or so. */
static struct soil_shape any_shape(int kind, double size)
{
	struct soil_shape shape = {.kind = (enum soil_shape_kind)kind, .radius = size * between(0.5, 1), .width = size * between(0.3, 1),
				   .length = size * between(0.5, 1.5), .mesh = &mesh};
	for (int k = 0; k < 3; k++)
		shape.size[k] = size * between(0.5, 1.2);
	shape.belt = kind == SOIL_BOX && any_word() % 2 == 0;
	if (kind == SOIL_WHEEL && any_word() % 4 == 0) {
		shape.grousers = 12;
		shape.grouser_height = 0.1 * shape.radius;
		shape.grouser_thickness = 0.02 * shape.radius;
	}
	return shape;
}

/* Set down, rolled, braked, locked, spun, pushed aside, lowered, at any heading, also along the axes and the diagonals. */
static struct deform_contact any_contact(const struct ground *ground, const struct soil_shape *shape, int round)
{
	const double d = ground->params.spacing, middle = (double)ground->posts / 2, way = between(0.1, 3) * d;
	const double yaw = round % 4 == 0 ? (double)(any_word() % 16) * M_PI / 8 : 4 * any_share();
	struct deform_contact contact = {.shape = shape, .from = ground_pose(ground, middle + any_share(), middle + any_share(), 0)};
	contact.to = contact.from;
	contact.from.yaw = contact.to.yaw = yaw;
	const int motion = (int)(any_word() % 8);
	const double heading = yaw + (motion == 3 ? M_PI / 2 : motion == 4 ? between(-0.7, 0.7) : motion == 5 ? M_PI : 0);
	if (motion > 0) {
		contact.to.x += lattice_offset(way * cos(heading));
		contact.to.y += lattice_offset(way * sin(heading));
		contact.to.z += lattice_offset(motion == 6 ? -2 * way : 0.3 * way * any_share());
		contact.turned = (shape->belt ? way : way / shape->radius) * (motion == 5 ? -1 : 1) * (any_word() % 2 == 0 ? 1 : any_share() * 2);
	} else if (shape->belt) {
		contact.turned = way * any_share();
	}
	return contact;
}

static void fill(const struct ground *ground, const struct deform_contact *contact, int round)
{
	const struct deform *deform = ground->deform;
	const struct post_rect shadow = deform_shadow(deform, contact);
	const struct soil_laying laying = deform_laying(deform, contact);
	struct post_rect all = deform_spread_posts(deform, contact, shadow);
	/* Cut at the middle at most, as an edge of the world does. */
	if (round % 5 == 4) {
		all.x1 -= (int64_t)(any_word() % 8);
		all.y0 += (int64_t)(any_word() % (uint64_t)(1 + (shadow.y1 - all.y0) / 2));
	}
	all = post_rect_intersect(all, (struct post_rect){shadow.x0 - 60, shadow.y0 - 60, shadow.x0 - 60 + SIDE_POSTS, shadow.y0 - 60 + SIDE_POSTS});
	field.write = all;
	const double middle[2] = {(double)(shadow.x0 + shadow.x1 - 1) / 2, (double)(shadow.y0 + shadow.y1 - 1) / 2};
	const uint32_t blocked = round % 3 == 0 ? 0 : any_word() % 16, holed = any_word() % 4;
	/* The patch lies in the middle, or to one side of the body. */
	const double aside[2] = {round % 4 == 1 ? 0.4 * any_share() : 0, round % 4 == 1 ? 0.4 * any_share() : 0}, size = round % 4 == 1 ? 0.02 : 0.2;
	const bool full = round % 17 == 3; /* much soil, and hardly a free post */
	const int most = full ? 23 : (int)(any_word() % 24);
	for (int64_t y = all.y0, i = 0; y < all.y1; y++)
		for (int64_t x = all.x0; x < all.x1; x++, i++) {
			const double u = ((double)x - middle[0]) / (double)(shadow.x1 - shadow.x0), v = ((double)y - middle[1]) / (double)(shadow.y1 - shadow.y0);
			const bool below = x >= shadow.x0 && y >= shadow.y0 && x < shadow.x1 && y < shadow.y1;
			const double far = (u - aside[0]) * (u - aside[0]) + (v - aside[1]) * (v - aside[1]);
			const bool touched = below && far < size && any_word() % 16 != 0;
			/* Another body's. The GPU takes its posts for the patch if they lie in these rows. */
			const bool other = any_word() % 16 < blocked && !below && !(laying.around && y >= shadow.y0 && y < shadow.y1);
			const bool hole = !touched && (full ? any_word() % 512 > 0 : any_word() % 16 < holed);
			field.contact[i] = (uint8_t)(touched ? 1 + any_word() % 3 : other ? 1 + any_word() % 2 : any_word() % 2 * SOIL_NEAR);
			field.contact[i] |= hole ? SOIL_NO_GROUND : 0;
			field.patch[i] = touched ? field.contact[i] : 0;
			field.base[i] = hole ? BASE_NODATA : (int32_t)(any_word() >> 12);
			field.carried[i] = touched && any_word() % 8 != 0 ? full ? 1 << 23 : (int32_t)(any_word() % (1u << most)) : 0;
			field.offset[i] = any_word() % 8 == 0 ? 1000 : -(int32_t)(any_word() % (1u << most));
			field.classes[i] = (uint8_t)(any_word() % 4 * (uint32_t)(round % 2));
		}
}

/* Four soils of different angles; the first alone; those of a model that compacts a part. */
static struct ground_params any_ground(int round, struct soil_numbers soils[4])
{
	static const double spacings[] = {0.125, 0.04, 0.31, 0.02, 0.5};
	for (int i = 0; i < 4; i++) {
		assert_ok(soil_named("dry_sand", &soils[i]));
		soils[i].cohesion = 0;
		soils[i].friction_angle = soils[i].repose = soils[i].theta_in = soils[i].theta_out = soils[i].theta_stop = between(0.05, 1);
		soils[i].compression = between(0, 1);
	}
	return (struct ground_params){.cells = 64, .tiles = 5, .first = round % 7, .spacing = spacings[round % 5], .soils = soils,
				      .model = round % 2 == 0 ? DEFORM_SLIPPAGE : DEFORM_SUMNER, .soil_count = round % 3 == 0 ? 1 : 4};
}

static void the_cpu_lays_as_the_gpu_does(void **state)
{
	int64_t confined = 0, refused = 0, around = 0, carried = 0;
	(void)state;
	need_gpu();
	for (int world = 0; world < 10; world++) {
		struct soil_numbers soils[4];
		struct soil_laid rules[SOIL_CLASSES];
		struct ground ground;
		const struct ground_params params = any_ground(world, soils);
		ground_init(&ground, &params);
		deform_laid(ground.deform, rules);
		for (int round = 0; round < 70; round++) {
			const struct soil_shape shape = any_shape(round % SOIL_SHAPES, params.spacing * between(2, round % 10 == 9 ? 60 : 15));
			const struct deform_contact contact = any_contact(&ground, &shape, round);
			fill(&ground, &contact, round);
			lay_on_gpu(&ground, &contact, &laid[0]);
			measure(ground.deform, &contact, rules, &laid[1].measured);
			assert_measured_alike();
			lay(ground.deform, &contact, rules, &laid[1]);
			assert_same(round, &contact);
			widen_to_reached(ground.deform, &contact, &laid[1].posts);
			if (post_rect_empty(laid[0].posts))
				assert_true(post_rect_empty(laid[1].posts));
			else
				assert_memory_equal(&laid[0].posts, &laid[1].posts, sizeof laid[0].posts);
			confined += laid[1].confined > 0;
			refused += laid[1].refused > 0;
			around += deform_laying(ground.deform, &contact).around;
			carried += laid[1].measured.carried > 0;
		}
		ground_finish(&ground);
	}
	print_message("%lld contacts, %lld around; of %lld the soil was confined, of %lld refused\n", (long long)carried, (long long)around,
		      (long long)confined, (long long)refused);
	assert_true(carried > 600 && around > 100 && confined > 4 && refused > 4);
}

TEST_PROGRAM(laying)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_cpu_lays_as_the_gpu_does),
	};
	return cmocka_run_group_tests_name("soil/laying", tests, open_gpu, close_gpu);
}
