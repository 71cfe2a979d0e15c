/* Objects in the picture and their shadows: they cover what they must, and are what deform presses. Skipped without GL. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../gpu/staged.h"
#include "deform/reference/reference.h"
#include "render/objects.h"

#define WIDTH 256
#define HEIGHT 144
#define CELLS 64
#define POSTS (CELLS + 1)
#define GROUND 8000.0 /* metres */
#define OBJECTS EFFECT_BIT(EFFECT_OBJECTS)
#define SHADOW EFFECT_BIT(EFFECT_SHADOW)
#define FAR (600ll * 16384 / 16) /* tiles: about 10,000 km, and whole periods of the ground's pattern */

/* Tiles are 16 m wide. */
static const struct extent extent = {40000001, 40000001, 0.25, CELLS};
static const struct deform_shape wheel = {.kind = DEFORM_WHEEL, .radius = 0.5, .width = 0.4};
static const struct deform_shape lugged = {.kind = DEFORM_WHEEL, .radius = 0.5, .width = 0.4, .grousers = 11, .grouser_height = 0.06, .grouser_thickness = 0.09};
static const struct deform_shape ball = {.kind = DEFORM_SPHERE, .radius = 0.6};
static const struct deform_shape box = {.kind = DEFORM_BOX, .size = {1.2, 0.5, 0.3}};

static struct gpu *gpu; /* NULL: no GL */
static struct gpu_slots *slots;
static struct render *render;
static struct scene_object objects[4];
static struct terrain_selection selection;
static int64_t away; /* tiles east and north */
static int samples = 1; /* a pixel */

#define need_gpu()                                                                                 \
	do {                                                                                       \
		if (gpu == NULL)                                                                   \
			skip();                                                                    \
	} while (0)

#define assert_ok(call)                                                                            \
	do {                                                                                       \
		if ((call) != STATUS_OK)                                                           \
			fail_msg("%s", failure_message());                                         \
	} while (0)

static int open_gpu(void **state)
{
	enum status status = gpu_create(&(struct gpu_params){.draws = true}, &gpu);
	if (status == STATUS_NO_GL) {
		print_message("%s\n", failure_message());
		gpu = NULL;
		return 0;
	}
	return status == STATUS_OK ? 0 : -1;
}

static int close_gpu(void **state)
{
	gpu_destroy(gpu);
	return 0;
}

/* --- pictures of one tile, or of nothing, with objects --- */

static double flat(double x, double y)
{
	return GROUND;
}

/* A wall between y = 4 and y = 6. */
static double wall(double x, double y)
{
	return GROUND + (y > 4 && y < 6 ? 3 : 0);
}

/* `height` NULL: no ground at all. */
static void begin(uint64_t effects, double (*height)(double x, double y), const struct deform_shape *shapes, size_t count)
{
	static int32_t base[POSTS * POSTS];
	struct render_params params = {
		.gpu = gpu, .extent = &extent, .reference = 8192, .low = GROUND - 1, .high = GROUND + 4, .width = WIDTH,
		.height = HEIGHT, .effects = effects, .objects = objects, .object_count = count, .samples = samples,
	};
	for (size_t i = 0; i < count; i++)
		objects[i] = (struct scene_object){.name = "it", .shape = shapes[i]};
	assert_ok(gpu_slots_create(gpu, CELLS, 1, 0, &slots));
	params.slots = slots;
	assert_ok(render_create(&params, &render));
	for (int k = 0; height != NULL && k < POSTS * POSTS; k++)
		base[k] = lattice_base_relative(height(k % POSTS * extent.spacing, k / POSTS * extent.spacing), 8192);
	assert_ok(staged_upload_base(gpu, slots, CELLS, 0, base));
	selection.draw_count = height != NULL;
	selection.draws[0] = (struct terrain_draw){
		.tile = {0, (uint32_t)away, (uint32_t)away}, .quadrants = 15, .finest = true, .low = GROUND - 1, .high = GROUND + 4,
	};
}

static void end(void)
{
	render_destroy(render);
	gpu_slots_destroy(slots);
	render = NULL;
	slots = NULL;
}

/* Places are from the tile's corner, and from the ground. */
static struct render_camera camera_at(const double eye[3], const double target[3])
{
	double east = (double)away * 16;
	return (struct render_camera){{east + eye[0], east + eye[1], GROUND + eye[2]},
				      {east + target[0], east + target[1], GROUND + target[2]}, 0.9, {0}};
}

