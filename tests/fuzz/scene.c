/*
 * Scenes: any text loads or is told in one line, twice the same, and takes no more memory than so
 * many times its length.
 *
 * An input: the scene; after a line SCENE_POSES, the file poses.csv that it may name; after a line
 * SCENE_SET, settings KEY=VALUE, one a line. No file but these two is ever opened: fopen is ours.
 */
#include "scene.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_mesh.h"

/* A node of the tree, its texts, the typed values and libyaml's: a byte "," or "-" makes a node. */
#define BYTES_A_BYTE 1024
#define BYTES_MORE (1u << 20)
#define SETTINGS_MAX 16

const size_t fuzz_size_max = 65536;
const char *const fuzz_words[] = {
	"scene: 1\n", "end_time: 1\n", "objects:\n", "  - name: b\n", "    shape: {sphere: {radius: 1}}\n",
	"    path: {points: [[1, 2]], speed: 3}\n", "    path: {file: poses.csv}\n", "wheel", "sphere", "box",
	"size: [1, 1, 1]", "loop: true", "sink: 0.1", "redistribute: {model: box, radius: 1, repetitions: 2}\n",
	"attributes: [dirt]\n", "outside: skip\n", "coordinates: store\n", "coordinates: EPSG:4326\n",
	"soil: {name: dry_sand}\n", "view:\n  size: [64, 48]\n", "  camera: {over: a, height: 3}\n",
	"  camera: {chase: a, back: 1, up: 2}\n", "  camera: {eye: [0, 0, 1], target: [1, 1, 0]}\n",
	"  effects: [texture, fog]\n", "  images: 5\n", "cache: {slots: 16, loaders: 1, prefetch: 0}\n",
	"spacing: 0.5\n", "gravity: 0\n", "time_step: 1e-3\n", "store: s.furrow\n", "nan", ".inf", "-.inf", "1e309",
	"0x10", "null", "~", "true", "[", "]", "{", "}", ": ", "- ", "\n", "  ", "\"", "'", "#", "&a ", "*a", "!!int ",
	"|\n", ">\n", "---\n", "...\n", "%YAML 1.1\n", "? ", "<<: ", "\\x2f", "\xef\xbb\xbf", "\xc3", "\xf4\x8f\xbf\xbf",
	"t,x,y,z,yaw,pitch,roll\n", "0,1,2\n", SCENE_POSES, SCENE_SET, "cache.slots=8\n", "objects.a.sink=1\n",
	"redistribute: {model: sumner, iterations: 2, interval: 0.1, depth: 1}\n", "redistribute: {model: slippage}\n",
	"redistribute: {model: scm, depth: 0.1, bulldozing: 0.4, slip_sinkage: 0.7}\n", "scm", "load: 4000", "slip: 0.2", "interface: {friction_angle: 20, adhesion: 300}", "interface",
	"shape: {mesh: {file: foot.obj, scale: 2}}", "lugs: 12, lug_height: 0.02, lug_thickness: 0.01",
	"output: {forces: 50, delay: 0}\n", "soil: {map: poses.csv, classes: {1: lunar, 2: {name: clayey_38}}, default: snow_us}\n",
	"soil: {cohesion: 0, friction_angle: 30, unit_weight: 16000, repose: 30}\n",
	"soil: {name: lunar, rasters: {cohesion: poses.csv, friction_angle: poses.csv}}\n", "rasters: {bekker_n: poses.csv}",
	"soil: {theta_in: 40, theta_out: 25, theta_stop: 40, roughness: 0.2, compression: 0.3}\n",
	"soil: {bekker_kc: -1, bekker_kphi: 100, bekker_n: 1}\n", "soil.classes.3=lunar\n", "objects.a.load=10\n",
	"view.camera={over: a, height: 3}\n", "objects=null\n", NULL,
};

/* --- nothing of the host --- */

