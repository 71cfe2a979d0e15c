/* A window as the GPU has it, and the same window in host memory. */
#ifndef FURROW_TESTS_SOIL_WINDOW_H
#define FURROW_TESTS_SOIL_WINDOW_H

#include "../deform/ground.h"
#include "soil/kinematic/kinematic.h"
#include "soil/kinematic/under.h"

/* A window's planes in host memory, and what the GPU makes of them. */
struct host_window {
	struct post_rect read, write;
	struct soil_planes planes;
	int32_t *carried;
	size_t posts;
	void *scratch;
};

static inline void *window_texture(struct gpu_texture *texture, const struct host_window *window, size_t bytes)
{
	const struct gpu_rect all = rect_of(0, 0, (uint32_t)window->planes.width, (uint32_t)(window->read.y1 - window->read.y0));
	void *posts = ground_room((int64_t)window->posts, bytes);
	gpu_texture_read(texture, 0, all, posts);
	return posts;
}

/* Copies what layer 0 holds after a gather. */
static inline void window_take(const struct ground *ground, const struct deform_window *from, struct host_window *window)
{
	const struct deform *deform = ground->deform;
	*window = (struct host_window){.read = from->read, .write = from->write};
	window->planes.rect = from->read;
	window->planes.width = (size_t)(from->read.x1 - from->read.x0);
	window->posts = window->planes.width * (size_t)(from->read.y1 - from->read.y0);
	window->planes.base = window_texture(deform->bases, window, 4);
	window->planes.offset = window_texture(deform->planes_of[0][PLANE_OFFSET], window, 4);
	window->planes.classes = deform->classes != NULL ? window_texture(deform->classes, window, 1) : NULL;
	window->planes.disturbance = deform->params.disturbance ? window_texture(deform->planes_of[0][PLANE_DISTURBANCE], window, 1) : NULL;
	window->planes.contact = ground_room((int64_t)window->posts, 1);
	window->carried = ground_room((int64_t)window->posts, 4);
}

static inline void window_drop(struct host_window *window)
{
	mem_free(window->planes.base);
	mem_free(window->planes.offset);
	mem_free(window->planes.classes);
	mem_free(window->planes.disturbance);
	mem_free(window->planes.contact);
	mem_free(window->carried);
	mem_free(window->scratch);
}

/* Compares a plane of the window with a texture of layer 0, within `posts`. */
static inline void window_compare(const struct host_window *window, const char *name, const void *plane, struct gpu_texture *texture, size_t bytes,
				  struct post_rect posts)
{
	char *of_gpu = window_texture(texture, window, bytes);
	for (size_t i = 0; i < window->posts; i++) {
		const int64_t x = window->read.x0 + (int64_t)(i % window->planes.width), y = window->read.y0 + (int64_t)(i / window->planes.width);
		if (x < posts.x0 || x >= posts.x1 || y < posts.y0 || y >= posts.y1 || memcmp(of_gpu + i * bytes, (const char *)plane + i * bytes, bytes) == 0)
			continue;
		int32_t one = 0, other = 0;
		memcpy(&one, (const char *)plane + i * bytes, bytes);
		memcpy(&other, of_gpu + i * bytes, bytes);
		fail_msg("%s at post %lld, %lld of the window: %d, on the GPU %d", name, (long long)(i % window->planes.width), (long long)(i / window->planes.width),
			 one, other);
	}
	mem_free(of_gpu);
}

/* Bodies of every kind in any attitude and motion. */

#define WINDOW_KINDS (SOIL_SHAPES + 2) /* all kinds; wheels with grousers; wheels with camber */

struct window_mesh {
	struct soil_mesh mesh;
	float vertices[64][3];
	uint32_t triangles[128][3];
};