static struct render_object posed(size_t object, double x, double y, double z)
{
	double east = (double)away * 16;
	return (struct render_object){.object = object, .at = {east + x, east + y, GROUND + z}};
}

static uint8_t *draw(const struct render_camera *camera, const struct render_object *shown, size_t count)
{
	render_set_objects(render, shown, count);
	assert_ok(render_frame(render, camera, &selection));
	uint8_t *pixels = test_malloc(4 * WIDTH * HEIGHT);
	gpu_texture_read(render->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels);
	return pixels;
}

static int luminance(const uint8_t *pixels, int x, int y)
{
	const uint8_t *p = pixels + 4 * (WIDTH * y + x);
	return 2 * p[0] + 5 * p[1] + p[2];
}

static bool differs(const uint8_t *a, const uint8_t *b, int x, int y)
{
	return memcmp(a + 4 * (WIDTH * y + x), b + 4 * (WIDTH * y + x), 4) != 0;
}

/* Where a place is in the picture; pixels. */
static void project(const struct render_camera *camera, const double place[3], double at[2])
{
	struct render_axes axes;
	double v[3], part[3] = {0, 0, 0};
	render_axes(render, camera, &axes);
	for (int k = 0; k < 3; k++) {
		v[k] = place[k] - camera->eye[k];
		part[0] += v[k] * axes.right[k];
		part[1] += v[k] * axes.up[k];
		part[2] += v[k] * axes.forward[k];
	}
	at[0] = WIDTH / 2.0 + part[0] / part[2] * axes.focal;
	at[1] = HEIGHT / 2.0 + part[1] / part[2] * axes.focal;
}

/* --- silhouettes, by rays on the CPU --- */

/* The part of a ray within a slab, a cylinder about y, or a ball: narrows it. */
static void within_slab(double from, double step, double half, double part[2])
{
	double a = (-half - from) / step, b = (half - from) / step;
	part[0] = fmax(part[0], fmin(a, b));
	part[1] = fmin(part[1], fmax(a, b));
}

static void within_round(double a, double b, double c, double part[2])
{
	double root = b * b - a * c;
	if (root < 0)
		part[1] = -INFINITY;
	part[0] = fmax(part[0], (-b - sqrt(fmax(root, 0))) / a);
	part[1] = fmin(part[1], (-b + sqrt(fmax(root, 0))) / a);
}

/* Whether the ray meets the shape, cut by so much on all sides. */
static bool meets(const struct deform_shape *shape, const double from[3], const double step[3], double less)
{
	double part[2] = {0, INFINITY};
	if (shape->kind == DEFORM_BOX) {
		for (int k = 0; k < 3; k++)
			within_slab(from[k], step[k], shape->size[k] / 2 - less, part);
		return part[0] < part[1];
	}
	double r = shape->radius - less, y = shape->kind == DEFORM_SPHERE;
	within_round(step[0] * step[0] + step[2] * step[2] + y * step[1] * step[1], from[0] * step[0] + from[2] * step[2] + y * from[1] * step[1],
		     from[0] * from[0] + from[2] * from[2] + y * from[1] * from[1] - r * r, part);
	if (shape->kind == DEFORM_WHEEL)
		within_slab(from[1], step[1], shape->width / 2 - less, part);
	return part[0] < part[1];
}

/* By pixel: whether the shape, cut by `less`, is there; at its middle, or anywhere within `reach` pixels of that. */
static bool covers(const struct render_camera *camera, const struct render_object *object, const struct deform_shape *shape, double less,
		   double x, double y)
{
	struct render_axes axes;
	double own[3][3], from[3] = {0, 0, 0}, step[3] = {0, 0, 0};
	render_axes(render, camera, &axes);
	deform_axes(object->yaw, object->pitch, object->roll, object->turned, own);
	for (int k = 0; k < 3; k++) {
		double ray = axes.forward[k] + (x - WIDTH / 2.0) / axes.focal * axes.right[k] + (y - HEIGHT / 2.0) / axes.focal * axes.up[k];
		for (int i = 0; i < 3; i++) {
			from[i] += own[i][k] * (camera->eye[k] - object->at[k]);
			step[i] += own[i][k] * ray;
		}
	}
	return meets(shape, from, step, less);
}