FILE *__real_fopen64(const char *path, const char *mode);
FILE *__wrap_fopen64(const char *path, const char *mode);
FILE *__wrap_fopen(const char *path, const char *mode);
void __wrap_note(const char *format, ...);
enum status __wrap_scene_mesh_load(const char *path, const char *told, double scale, struct soil_mesh **out);
void __wrap_scene_mesh_destroy(struct soil_mesh *mesh);

static bool loading;

FILE *__wrap_fopen64(const char *path, const char *mode)
{
	if (!loading || strcmp(path, fuzz_path("scene.yaml")) == 0 || strcmp(path, fuzz_path("poses.csv")) == 0)
		return __real_fopen64(path, mode);
	errno = ENOENT;
	return NULL;
}

FILE *__wrap_fopen(const char *path, const char *mode)
{
	return __wrap_fopen64(path, mode);
}

/* Thousands of lines that nobody reads. */
void __wrap_note(const char *format, ...)
{
}

/* One mesh there is, without a reader; readers are tested with meshes. */
enum status __wrap_scene_mesh_load(const char *path, const char *told, double scale, struct soil_mesh **out)
{
	static const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
	static const uint32_t sides[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
	if (strcmp(path, fuzz_path("foot.obj")) != 0)
		return fail_with(STATUS_INPUT, "%s: not found; name a mesh", told);
	struct soil_mesh *mesh = mem_calloc(1, sizeof *mesh);
	fuzz_check(mesh != NULL);
	mesh->vertex_count = mesh->triangle_count = 4;
	mesh->vertices = mem_alloc(4, sizeof *mesh->vertices);
	mesh->triangles = mem_alloc(4, sizeof *mesh->triangles);
	fuzz_check(mesh->vertices != NULL && mesh->triangles != NULL);
	for (int i = 0; i < 12; i++)
		mesh->vertices[i / 3][i % 3] = corners[i / 3][i % 3] * (float)scale;
	memcpy(mesh->triangles, sides, sizeof sides);
	*out = mesh;
	return STATUS_OK;
}

void __wrap_scene_mesh_destroy(struct soil_mesh *mesh)
{
	if (mesh == NULL)
		return;
	mem_free(mesh->vertices);
	mem_free(mesh->triangles);
	mem_free(mesh);
}

/* --- what must hold --- */

static void check_object(const struct scene *scene, const struct scene_object *object)
{
	const struct scene_path *path = &object->path;
	const struct soil_shape *shape = &object->shape;
	fuzz_check(object->name != NULL && isfinite(object->sink));
	fuzz_check(path->count > 0 && path->points != NULL);
	fuzz_check(path->timed || (isfinite(path->speed) && path->speed > 0));
	for (size_t i = 0; i < path->count; i++) {
		const struct scene_waypoint *point = &path->points[i];
		fuzz_check(isfinite(point->t) && isfinite(point->x) && isfinite(point->y) && isfinite(point->z));
		fuzz_check(isfinite(point->yaw) && isfinite(point->pitch) && isfinite(point->roll));
		fuzz_check(!path->timed || i == 0 || point->t > point[-1].t);
	}
	if (shape->kind == SOIL_BOX)
		fuzz_check(shape->size[0] > 0 && shape->size[1] > 0 && shape->size[2] > 0);
	else if (shape->kind == SOIL_MESH)
		fuzz_check(object->mesh != NULL && shape->mesh == object->mesh);
	else
		fuzz_check(shape->radius > 0 && isfinite(shape->radius));
	fuzz_check(shape->grousers >= 0 && shape->grousers <= 128 && (shape->grousers == 0) == (shape->grouser_height == 0));
	fuzz_check(shape->grouser_height <= shape->radius && (shape->grousers == 0) == (shape->grouser_thickness == 0));
	fuzz_check(object->load >= 0 && object->load <= 1e9 && object->slip >= -1000 && object->slip < 1);
	fuzz_check((object->load == 0 && object->slip == 0) || scene->model == DEFORM_SCM);
	const struct soil_interface *interface = &object->interface;
	fuzz_check(interface->friction_angle >= 0 && interface->friction_angle < 1.6 && interface->adhesion >= 0 && interface->adhesion <= 1e9);
	fuzz_check((!interface->has_friction && !interface->has_adhesion) || scene->model == DEFORM_SCM);
	fuzz_check(object->load == 0 || (object->sink == 0 && !path->has_z));
}

static void check_soils(const struct scene *scene)
{
	bool moves = scene->model >= DEFORM_SUMNER;
	fuzz_check(scene->model < DEFORM_MODELS && scene->soil_count <= SOIL_CLASSES);
	fuzz_check((scene->soil_count > 0) == moves && (scene->iterations > 0) == moves);
	fuzz_check(!moves || (scene->interval > 0 && scene->depth >= 0));
	fuzz_check(scene->raster_count >= 0 && scene->raster_count <= SOIL_RASTERS && (scene->raster_count == 0 || moves));
	for (int i = 0; i < scene->raster_count; i++)
		fuzz_check(scene->rasters[i].path != NULL && (i == 0 || scene->rasters[i].number > scene->rasters[i - 1].number));
	for (int i = 0; i < 256; i++)
		fuzz_check(scene->soil_class[i] == 0 || (scene->soil_map != NULL && scene->soil_class[i] < scene->soil_count));
	for (int i = 0; i < scene->soil_count; i++) {
		const struct soil_numbers *soil = &scene->soils[i];
		double values[sizeof *soil / sizeof(double)];
		memcpy(values, soil, sizeof values);
		for (size_t k = 0; k < sizeof values / sizeof *values; k++)
			fuzz_check(isnan(values[k]) || (isfinite(values[k]) && (values[k] >= 0 || values[k] == soil->bekker_kc)));
		/* What the model reads is a number. */
		fuzz_check(scene->model != DEFORM_SUMNER || isfinite(soil->compression + soil->theta_in + soil->theta_stop));
		fuzz_check(scene->model == DEFORM_SUMNER || isfinite(soil->cohesion + soil->friction_angle));
		fuzz_check(scene->model != DEFORM_SCM || isfinite(soil->bekker_kc + soil->bekker_kphi + soil->elastic_stiffness + soil->damping));
		fuzz_check(scene->model != DEFORM_SUMNER || (soil->roughness > 0 && soil->roughness <= 0.2));
		fuzz_check(scene->model != DEFORM_SUMNER || (soil->theta_stop >= soil->theta_out && soil->theta_in > 0));
		fuzz_check(scene->model != DEFORM_SLIPPAGE || soil->unit_weight > 0);
		fuzz_check(scene->model != DEFORM_SCM || (soil->bekker_n > 0 && soil->repose > 0 && soil->janosi_shear > 0));
		fuzz_check(scene->model != DEFORM_SCM || soil->bekker_kc > 0 || soil->bekker_kphi > 0);
	}
}

/* One line that a person can read. */
static void check_advice(void *user, const char *text)
{
	fuzz_check(strstr(text, ": ") != NULL && strstr(text, "; ") != NULL);
	for (const char *c = text; *c != '\0'; c++)
		fuzz_check((unsigned char)*c >= 0x20 && *c != 0x7f);
}

static void check_scene(const struct scene *scene)
{
	const struct scene_view *view = &scene->view;
	fuzz_check(isfinite(scene->end_time) && scene->end_time > 0);
	fuzz_check(isfinite(scene->time_step) && scene->time_step > 0);
	fuzz_check(isfinite(scene->gravity) && isfinite(scene->spacing) && isfinite(scene->prefetch));
	fuzz_check(scene->slots >= 4 && scene->loaders <= 16);
	fuzz_check(scene->object_count > 0 || view->present);
	fuzz_check(strlen(scene->hash) == 32);
	for (size_t i = 0; i < scene->object_count; i++)
		check_object(scene, &scene->objects[i]);
	check_soils(scene);
	scene_advise(scene, scene->spacing > 0 ? scene->spacing : 1, check_advice, NULL);
	fuzz_check(scene->forces >= 0 && scene->forces <= 1e6);
	if (!view->present)
		return;
	fuzz_check(view->width > 0 && view->height > 0 && view->images >= 0);
	if (view->aim.kind != SCENE_FIXED)
		fuzz_check(view->aim.object >= 0 && (size_t)view->aim.object < scene->object_count);
	for (int i = 0; i < 3; i++)
		fuzz_check(isfinite(view->aim.eye[i]) && isfinite(view->aim.target[i]));
}

static void check_message(enum status status)
{
	const char *text = failure_message();
	fuzz_check(status == STATUS_INPUT || status == STATUS_USAGE);
	/* Which of the two files, or which setting; and what to do. */
	fuzz_check(strstr(text, "scene.yaml:") != NULL || strstr(text, "poses.csv") != NULL || strstr(text, "--set ") != NULL);
	fuzz_check(strstr(text, "; ") != NULL);
	for (const char *c = text; *c != '\0'; c++)
		fuzz_check((unsigned char)*c >= 0x20 && *c != 0x7f);
}

/* --- the parts of an input --- */

/* Where `line` begins a line of the text; its end if nowhere. */
static char *find_line(char *text, const char *line)
{
	for (char *at = text; (at = strstr(at, line)) != NULL; at++)
		if (at == text || at[-1] == '\n')
			return at;
	return text + strlen(text);
}

static size_t take_settings(char *text, struct scene_setting *settings)
{
	size_t count = 0;
	for (char *line = strtok(text, "\n"); line != NULL && count < SETTINGS_MAX; line = strtok(NULL, "\n")) {
		char *equals = strchr(line, '=');
		if (equals == NULL)
			continue;
		*equals = '\0';
		settings[count++] = (struct scene_setting){line, equals + 1};
	}
	return count;
}

static enum status load(const char *path, const struct scene_setting *settings, size_t count, size_t size,
			struct scene **scene)
{
	fuzz_memory_allow(size * BYTES_A_BYTE + BYTES_MORE);
	loading = true;
	enum status status = scene_load(path, settings, count, scene);
	loading = false;
	fuzz_memory_allow_all();
	fuzz_check((status == STATUS_OK) == (*scene != NULL));
	return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static char first_message[4096];
	struct scene_setting settings[SETTINGS_MAX];
	struct scene *scene, *again;
	char *text = malloc(size + 1);
	fuzz_check(text != NULL);
	memcpy(text, data, size);
	text[size] = '\0';
	/* NUL bytes stay in the scene: without the parts there are none but the last. */
	bool whole = memchr(text, '\0', size) != NULL;
	char *set = whole ? text + size : find_line(text, SCENE_SET);
	char *poses = whole ? text + size : find_line(text, SCENE_POSES);
	char *end = poses < set ? poses : set;
	/* Copies: opening files asks for paths too, and only the last few are kept. */
	char path[128], beside[128];
	snprintf(path, sizeof path, "%s", fuzz_path("scene.yaml"));
	snprintf(beside, sizeof beside, "%s", fuzz_path("poses.csv"));
	fuzz_write(path, text, (size_t)(end - text));
	unlink(beside);
	if (poses < set)
		fuzz_write(beside, poses + strlen(SCENE_POSES), (size_t)(set - poses) - strlen(SCENE_POSES));
	size_t count = *set != '\0' ? take_settings(set + strlen(SCENE_SET), settings) : 0;

	enum status status = load(path, settings, count, size, &scene);
	if (status == STATUS_OK)
		check_scene(scene);
	else
		check_message(status);
	snprintf(first_message, sizeof first_message, "%s", status == STATUS_OK ? "" : failure_message());
	fuzz_check(load(path, settings, count, size, &again) == status);
	if (status == STATUS_OK)
		fuzz_check(strcmp(scene->hash, again->hash) == 0);
	else
		fuzz_check(strcmp(first_message, failure_message()) == 0);
	scene_destroy(scene);
	scene_destroy(again);
	free(text);
	return 0;
}