/* A crumpled ball, which is concave. */
static inline void window_any_mesh(struct window_mesh *made, double size)
{
	const uint32_t around = 8, rings = 6;
	struct soil_mesh *mesh = &made->mesh;
	*mesh = (struct soil_mesh){.vertices = made->vertices, .triangles = made->triangles, .vertex_count = around * rings};
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		const double angle = 2 * M_PI * (i % around) / around, tilt = M_PI * (i / around) / (rings - 1), far = size / 2 * (0.7 + 0.3 * any_share());
		const double at[3] = {far * sin(tilt) * cos(angle), far * sin(tilt) * sin(angle), far * cos(tilt)};
		for (int k = 0; k < 3; k++) {
			made->vertices[i][k] = (float)at[k];
			mesh->low[k] = fmin(mesh->low[k], made->vertices[i][k]);
			mesh->high[k] = fmax(mesh->high[k], made->vertices[i][k]);
		}
	}
	for (uint32_t i = 0; i + around < mesh->vertex_count; i++) {
		const uint32_t next = i / around * around + (i + 1) % around;
		const uint32_t both[2][3] = {{i, next, i + around}, {next, next + around, i + around}};
		memcpy(made->triangles[mesh->triangle_count], both, sizeof both);
		mesh->triangle_count += 2;
	}
}

/* kind: 0 to WINDOW_KINDS - 1. size: m. */
static inline struct soil_shape window_any_shape(int kind, double size, struct window_mesh *mesh)
{
	struct soil_shape shape = {.kind = kind < SOIL_SHAPES ? (enum soil_shape_kind)kind : SOIL_WHEEL, .radius = size / 2, .mesh = &mesh->mesh};
	const bool box = shape.kind == SOIL_BOX;
	for (int k = 0; k < 3; k++)
		shape.size[k] = size * exp2(any_share()) / (box ? 1 : 2);
	shape.width = shape.kind == SOIL_WHEEL ? size * exp2(any_share() - 1) : 0;
	shape.length = shape.kind == SOIL_CYLINDER || shape.kind == SOIL_CAPSULE ? size * exp2(2 * any_share() - 1) : 0;
	if (shape.kind == SOIL_MESH)
		window_any_mesh(mesh, size);
	if (kind == SOIL_SHAPES) {
		shape.grousers = 3 + (int)(any_word() % 20);
		shape.grouser_height = size * 0.1 * (1 + any_share());
		shape.grouser_thickness = size * 0.06 * (1.2 + any_share());
	}
	return shape;
}

/* Every fourth motion goes straight up or down, every fourth is level. below: m that the centre is below the zero. */
static inline struct deform_contact window_any_contact(const struct ground *ground, const struct soil_shape *shape, int kind, int number, double below)
{
	static const double straight[] = {0, M_PI / 2, M_PI, M_PI / 4};
	const double middle = (double)ground->posts / 2, far = number % 5 == 0 ? 20 : 1.5, spacing = ground->params.spacing;
	const double dx = number % 4 == 1 ? 0 : any_share() * far, dy = number % 4 == 1 ? 0 : any_share() * far;
	const double dz = number % 4 == 2 ? 0 : any_share() * far * spacing * (number % 3 == 0 ? 3 : 0.5);
	const double x = middle + any_share(), y = middle + any_share();
	struct deform_contact contact = {.shape = shape, .from = ground_pose(ground, x, y, -below), .to = ground_pose(ground, x + dx, y + dy, dz - below)};
	contact.to.yaw = number % 7 == 3 ? straight[number % 4] : any_share() * 4;
	if (number % 7 == 5 && number % 4 != 1) /* along its heading, or exactly across it */
		contact.to.yaw = atan2(dy, dx) + (number % 2 ? M_PI / 2 : 0);
	if (shape->kind != SOIL_WHEEL && number % 3 != 0) {
		contact.to.pitch = number % 6 == 1 ? M_PI / 2 : any_share() * 4;
		contact.to.roll = number % 6 == 2 ? 0 : any_share() * 4;
	}
	if (kind > SOIL_SHAPES || (kind == SOIL_SHAPES && number % 3 == 0))
		contact.to.roll = number % 2 ? any_share() * 0.4 : exp2(-30 + 28 * fabs(any_share()));
	contact.to.turn = any_share() * 10;
	contact.turned = any_share();
	if (number % 11 == 10)
		contact.from = contact.to;
	return contact;
}

#endif