/* Over nothing: what is drawn is the shape, but for a pixel at its edge and what its rounding takes. */
static void check_silhouette(const struct deform_shape *shape, const struct render_camera *camera, const struct render_object *object,
			     double rounding)
{
	uint8_t *without = draw(camera, object, 0), *with = draw(camera, object, 1);
	int covered = 0, wrong = 0;
	for (int y = 1; y < HEIGHT - 1; y++)
		for (int x = 1; x < WIDTH - 1; x++) {
			bool all = true, any = false, is = differs(without, with, x, y);
			for (int k = 0; k < 9; k++) {
				double px = x + 0.5 + k % 3 - 1, py = y + 0.5 + k / 3 - 1;
				all = all && covers(camera, object, shape, rounding, px, py);
				any = any || covers(camera, object, shape, 0, px, py);
			}
			covered += is;
			wrong += (all && !is) || (!any && is);
		}
	assert_int_equal(wrong, 0);
	assert_true(covered > 10);
	test_free(without);
	test_free(with);
}

static void objects_cover_what_they_must(void **state)
{
	need_gpu();
	const struct deform_shape shapes[3] = {wheel, ball, box};
	/* The wheel's shoulders, and that corners alone lie on a circle: less than half a pixel. */
	const double roundings[3] = {0.12 * 0.5, 0.002, 0};
	begin(OBJECTS, NULL, shapes, 3);
	for (size_t i = 0; i < 3; i++)
		for (int k = 0; k < 12; k++) {
			/* As large as the picture, smaller, and a few pixels. */
			double far = k % 3 == 0 ? 1.9 : k % 3 == 1 ? 7 : 20, turn = 0.7 * k;
			struct render_object object = posed(i, 8, 8, 1);
			object.yaw = 0.4 * k;
			object.turned = shapes[i].kind != DEFORM_BOX ? 1.1 * k : 0;
			object.pitch = shapes[i].kind == DEFORM_BOX ? 0.3 * k : 0;
			object.roll = shapes[i].kind == DEFORM_BOX ? -0.2 * k : 0;
			struct render_camera camera = camera_at((double[3]){8 + far * cos(turn), 8 + far * sin(turn), 1 + 0.3 * far},
								(double[3]){8.1, 8, 1.05});
			check_silhouette(&shapes[i], &camera, &object, roundings[i]);
		}
	end();
}

/* However they are put together into draws: what all of them cover is what each covers alone. */
static void each_is_drawn_where_it_is(void **state)
{
	need_gpu();
	const struct deform_shape shapes[4] = {box, wheel, box, ball};
	struct render_object shown[4];
	struct render_camera camera = camera_at((double[3]){8, 2, 2}, (double[3]){8, 8, 1});
	begin(OBJECTS, NULL, shapes, 4);
	for (size_t i = 0; i < 4; i++)
		shown[i] = posed(i, 5.3 + 1.8 * (double)i, 8, 1);
	uint8_t *none = draw(&camera, shown, 0), *all = draw(&camera, shown, 4);
	int covered[2] = {0, 0};
	for (size_t i = 0; i < 4; i++) {
		uint8_t *one = draw(&camera, &shown[i], 1);
		for (int k = 0; k < WIDTH * HEIGHT; k++)
			if (differs(none, one, k % WIDTH, k / WIDTH)) {
				assert_false(differs(one, all, k % WIDTH, k / WIDTH));
				covered[0]++;
			}
		test_free(one);
	}
	for (int k = 0; k < WIDTH * HEIGHT; k++)
		covered[1] += differs(none, all, k % WIDTH, k / WIDTH);
	assert_true(covered[0] > 1000 && covered[0] == covered[1]);
	test_free(none);
	test_free(all);
	end();
}

static void a_hill_hides_an_object(void **state)
{
	need_gpu();
	begin(OBJECTS, wall, &wheel, 1);
	struct render_object object = posed(0, 8, 9, 0.5);
	struct render_camera behind = camera_at((double[3]){8, 1, 1}, (double[3]){8, 9, 0.5});
	struct render_camera above = camera_at((double[3]){8, 1, 9}, (double[3]){8, 9, 0.5});
	for (int seen = 0; seen < 2; seen++) {
		const struct render_camera *camera = seen ? &above : &behind;
		uint8_t *without = draw(camera, &object, 0), *with = draw(camera, &object, 1);
		assert_int_equal(memcmp(without, with, 4 * WIDTH * HEIGHT) != 0, seen);
		test_free(without);
		test_free(with);
	}
	end();
}

