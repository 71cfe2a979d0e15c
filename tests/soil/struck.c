/* The struck capacity of bodies whose hollow has a closed form: buckets of plates, and as meshes without thickness. */
#include "soil_test.h"

#include "../support/near.h"
#include "../support/program.h"
#include "meshes.h"

#define LENGTH 0.9
#define WIDTH 1.3
#define HEIGHT 0.6
#define PLATE 0.01

static double capacity_of(const struct soil_part *parts, size_t count)
{
	double capacity = -1;
	assert_ok(soil_struck_capacity(parts, count, &capacity));
	return capacity;
}

static struct soil_part part_of(const struct soil_shape *shape, double x, double y, double z)
{
	return (struct soil_part){shape, {x, y, z}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
}

/* A box of plates, whose walls stand inside its floor. sides: height of the two side walls; front: whether there is one. Returns how many plates it has. */
struct plates {
	struct soil_shape shapes[5];
	struct soil_part parts[5];
	size_t count;
};

static void add(struct plates *plates, const double size[3], double x, double y, double z)
{
	struct soil_shape *shape = &plates->shapes[plates->count];
	*shape = (struct soil_shape){.kind = SOIL_BOX, .size = {size[0], size[1], size[2]}};
	plates->parts[plates->count++] = part_of(shape, x, y, z);
}

static void make(struct plates *plates, double sides, bool front)
{
	*plates = (struct plates){.count = 0};
	add(plates, (double[]){LENGTH, WIDTH, PLATE}, 0, 0, -PLATE / 2);
	add(plates, (double[]){PLATE, WIDTH, HEIGHT}, -LENGTH / 2 + PLATE / 2, 0, HEIGHT / 2);
	if (front)
		add(plates, (double[]){PLATE, WIDTH, HEIGHT}, LENGTH / 2 - PLATE / 2, 0, HEIGHT / 2);
	for (int side = -1; side <= 1 && sides > 0; side += 2)
		add(plates, (double[]){LENGTH, PLATE, sides}, 0, side * (WIDTH - PLATE) / 2, sides / 2);
}

static void a_box_of_plates_holds_what_is_between_them(void **state)
{
	struct plates plates;
	const double inside = (LENGTH - 2 * PLATE) * (WIDTH - 2 * PLATE);
	(void)state;
	make(&plates, HEIGHT, true);
	print_message("box %g of %g m3\n", capacity_of(plates.parts, plates.count), inside * HEIGHT);
	assert_near(capacity_of(plates.parts, plates.count), inside * HEIGHT, 0.005 * inside * HEIGHT);
	make(&plates, 0.4 * HEIGHT, true); /* no more than its lower sides hold */
	assert_near(capacity_of(plates.parts, plates.count), inside * 0.4 * HEIGHT, 0.01 * inside * HEIGHT);
	make(&plates, 0, true); /* open at both sides */
	assert_near(capacity_of(plates.parts, plates.count), 0, 0.005 * inside * HEIGHT);
}

static void what_is_open_in_front_holds_a_wedge(void **state)
{
	struct plates plates;
	const double half = (WIDTH - 2 * PLATE) * (LENGTH - PLATE) * HEIGHT / 2;
	(void)state;
	make(&plates, HEIGHT, false);
	print_message("open in front %g of %g m3\n", capacity_of(plates.parts, plates.count), half);
	assert_near(capacity_of(plates.parts, plates.count), half, 0.02 * half); /* the plane ends at the plates' outer edge */
}

static void a_plate_a_blade_and_a_ball_hold_nothing(void **state)
{
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {1, 2, 0.1}}, blade = {.kind = SOIL_BOX, .size = {0.05, 2, 0.8}}, ball = {.kind = SOIL_SPHERE, .radius = 1};
	const struct soil_part list[] = {part_of(&plate, 0, 0, 0), part_of(&blade, 0, 0, 0), part_of(&ball, 0, 0, 0)};
	(void)state;
	for (size_t i = 0; i < 3; i++)
		assert_near(capacity_of(&list[i], 1), 0, 1e-12);
	assert_near(capacity_of(list, 0), 0, 1e-12);
}

/* A prism along y with two ends: its profile goes from (x, z) to (x, z). A wedge has three corners, a box four; the opening is from the last to the first one. */
static struct soil_mesh prism(const double (*profile)[2], uint32_t corners)
{
	struct soil_mesh mesh = mesh_with(2 * corners, 2 * (corners - 1) + 2 * (corners - 2));
	uint32_t t = 0;
	for (uint32_t i = 0; i < corners; i++)
		for (uint32_t side = 0; side < 2; side++) {
			mesh.vertices[2 * i + side][0] = (float)profile[i][0];
			mesh.vertices[2 * i + side][1] = (float)(side == 0 ? -WIDTH / 2 : WIDTH / 2);
			mesh.vertices[2 * i + side][2] = (float)profile[i][1];
		}
	for (uint32_t i = 0; i + 1 < corners; i++) {
		mesh_put(&mesh, t++, 2 * i, 2 * i + 1, 2 * i + 2);
		mesh_put(&mesh, t++, 2 * i + 1, 2 * i + 3, 2 * i + 2);
	}
	for (uint32_t i = 1; i + 1 < corners; i++)
		for (uint32_t side = 0; side < 2; side++)
			mesh_put(&mesh, t++, side, 2 * i + side, 2 * i + 2 + side);
	mesh_bounds(&mesh);
	return mesh;
}

static void meshes_without_thickness_hold_their_closed_form(void **state)
{
	static const double box[][2] = {{0.45, HEIGHT}, {0.45, 0}, {-0.45, 0}, {-0.45, HEIGHT}}, wedge[][2] = {{0.45, 0}, {-0.45, 0}, {-0.45, HEIGHT}};
	static const double round[][2] = {{0.3, 0}, {0.26, -0.15}, {0.15, -0.26}, {0, -0.3}, {-0.15, -0.26}, {-0.26, -0.15}, {-0.3, 0}};
	static const struct {
		const double (*profile)[2];
		uint32_t corners;
	} bodies[] = {{box, 4}, {wedge, 3}, {round, 7}};
	(void)state;
	for (size_t i = 0; i < sizeof bodies / sizeof *bodies; i++) {
		struct soil_mesh mesh = prism(bodies[i].profile, bodies[i].corners);
		const struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &mesh};
		double area = 0; /* the shoelace formula */
		for (uint32_t k = 0; k < bodies[i].corners; k++) {
			const double *a = bodies[i].profile[k], *b = bodies[i].profile[(k + 1) % bodies[i].corners];
			area += (a[1] * b[0] - a[0] * b[1]) / 2;
		}
		/* Also where its axes are turned: its rim is plane. */
		for (int turned = 0; turned < 2; turned++) {
			struct soil_part part = part_of(&shape, 3, -7, 100);
			soil_axes(turned ? M_PI / 2 : 0, 0, 0, 0, part.axes);
			const double told = capacity_of(&part, 1);
			print_message("profile of %u corners: %g of %g m3\n", bodies[i].corners, told, fabs(area) * WIDTH);
			assert_near(told, fabs(area) * WIDTH, 0.01 * fabs(area) * WIDTH);
		}
		mesh_free(&mesh);
	}
}

TEST_PROGRAM(struck)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_box_of_plates_holds_what_is_between_them),
		cmocka_unit_test(what_is_open_in_front_holds_a_wedge),
		cmocka_unit_test(a_plate_a_blade_and_a_ball_hold_nothing),
		cmocka_unit_test(meshes_without_thickness_hold_their_closed_form),
	};
	return cmocka_run_group_tests_name("soil/struck", tests, NULL, NULL);
}
