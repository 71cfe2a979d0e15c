/* Lower envelopes on the CPU have the same bits as the GPU's, of all shapes, attitudes and motions, at any spacing and any place. */
#include "../long.h"
#include "../support/program.h"
#include "window.h"

#include "soil/kinematic/rows.h"

static const double spacings[] = {1, 0.5, 0.25, 0.0903, 0.0625, 0.1 / 3, 0.015625, 0.01};

/* Both envelopes over the whole window, also where the body cannot be. Returns the posts that it is above. */
static int compare(struct ground *ground, const struct deform_contact *contact)
{
	const bool moves = !deform_is_contact_only(contact);
	struct under_motion motion = {.shape = contact->shape, .from = moves ? &contact->from : &contact->to, .to = &contact->to, .turned = contact->turned,
				      .spacing = ground->params.spacing};
	struct facet_corner corners[64];
	assert_ok(deform_windows(ground->deform, contact, ground->windows, &ground->window_count));
	const struct deform_window whole = deform_whole(ground->deform, &ground->windows[0]);
	assert_ok(deform_envelope(ground->deform, contact, &whole, 0));
	motion.posts = whole.read;
	const int64_t width = motion.posts.x1 - motion.posts.x0, height = motion.posts.y1 - motion.posts.y0;
	const size_t stride = soil_under_stride(width);
	int32_t *under = ground_room((int64_t)stride * height, 4), *rest = ground_room((int64_t)stride * height, 4), *of_gpu = ground_room(width * height, 4);
	int above = 0;
	soil_under(&motion, corners, under, rest);
	for (int which = 0; which < 2; which++) {
		gpu_texture_read(which == 0 ? ground->deform->under : ground->deform->rest, 0, rect_of(0, 0, (uint32_t)width, (uint32_t)height), of_gpu);
		for (int64_t i = 0; i < width * height; i++) {
			const int32_t height_here = (which == 0 ? under : rest)[(size_t)(i / width) * stride + (size_t)(i % width)];
			if (height_here != of_gpu[i])
				fail_msg("%s at post %lld, %lld: %d, on the GPU %d; shape %d, motion %lld %lld %lld, yaw %.17g", which == 0 ? "under" : "rest",
					 (long long)(i % width), (long long)(i / width), height_here, of_gpu[i], contact->shape->kind,
					 (long long)(contact->to.x - contact->from.x), (long long)(contact->to.y - contact->from.y),
					 (long long)(contact->to.z - contact->from.z), contact->to.yaw);
			above += of_gpu[i] != UNDER_NONE;
		}
	}
	/* A body is above no post beyond its shadow, so a contact looks at no other. */
	const struct post_rect shadow = deform_shadow(ground->deform, contact);
	for (int64_t i = 0; i < width * height; i++) {
		const int64_t x = whole.read.x0 + i % width, y = whole.read.y0 + i / width;
		if (x < shadow.x0 || x >= shadow.x1 || y < shadow.y0 || y >= shadow.y1)
			assert_int_equal(under[(size_t)(i / width) * stride + (size_t)(i % width)], UNDER_NONE);
	}
	mem_free(under);
	mem_free(rest);
	mem_free(of_gpu);
	return above;
}

static void many(int kind)
{
	const int count = long_run() ? 200 : kind == SOIL_MESH || kind == SOIL_SHAPES ? 22 : 44;
	int above = 0;
	for (size_t s = 0; s < sizeof spacings / sizeof *spacings; s++) {
		struct ground ground;
		const int64_t first = s % 3 == 0 ? 3 : s % 3 == 1 ? 40000 : 3000000; /* far from the origin, too */
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = first, .spacing = spacings[s], .model = DEFORM_SUMNER});
		for (int i = 0; i < count; i++) {
			/* From smaller than a cell to some thirty posts. */
			struct window_mesh mesh;
			const struct soil_shape shape = window_any_shape(kind, spacings[s] * exp2(3 + 2 * any_share()), &mesh);
			const struct deform_contact contact = window_any_contact(&ground, &shape, kind, i, i % 2 ? 0 : 300);
			above += compare(&ground, &contact);
		}
		ground_finish(&ground);
	}
	assert_true(above > 5000);
}

static void wheels_are_those_of_the_gpu(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_WHEEL);
}

static void spheres_are_those_of_the_gpu(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_SPHERE);
}

static void boxes_are_those_of_the_gpu(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_BOX);
}

static void meshes_are_those_of_the_gpu(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_MESH);
}

static void cylinders_are_those_of_the_gpu(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_CYLINDER);
}

static void capsules_are_those_of_the_gpu(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_CAPSULE);
}

static void ellipsoids_are_those_of_the_gpu(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_ELLIPSOID);
}

static void wheels_with_grousers_are_those_of_the_gpu(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_SHAPES);
}

static void wheels_with_camber_are_those_of_the_gpu(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_SHAPES + 1);
}

/* Square roots are exact, also beside squares. */
static void roots_are_whole(void **state)
{
	(void)state;
	for (int i = 0; i < 200000; i++) {
		const int64_t root = i < 1000 ? i : (int64_t)(any_word() >> (1 + any_word() % 31)), square = root * root;
		if (square >= (int64_t)1 << 60)
			continue;
		assert_int_equal(lane_root(square), root);
		assert_int_equal(lane_root(square + 2 * root), root);
		if (root > 0)
			assert_int_equal(lane_root(square - 1), root - 1);
	}
}

TEST_PROGRAM(envelope)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(wheels_are_those_of_the_gpu),
		cmocka_unit_test(spheres_are_those_of_the_gpu),
		cmocka_unit_test(boxes_are_those_of_the_gpu),
		cmocka_unit_test(meshes_are_those_of_the_gpu),
		cmocka_unit_test(cylinders_are_those_of_the_gpu),
		cmocka_unit_test(capsules_are_those_of_the_gpu),
		cmocka_unit_test(ellipsoids_are_those_of_the_gpu),
		cmocka_unit_test(wheels_with_grousers_are_those_of_the_gpu),
		cmocka_unit_test(wheels_with_camber_are_those_of_the_gpu),
		cmocka_unit_test(roots_are_whole),
	};
	return cmocka_run_group_tests_name("soil/envelope", tests, open_gpu, close_gpu);
}