static double difference(const uint8_t *a, const uint8_t *b)
{
	double sum = 0;
	for (int i = 0; i < 4 * WIDTH * HEIGHT; i++)
		sum += abs(a[i] - b[i]);
	return sum / (4 * WIDTH * HEIGHT);
}

/* A wheel of five spokes looks the same after a fifth of a turn, and not before; one with bars only by those too. */
static void a_wheel_is_seen_to_turn(void **state)
{
	need_gpu();
	const struct deform_shape shapes[2] = {wheel, lugged};
	begin(OBJECTS, NULL, shapes, 2);
	struct render_camera camera = camera_at((double[3]){8, 6.6, 1}, (double[3]){8, 8, 1});
	for (size_t i = 0; i < 2; i++) {
		uint8_t *pixels[3];
		const double turns[3] = {0, 2 * M_PI / 10, 2 * M_PI / 5};
		for (int k = 0; k < 3; k++) {
			struct render_object object = posed(i, 8, 8, 1);
			object.turned = turns[k];
			pixels[k] = draw(&camera, &object, 1);
		}
		double half = difference(pixels[0], pixels[1]), fifth = difference(pixels[0], pixels[2]);
		assert_true(half > 2);
		assert_true(i == 0 ? fifth < 0.15 * half : fifth > 0.2 * half);
		for (int k = 0; k < 3; k++)
			test_free(pixels[k]);
	}
	end();
}

/* --- what is drawn is what presses --- */

/* The lowest of the mesh's first detail above a place, by its triangles; INFINITY: it is not above it. */
static double lowest(const struct object_mesh *mesh, double axes[3][3], double x, double y)
{
	double low = INFINITY;
	for (uint32_t i = mesh->first[0]; i < mesh->first[1]; i += 3) {
		double p[3][3];
		for (int k = 0; k < 3; k++)
			for (int c = 0; c < 3; c++) {
				const float *at = mesh->corners[mesh->indices[i + (uint32_t)k]].at;
				p[k][c] = axes[0][c] * at[0] + axes[1][c] * at[1] + axes[2][c] * at[2];
			}
		double area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
		double u = ((x - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (y - p[0][1])) / area;
		double v = ((p[1][0] - p[0][0]) * (y - p[0][1]) - (x - p[0][0]) * (p[1][1] - p[0][1])) / area;
		if (fabs(area) > 1e-12 && u >= 0 && v >= 0 && u + v <= 1)
			low = fmin(low, p[0][2] + u * (p[1][2] - p[0][2]) + v * (p[2][2] - p[0][2]));
	}
	return low;
}

static void lugs_are_drawn_where_they_press(void **state)
{
	struct object_mesh mesh;
	assert_ok(render_object_mesh_make(&lugged, &mesh));
	double shoulder = 0.35 * lugged.width / 2, steepest = 0;
	size_t bars = 0, compared = 0;
	for (int k = 0; k < 5; k++) {
		struct deform_contact sweep = {.shape = &lugged, .from = {.yaw = 0.6 * k, .turn = 0.37 * k}};
		double axes[3][3], yaw = 0.6 * k;
		sweep.to = sweep.from;
		deform_axes(yaw, 0, 0, sweep.to.turn, axes);
		for (int i = -60; i <= 60; i++) {
			double u = 0.0091 * i, side = (i % 3) * 0.4 * (lugged.width / 2 - shoulder);
			double x = u * cos(yaw) - side * sin(yaw), y = u * sin(yaw) + side * cos(yaw);
			long double z;
			bool is = reference_underside(&sweep, x, y, &z);
			double drawn = lowest(&mesh, axes, x, y);
			/* A bar's flank is steep: there a little aside is much higher. */
			long double left, right;
			bool beside = reference_underside(&sweep, x - 0.002 * cos(yaw), y - 0.002 * sin(yaw), &left) &&
				      reference_underside(&sweep, x + 0.002 * cos(yaw), y + 0.002 * sin(yaw), &right);
			if (!is || !beside)
				continue;
			double slack = 0.0015 + fabs((double)(left - right));
			steepest = fmax(steepest, fabs((double)(left - right)));
			if (fabs(drawn - (double)z) > slack)
				fail_msg("at %g of turn %g: %g drawn, %g presses", u, sweep.to.turn, drawn, (double)z);
			bars += drawn < -0.5 - 0.03;
			compared++;
		}
	}
	assert_true(bars > 30 && compared > 500 && steepest > 0.03);
	render_object_mesh_finish(&mesh);
}

/* Turned outward, closed, and of the volume that the shape has. */
static void meshes_are_closed_and_turned_outward(void **state)
{
	static const struct {
		const struct deform_shape *shape;
		double least, most; /* m3 */
	} shapes[] = {
		{&ball, 0.98 * 4 / 3 * M_PI * 0.6 * 0.6 * 0.6, 4.0 / 3 * M_PI * 0.6 * 0.6 * 0.6},
		{&box, 1.2 * 0.5 * 0.3 * 0.9999, 1.2 * 0.5 * 0.3 * 1.0001},
		{&wheel, 0.6 * M_PI * 0.25 * 0.4, M_PI * 0.25 * 0.4},
	};
	for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
		struct object_mesh mesh;
		double volume = 0;
		assert_ok(render_object_mesh_make(shapes[i].shape, &mesh));
		assert_true(mesh.closed);
		for (uint32_t t = mesh.first[0]; t < mesh.first[1]; t += 3) {
			const float *a = mesh.corners[mesh.indices[t]].at, *b = mesh.corners[mesh.indices[t + 1]].at, *c = mesh.corners[mesh.indices[t + 2]].at;
			for (int k = 0; k < 3; k++)
				volume += (double)a[k] * ((double)b[(k + 1) % 3] * c[(k + 2) % 3] - (double)b[(k + 2) % 3] * c[(k + 1) % 3]) / 6;
		}
		if (volume < shapes[i].least || volume > shapes[i].most)
			fail_msg("shape %zu: %g m3, not %g to %g", i, volume, shapes[i].least, shapes[i].most);
		assert_in_range((mesh.first[1] - mesh.first[0]) / 3, 12, 3200);
		render_object_mesh_finish(&mesh);
	}
}

/* --- shadows --- */

/* The way the light goes along the ground: the sun is in the south-east. */
static void shadow_way(double way[2])
{
	way[0] = -sin(2.35);
	way[1] = -cos(2.35);
}

static void a_shadow_lies_beside_its_object_away_from_the_sun(void **state)
{
	need_gpu();
	const struct deform_shape shapes[3] = {wheel, ball, box};
	const double heights[3] = {0.5, 0.6, 0.15};
	double way[2];
	shadow_way(way);
	for (size_t i = 0; i < 3; i++) {
		uint8_t *pixels[2];
		struct render_object object = posed(i, 8, 8, heights[i]);
		struct render_camera camera = camera_at((double[3]){8, 7.9, 9}, (double[3]){8, 8, 0});
		double at[2], radius = heights[i];
		object.yaw = 0.5;
		for (int k = 0; k < 2; k++) {
			begin(OBJECTS | (k > 0 ? SHADOW : 0), flat, shapes, 3);
			pixels[k] = draw(&camera, &object, 1);
			if (k == 0)
				end();
		}
		int darker = 0;
		for (int y = 0; y < HEIGHT; y++)
			for (int x = 0; x < WIDTH; x++) {
				assert_true(luminance(pixels[1], x, y) <= luminance(pixels[0], x, y) + 1);
				darker += luminance(pixels[1], x, y) < 0.8 * luminance(pixels[0], x, y);
			}
		assert_true(darker > 20 && darker < WIDTH * HEIGHT / 8);
		/* In the shadow, beyond its end, toward the sun, and the object itself. */
		const struct {
			double along, least, most;
		} places[] = {{1.9 * radius, 0.42, 0.7}, {5 * radius, 0.97, 1.03}, {-3 * radius, 0.97, 1.03}, {0, 0.97, 1.03}};
		for (size_t k = 0; k < 4; k++) {
			/* The box is wider than it is high. */
			double along = places[k].along + (i == 2 && places[k].along != 0 ? copysign(0.28, places[k].along) : 0);
			double place[3] = {object.at[0] + way[0] * along, object.at[1] + way[1] * along, GROUND};
			project(&camera, place, at);
			double ratio = (double)luminance(pixels[1], (int)at[0], (int)at[1]) / luminance(pixels[0], (int)at[0], (int)at[1]);
			if (ratio < places[k].least || ratio > places[k].most)
				fail_msg("shape %zu, %g m along its shadow: %g of the light", i, along, ratio);
		}
		end();
		test_free(pixels[0]);
		test_free(pixels[1]);
	}
}

/* The sky, and what is far behind or before the volume, is left alone. */
static void a_shadow_is_on_the_ground_alone(void **state)
{
	need_gpu();
	uint8_t *pixels[2];
	begin(OBJECTS | SHADOW, NULL, &ball, 1);
	struct render_camera camera = camera_at((double[3]){8, 4, 1}, (double[3]){8, 8, 0.5});
	struct render_object object = posed(0, 8, 8, 0.6);
	for (int k = 0; k < 2; k++) {
		render->objects->casts = k > 0;
		pixels[k] = draw(&camera, &object, 1);
	}
	assert_memory_equal(pixels[0], pixels[1], 4 * WIDTH * HEIGHT);
	end();
	test_free(pixels[0]);
	test_free(pixels[1]);
	/* High above the ground its shadow has faded. */
	begin(OBJECTS | SHADOW, flat, &ball, 1);
	object = posed(0, 8, 8, 9);
	camera = camera_at((double[3]){8, 7.9, 14}, (double[3]){8, 8, 0});
	for (int k = 0; k < 2; k++) {
		render->objects->casts = k > 0;
		pixels[k] = draw(&camera, &object, 1);
	}
	assert_memory_equal(pixels[0], pixels[1], 4 * WIDTH * HEIGHT);
	end();
	test_free(pixels[0]);
	test_free(pixels[1]);
}

static void with_samples_a_shadow_lies_there_too(void **state)
{
	need_gpu();
	if (gpu_info(gpu)->samples_most < 4)
		skip();
	samples = 4;
	a_shadow_lies_beside_its_object_away_from_the_sun(state);
	a_shadow_is_on_the_ground_alone(state);
	samples = 1;
}

/* Wherever the eye is, in the volume too. */
/* Larger and back: the very picture it was, shadow and all, in as many bytes. */
static void resized_it_is_as_if_it_had_been_so(void **state)
{
	need_gpu();
	const struct render_camera camera = camera_at((const double[3]){8, 2, 2.5}, (const double[3]){8, 8, 0});
	const struct render_object shown = posed(0, 8, 8, 0.5);
	for (samples = 1; samples <= 4 && samples <= (int)gpu_info(gpu)->samples_most; samples += 3) {
		struct gpu_stats before, after;
		begin(OBJECTS | SHADOW, flat, &wheel, 1);
		uint8_t *first = draw(&camera, &shown, 1);
		gpu_stats(gpu, &before);
		assert_ok(render_resize(render, 2 * WIDTH, HEIGHT - 4));
		render_set_objects(render, &shown, 1);
		assert_ok(render_frame(render, &camera, &selection));
		assert_ok(render_resize(render, WIDTH, HEIGHT));
		gpu_stats(gpu, &after);
		assert_true(after.bytes == before.bytes);
		uint8_t *second = draw(&camera, &shown, 1);
		assert_memory_equal(first, second, 4 * WIDTH * HEIGHT);
		render_set_objects(render, NULL, 0);
		uint8_t *without = draw(&camera, NULL, 0);
		assert_memory_not_equal(without, second, 4 * WIDTH * HEIGHT);
		test_free(first);
		test_free(second);
		test_free(without);
		mem_fail_nth(2, 0);
		enum status status = render_resize(render, 2 * WIDTH, HEIGHT);
		mem_fail_nth(0, 0);
		assert_int_equal(status, STATUS_FAILED);
		end();
	}
	samples = 1;
}

static void an_eye_within_the_volume_sees_the_shadow(void **state)
{
	need_gpu();
	uint8_t *pixels[2];
	double way[2];
	shadow_way(way);
	const struct deform_shape large = {.kind = DEFORM_SPHERE, .radius = 3};
	struct render_camera camera = camera_at((double[3]){8 + 4 * way[0], 8 + 4 * way[1], 0.4}, (double[3]){8 + 5 * way[0], 8 + 5 * way[1], 0});
	struct render_object object = posed(0, 8, 8, 3);
	begin(OBJECTS | SHADOW, flat, &large, 1);
	for (int k = 0; k < 2; k++) {
		render->objects->casts = k > 0;
		pixels[k] = draw(&camera, &object, 1);
	}
	assert_true(luminance(pixels[1], WIDTH / 2, HEIGHT / 2) < 0.7 * luminance(pixels[0], WIDTH / 2, HEIGHT / 2));
	end();
	test_free(pixels[0]);
	test_free(pixels[1]);
}

/* --- everywhere, as many, and as few --- */

static void ten_thousand_kilometres_away_it_is_the_same(void **state)
{
	need_gpu();
	uint8_t *pixels[2];
	for (int far = 0; far < 2; far++) {
		away = far * FAR;
		begin(OBJECTS | SHADOW | EFFECT_BIT(EFFECT_FOG), flat, &lugged, 1);
		struct render_object object = posed(0, 8.123, 8.456, 0.49);
		object.yaw = 1;
		object.turned = 0.3;
		struct render_camera camera = camera_at((double[3]){6, 5, 2}, (double[3]){8, 8, 0.3});
		pixels[far] = draw(&camera, &object, 1);
		end();
	}
	away = 0;
	assert_true(difference(pixels[0], pixels[1]) < 0.02);
	test_free(pixels[0]);
	test_free(pixels[1]);
}

static void what_is_small_or_out_of_sight_costs_less(void **state)
{
	need_gpu();
	const struct deform_shape shapes[4] = {lugged, lugged, lugged, box};
	struct gpu_stats before, after;
	begin(OBJECTS | SHADOW, NULL, shapes, 4);
	assert_ptr_equal(render->objects->shapes[2].corners, NULL); /* two shapes */
	struct render_camera camera = camera_at((double[3]){8, 4, 1}, (double[3]){8, 8, 1});
	/* Near, farther, far, behind: three draws, of ever fewer triangles; then two that are alike. */
	uint64_t triangles[5];
	const double places[5] = {5.2, 10, 60, 2, 10};
	struct render_object shown[2];
	for (int k = 0; k < 5; k++) {
		shown[0] = posed(0, 8, places[k], 1);
		shown[1] = posed(1, 8.2, places[k] + 0.1, 1);
		gpu_stats(gpu, &before);
		test_free(draw(&camera, shown, k < 4 ? 1 : 2));
		gpu_stats(gpu, &after);
		assert_int_equal(after.passes[GPU_OBJECTS] - before.passes[GPU_OBJECTS], k != 3);
		triangles[k] = render_triangles(render);
		struct render_tiles tiles;
		render_tiles(render, &tiles);
		assert_int_equal(tiles.objects, k != 3);
		assert_int_equal(tiles.shadowed, after.passes[GPU_SHADOW] - before.passes[GPU_SHADOW]);
	}
	assert_true(triangles[0] > 1.5 * triangles[1] && triangles[1] > triangles[2] && triangles[2] > 0);
	assert_int_equal(triangles[3], 0);
	assert_int_equal(triangles[4], 2 * triangles[1]);
	/* A box has one detail, which is drawn however small it is. */
	shown[0] = posed(3, 8, 60, 1);
	test_free(draw(&camera, shown, 1));
	assert_int_equal(render_triangles(render), 12);
	end();
}

static void a_million_triangles_draw(void **state)
{
	need_gpu();
	enum { ROUND = 1000, RINGS = 501 };
	static float vertices[ROUND * RINGS][3];
	static uint32_t triangles[2 * ROUND * (RINGS - 1)][3];
	struct deform_mesh mesh = {vertices, triangles, ROUND * RINGS, 2 * ROUND * (RINGS - 1), {-0.6, -0.6, -0.6}, {0.6, 0.6, 0.6}};
	for (uint32_t i = 0; i < ROUND * RINGS; i++) {
		double turn = 2 * M_PI * (i % ROUND) / ROUND, down = M_PI * (0.0005 + 0.999 * (i / ROUND) / (RINGS - 1));
		vertices[i][0] = (float)(0.6 * sin(down) * cos(turn));
		vertices[i][1] = (float)(0.6 * sin(down) * sin(turn));
		vertices[i][2] = (float)(0.6 * cos(down));
	}
	for (uint32_t i = 0, k = 0; i < ROUND * (RINGS - 1); i++) {
		uint32_t next = i % ROUND == ROUND - 1 ? i + 1 - ROUND : i + 1;
		const uint32_t two[2][3] = {{i, i + ROUND, next + ROUND}, {i, next + ROUND, next}};
		memcpy(triangles[k], two[i % 2], sizeof two[0]); /* in an order of its own, either way round */
		triangles[k + 1][0] = two[1 - i % 2][2];
		triangles[k + 1][1] = two[1 - i % 2][1];
		triangles[k + 1][2] = two[1 - i % 2][0];
		k += 2;
	}
	const struct deform_shape shape = {.kind = DEFORM_MESH, .mesh = &mesh};
	begin(OBJECTS, NULL, &shape, 1);
	struct render_object object = posed(0, 8, 8, 1);
	for (int k = 0; k < 2; k++) {
		struct render_camera camera = camera_at((double[3]){8, k > 0 ? 1 : 6, 1.2}, (double[3]){8, 8, 1});
		check_silhouette(&ball, &camera, &object, 0.01);
		assert_int_equal(render_triangles(render), 1000000);
	}
	/* Lit from outside, whichever way round its triangles are: the top is, the bottom is not. */
	struct render_camera camera = camera_at((double[3]){8, 6, 1}, (double[3]){8, 8, 1});
	uint8_t *pixels = draw(&camera, &object, 1);
	int top = luminance(pixels, WIDTH / 2, HEIGHT / 2 + 30), bottom = luminance(pixels, WIDTH / 2, HEIGHT / 2 - 35);
	assert_true(top > 1.5 * bottom && bottom > 0);
	for (int x = WIDTH / 2 - 20; x < WIDTH / 2 + 20; x++)
		assert_true(abs(luminance(pixels, x, HEIGHT / 2 + 30) - luminance(pixels, x + 1, HEIGHT / 2 + 30)) < 80);
	test_free(pixels);
	end();
}

static void none_is_there_that_was_not_named(void **state)
{
	need_gpu();
	struct gpu_stats before, after[2];
	gpu_stats(gpu, &before);
	for (int k = 0; k < 2; k++) {
		begin(SHADOW, flat, &wheel, (size_t)k); /* no objects are named; no object is there */
		assert_false(render_shows_objects(render));
		struct render_object object = posed(0, 8, 8, 0.5);
		struct render_camera camera = camera_at((double[3]){8, 4, 1}, (double[3]){8, 8, 1});
		test_free(draw(&camera, &object, (size_t)k));
		gpu_stats(gpu, &after[k]);
		end();
	}
	assert_int_equal(after[0].bytes, after[1].bytes);
	assert_int_equal(after[1].passes[GPU_OBJECTS], before.passes[GPU_OBJECTS]);
	assert_int_equal(after[1].passes[GPU_SHADOW], before.passes[GPU_SHADOW]);
}

static void what_cannot_be_allocated_is_told(void **state)
{
	need_gpu();
	objects[0] = (struct scene_object){.name = "it", .shape = wheel};
	struct render_params params = {
		.gpu = gpu, .extent = &extent, .low = 0, .high = 1, .width = 32, .height = 16, .effects = OBJECTS | SHADOW,
		.objects = objects, .object_count = 1,
	};
	assert_ok(gpu_slots_create(gpu, CELLS, 1, 0, &slots));
	params.slots = slots;
	enum status status = STATUS_FAILED;
	int failed = 0;
	for (uint64_t nth = 1; status != STATUS_OK; nth++) {
		mem_fail_nth(nth, 0);
		status = render_create(&params, &render);
		mem_fail_nth(0, 0);
		failed += status != STATUS_OK;
		assert_true(nth < 100);
	}
	assert_true(failed >= 15);
	end();
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(objects_cover_what_they_must),
		cmocka_unit_test(each_is_drawn_where_it_is),
		cmocka_unit_test(a_hill_hides_an_object),
		cmocka_unit_test(a_wheel_is_seen_to_turn),
		cmocka_unit_test(lugs_are_drawn_where_they_press),
		cmocka_unit_test(meshes_are_closed_and_turned_outward),
		cmocka_unit_test(a_shadow_lies_beside_its_object_away_from_the_sun),
		cmocka_unit_test(a_shadow_is_on_the_ground_alone),
		cmocka_unit_test(with_samples_a_shadow_lies_there_too),
		cmocka_unit_test(resized_it_is_as_if_it_had_been_so),
		cmocka_unit_test(an_eye_within_the_volume_sees_the_shadow),
		cmocka_unit_test(ten_thousand_kilometres_away_it_is_the_same),
		cmocka_unit_test(what_is_small_or_out_of_sight_costs_less),
		cmocka_unit_test(a_million_triangles_draw),
		cmocka_unit_test(none_is_there_that_was_not_named),
		cmocka_unit_test(what_cannot_be_allocated_is_told),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
